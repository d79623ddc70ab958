"""Rings and domains from drawings in DXF."""

import re

import numpy as np
import pytest
from geometry_files import area, domain, read_rings

from bubblemesh.case import load_case
from bubblemesh.errors import CaseError, FileError, GeometryError
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.paths import Arc, Bezier, Ellipse, Line, Spline
from bubblemesh.readers.formats import read_areas
from bubblemesh.readers.selection import Selection


class TestDrawings:
    """DXF."""

    @pytest.fixture
    def drawn(self, tmp_path):
        ezdxf = pytest.importorskip("ezdxf")

        def save(draw, unit=0):
            document = ezdxf.new()
            document.header["$INSUNITS"] = unit
            draw(document)
            document.saveas(tmp_path / "a.dxf")
            return tmp_path / "a.dxf"

        return save

    def test_all_curves_are_read_as_curves_and_layers_become_labels(self, drawn):
        def draw(document):
            space = document.modelspace()
            space.add_lwpolyline(
                [(0, 0, 0), (10, 0, 1), (10, 6, 0), (0, 6, 0)], "xyb", close=True, dxfattribs={"layer": "RIM"}
            )
            space.add_circle((2, 2), 0.5, dxfattribs={"layer": "BORE"})
            space.add_ellipse((5, 3), (0, 1), 0.5)
            space.add_ellipse((8, 3), (1, 0), 0.5, 0, np.pi)
            space.add_line((9, 3), (7, 3))
            space.add_arc((4, 5), 0.3, 0, 180)
            space.add_arc((4, 5), 0.3, 180, 360)
            space.add_polyline2d([(3, 1, 0), (4, 1, 1), (4, 1.5, 0)], format="xyb").close()
            # As seen from below, x is turned round.
            space.add_arc((-7.5, 1), 0.3, 0, 180, dxfattribs={"extrusion": (0, 0, -1)})
            space.add_arc((7.5, 1), 0.3, 180, 360)

        ((outer, *holes),) = [area.rings for area in read_areas(drawn(draw), Selection())]
        assert [type(side.curve) for side in outer.sides] == [Line, Arc, Line, Line]
        assert {side.label for side in outer.sides} == {"RIM"}
        kinds = sorted("+".join(type(side.curve).__name__ for side in hole.sides) for hole in holes)
        assert kinds == ["Arc", "Arc", "Arc", "Ellipse", "Line+Arc+Line", "Spline+Line"]
        assert {side.label for hole in holes for side in hole.sides} == {"BORE", None}
        removed = np.pi * (0.25 + 0.5 + 0.25 + 0.09 + 0.09 + 1 / 32) + 0.25
        assert Domain.of(outer, holes).polygon.area == pytest.approx(60 + 4.5 * np.pi - removed, rel=1e-3)

    def test_an_ellipse_keeps_its_axes(self, drawn):
        path = drawn(lambda document: document.modelspace().add_ellipse((5, 3), (0, 2), 0.5))
        (ring,) = read_rings(path, Selection())
        assert isinstance(ring.sides[0].curve, Ellipse)
        assert domain(path).bounds == pytest.approx((4, 1, 6, 5), abs=1e-3)

    def test_splines_are_followed(self, drawn):
        turn = np.linspace(0, 2 * np.pi, 30)
        points = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])

        def draw(document):
            document.modelspace().add_spline(points[:20])
            document.modelspace().add_rational_spline([points[19], (1.2, -1.2), (1.2, -0.5), points[0]], [1, 2, 2, 1])

        (ring,) = read_rings(drawn(draw), Selection())
        assert [type(side.curve) for side in ring.sides] == [Spline, Spline]
        radii = np.hypot(*ring.sides[0].curve.knots.T)
        np.testing.assert_allclose(radii, 1, atol=3e-3)

    @pytest.mark.parametrize("together", [True, False])
    def test_bezier_curves_are_exact(self, drawn, together):
        """As programs for drawing export them: one spline for each, or one whose inner knots count four times."""
        k = 4 / 3 * np.tan(np.pi / 8)
        turn = np.array([[0, -1], [1, 0]])
        fours = [np.array([(1, 0), (1, k), (k, 1), (0, 1)]) @ np.linalg.matrix_power(turn.T, n) for n in range(4)]

        def draw(document):
            if together:
                knots = np.repeat(range(5), 4).tolist()
                document.modelspace().add_open_spline(np.concatenate(fours).tolist(), knots=knots)
            else:
                for four in fours:
                    document.modelspace().add_open_spline(four.tolist())

        (ring,) = read_rings(drawn(draw), Selection())
        assert [type(side.curve) for side in ring.sides] == [Bezier] * 4
        found = sorted(sorted(map(tuple, np.round(side.curve, 12).tolist())) for side in ring.sides)
        assert found == sorted(sorted(map(tuple, np.round(four, 12).tolist())) for four in fours)

    @pytest.mark.parametrize("times", [3, 4])
    def test_control_points_that_are_one_place_are_corners(self, drawn, times):
        corners = [(0, 0), (3, 0), (3, 2), (0, 2), (0, 0)]
        controls = [corner for corner in corners for _ in range(times)]
        (ring,) = read_rings(drawn(lambda d: d.modelspace().add_open_spline(controls)), Selection())
        assert [type(side.curve) for side in ring.sides] == [Line] * 4
        np.testing.assert_allclose(sorted(np.round(ring.vertices, 9).tolist()), sorted(corners[:-1]), atol=1e-9)

    def test_parts_of_a_spline_that_are_a_point_are_left_out(self, drawn):
        """As some programs end one: with control points that are one place, times a number that is rounded."""
        x, y = -34.3655, -76.0581
        four = [(x, y), (x + 1, y + 1), (x + 3, y + 1), (x + 4, y), (x + 3, y - 2), (x + 1, y - 2)]
        knots = np.repeat([0, 1, 2, 3], 4).tolist()
        controls = [*four[:4], four[3], *four[4:], four[0], *[(x, y)] * 4]
        (ring,) = read_rings(drawn(lambda d: d.modelspace().add_open_spline(controls, knots=knots)), Selection())
        assert [type(side.curve) for side in ring.sides] == [Bezier] * 2

    def test_a_spline_may_be_bent_between_corners(self, drawn):
        controls = [(0, 0), *[(4, 0)] * 3, (4, 1), (3, 3), (0, 4), (0, 0)]
        (ring,) = read_rings(drawn(lambda d: d.modelspace().add_open_spline(controls)), Selection())
        assert [type(side.curve) for side in ring.sides] == [Line, Spline]
        np.testing.assert_allclose(ring.vertices, [(0, 0), (4, 0)], atol=1e-12)

    def test_blocks_are_resolved(self, drawn):
        def draw(document):
            block = document.blocks.new("B")
            block.add_lwpolyline([(0, 0), (1, 0), (1, 1)], close=True)
            document.modelspace().add_blockref("B", (6, 1), dxfattribs={"xscale": 2, "rotation": 90})

        assert area(drawn(draw)) == pytest.approx(1)

    @pytest.mark.parametrize("extrusion", [1, -1])
    @pytest.mark.parametrize("center", [(0, 0), (400, 500)])
    @pytest.mark.parametrize(
        "turn", [(0, 360), (90, 450), (0, -360), (37, 397), (90, 90 + 360 * (1 - 1e-12)), (0, 360 * (1 + 1e-12))]
    )
    def test_an_arc_of_a_full_turn_is_closed(self, drawn, turn, center, extrusion):
        path = drawn(
            lambda document: document.modelspace().add_arc(
                center, 0.3, *turn, dxfattribs={"extrusion": (0, 0, extrusion)}
            )
        )
        assert area(path) == pytest.approx(0.09 * np.pi, rel=1e-3)

    def test_an_arc_of_a_full_turn_is_a_hole_and_not_skipped(self, drawn):
        def draw(document):
            document.modelspace().add_lwpolyline([(-2, -2), (2, -2), (2, 2), (-2, 2)], close=True)
            document.modelspace().add_arc((0, 0), 1, 0, 360)

        plate = domain(drawn(draw), open="skip")
        assert plate.polygon.area == pytest.approx(16 - np.pi, rel=1e-3)
        assert plate.notes == ()

    @pytest.mark.parametrize("turn", [(0, 1), (0.25, 1.25), (0, 1 + 1e-12), (0, 1 - 1e-12)])
    def test_an_ellipse_of_a_full_turn_is_whole(self, drawn, turn):
        begin, end = 2 * np.pi * np.array(turn)
        path = drawn(lambda document: document.modelspace().add_ellipse((5, 3), (0, 2), 0.5, begin, end))
        (ring,) = read_rings(path, Selection())
        assert [type(side.curve) for side in ring.sides] == [Ellipse]

    def test_an_arc_is_joined_with_itself(self, drawn):
        path = drawn(lambda document: document.modelspace().add_arc((0, 0), 1, 0, 359.9999))
        ring = domain(path, join=1e-5)
        assert ring.notes == ("a.dxf: 1 gap joined, the widest (1.75e-06) at (1, 0)",)
        assert ring.polygon.area == pytest.approx(np.pi, rel=1e-3)

    def test_a_short_arc_that_is_joined_with_itself_is_nothing(self, drawn):
        def draw(document):
            document.modelspace().add_circle((0, 0), 1)
            document.modelspace().add_arc((0, 0), 0.5, 0, 1)

        ring = domain(drawn(draw), join=0.01)
        assert ring.polygon.area == pytest.approx(np.pi, rel=1e-3)
        assert any("1 flat ring dropped" in note for note in ring.notes)

    def test_gaps_are_joined_within_a_tolerance_only(self, drawn):
        def draw(document):
            space = document.modelspace()
            space.add_line((0, 0), (4, 0))
            space.add_arc((4, 2), 2, -90, 90)
            space.add_line((4, 4.01), (0, 4))
            space.add_line((0, 4), (0, 0))

        path = drawn(draw)
        with pytest.raises(GeometryError, match=r"open ends: ARC .* at \(4, 4\), LINE .* at \(4, 4.01\).* set join"):
            domain(path)
        plate = domain(path, join=0.1)
        assert plate.notes == ("a.dxf: 1 gap joined, the widest (0.01) at (4, 4)",)
        assert plate.polygon.area == pytest.approx(16 + 2 * np.pi, rel=5e-3)

    def test_nothing_is_skipped_in_silence(self, drawn):
        def draw(document):
            space = document.modelspace()
            space.add_circle((0, 0), 1)
            space.add_text("A", dxfattribs={"insert": (3, 4), "layer": "NOTES"})
            space.add_circle((5, 5), 1, dxfattribs={"extrusion": (1, 0, 0)})

        notes = domain(drawn(draw)).notes
        assert "a.dxf: 1 TEXT not used, the first on layer NOTES at (3, 4)" in notes
        turned = r"1 CIRCLE not used, .*: it is turned out of the plane of the drawing$"
        assert any(re.search(turned, note) for note in notes)

    def test_layers_are_chosen(self, drawn):
        def draw(document):
            for radius, layer in ((3, "A"), (2, "B"), (1, "C")):
                document.modelspace().add_circle((0, 0), radius, dxfattribs={"layer": layer})

        assert area(drawn(draw), layers=("A", "C")) == pytest.approx(8 * np.pi, rel=1e-3)
        with pytest.raises(CaseError, match="no layer 'D': allowed: A, B, C"):
            area(drawn(draw), layers=("D",))
        with pytest.raises(CaseError, match="no layer 'c': did you mean 'C'"):
            area(drawn(draw), layers=("c",))

    def test_a_layer_may_be_a_whole_number_and_inches_have_two_names(self, drawn):
        path = drawn(lambda document: document.modelspace().add_circle((0, 0), 1))
        for layer in ("0", "[0]", "'0'"):
            case = load_case("a.yaml", text=f"domain: {{file: {path}, layer: {layer}}}\nspacing: 1\n")
            assert case.domain.layer == ("0",)
        case = load_case("a.yaml", text=f"domain: {{file: {path}, units: inch}}\nspacing: 1\n")
        assert case.domain.units == "in"

    def test_a_unit_that_the_header_contradicts_is_noted(self, drawn):
        path = drawn(lambda document: document.modelspace().add_circle((0, 0), 1), unit=4)
        assert domain(path, unit="mm").notes == ()
        assert "its header gives lengths in mm, the case in in" in domain(path, unit="in").notes[0]

    def test_what_is_no_drawing_is_refused(self, written):
        pytest.importorskip("ezdxf")
        with pytest.raises((CaseError, FileError), match=r"a\.dxf: not a"):
            domain(written("a.dxf", "hello"))
        with pytest.raises(CaseError, match="there are no curves"):
            domain(written("a.dxf", "0\nSECTION\n2\nENTITIES\n0\nENDSEC\n0\nEOF\n"))
