"""DXF drawings as CAD programs write them: fills, blocks in arrays, hidden layers, heights, doubled lines."""

import contextlib
import re

import numpy as np
import pytest
from geometry_files import area, domain, read_rings

from bubblemesh.errors import CaseError, GeometryError, LimitError
from bubblemesh.geometry.paths import Arc, Line
from bubblemesh.readers.formats import read_areas
from bubblemesh.readers.lines_and_points import read_lines
from bubblemesh.readers.selection import Selection

SQUARE = [(0, 0), (4, 0), (4, 4), (0, 4)]


@pytest.fixture
def drawn(tmp_path):
    ezdxf = pytest.importorskip("ezdxf")

    def save(draw, version="R2010", form="asc"):
        document = ezdxf.new(version)
        draw(document)
        document.saveas(tmp_path / "a.dxf", fmt=form)
        return tmp_path / "a.dxf"

    return save


def notes_of(path, **options):
    return [note.partition(": ")[2] for note in domain(path, **options).notes]


class TestPolylines:
    """Polylines of all kinds."""

    @pytest.mark.parametrize("heights", [(0, 0, 0, 0), (7, 7, 7, 7), (1, 2, 3, 4)])
    def test_polylines_in_space_are_seen_from_above(self, drawn, heights):
        points = [(x, y, z) for (x, y), z in zip(SQUARE, heights, strict=True)]
        path = drawn(lambda document: document.modelspace().add_polyline3d(points, close=True))
        assert area(path) == pytest.approx(16)
        assert notes_of(path) == (["heights (z) are not used"] if len(set(heights)) > 1 else [])

    @pytest.mark.parametrize("form", ["asc", "bin"])
    def test_old_drawings_in_text_and_binary(self, drawn, form):
        def draw(document):
            document.modelspace().add_polyline2d([(0, 0, 1), (2, 0, 1)], format="xyb", close=True)

        assert area(drawn(draw, "R12", form)) == pytest.approx(np.pi, rel=1e-3)

    def test_vertices_that_shape_a_spline_are_not_drawn(self, drawn):
        def draw(document):
            line = document.modelspace().add_polyline2d([*SQUARE, (9, 9)], close=True)
            line.vertices[-1].dxf.flags = 16

        assert area(drawn(draw, "R12")) == pytest.approx(16)

    def test_a_donut_is_its_middle_circle(self, drawn):
        def draw(document):
            corners = [(0, 0, 0.5, 0.5, 1), (2, 0, 0.5, 0.5, 1)]
            document.modelspace().add_lwpolyline(corners, "xyseb", close=True)

        path = drawn(draw)
        (ring,) = read_rings(path, Selection())
        assert [type(side.curve) for side in ring.sides] == [Arc]
        assert notes_of(path) == ["the width of 1 polyline is not used: their middle lines are"]

    @pytest.mark.parametrize("kind", ["lwpolyline", "hatch", "solid", "edges"])
    def test_what_is_drawn_from_below_is_turned_round(self, drawn, kind):
        def draw(document):
            space, below = document.modelspace(), {"extrusion": (0, 0, -1)}
            if kind == "lwpolyline":
                space.add_lwpolyline([(-5, 0, 0), (-7, 0, -1), (-7, 2, 0)], "xyb", close=True, dxfattribs=below)
            elif kind == "solid":
                space.add_solid([(-5, 0), (-7, 0), (-5, 3), (-7, 3)], dxfattribs=below)
            else:
                hatch = space.add_hatch(dxfattribs=below)
                if kind == "hatch":
                    hatch.paths.add_polyline_path([(-5, 0, 0), (-7, 0, -1), (-7, 2, 0)], is_closed=True)
                else:
                    edges = hatch.paths.add_edge_path()
                    edges.add_line((-5, 0), (-7, 0))
                    edges.add_arc((-7, 1), 1, 90, 270, ccw=False)
                    edges.add_line((-7, 2), (-5, 0))

        x0, _, x1, _ = domain(drawn(draw)).bounds
        assert (x0, x1) == pytest.approx((5, 7 if kind == "solid" else 8), abs=1e-3)

    def test_what_has_no_length_is_counted(self, drawn):
        def draw(document):
            space = document.modelspace()
            space.add_lwpolyline(SQUARE, close=True)
            space.add_line((1, 1), (1, 1))
            space.add_circle((1, 1), 0)
            space.add_lwpolyline([(2, 2), (2, 2)])
            space.add_point((3, 3))

        path = drawn(draw)
        assert area(path) == pytest.approx(16)
        assert notes_of(path) == ["3 duplicate points dropped", "left out: 1 point, 3 empty features"]

    def test_lines_drawn_twice(self, drawn):
        def draw(document):
            space = document.modelspace()
            for (x, y), (u, v) in zip(SQUARE, [*SQUARE[1:], SQUARE[0]], strict=True):
                space.add_line((x, y), (u, v))
            space.add_line((4, 0), (0, 0))
            space.add_line((0, 4), (0, 0), dxfattribs={"layer": "COPY"})
            space.add_arc((2, 2), 1, 0, 180)
            space.add_arc((2, 2), 1, 180, 360)
            space.add_arc((2, 2), 1, 0, 180)

        path = drawn(draw)
        assert area(path) == pytest.approx(16 - np.pi, rel=1e-3)
        assert notes_of(path) == ["3 double lines dropped, the first at (4, 0), and with them 1 label: 'COPY'"]

    def test_circles_and_ellipses_drawn_twice(self, drawn):
        def draw(document):
            space = document.modelspace()
            space.add_circle((0, 0), 5)
            space.add_circle((0, 0), 5, dxfattribs={"layer": "COPY"})
            space.add_circle((2, 0), 1)
            space.add_arc((2, 0), 1 + 1e-10, 90, 270)
            space.add_arc((2, 0), 1, 270, 90)
            space.add_ellipse((-2, 0), (0, 2), 0.5)
            space.add_ellipse((-2, 0), (0, -2), 0.5, np.pi, 3 * np.pi)
            space.add_circle((-2, 0), 0.5)  # an island, not a copy
            space.add_arc((-2, 0), 0.5, 0, 360)

        path = drawn(draw)
        assert area(path, part="largest") == pytest.approx((25 - 1 - 2) * np.pi, rel=2e-3)
        with_label = "dropped, the first at (5, 0), and with them 1 label: 'COPY'"
        assert f"4 double lines {with_label}" in notes_of(path, part="largest")
        assert len(read_areas(path, Selection(part="all"))) == 2
        lines = read_lines(path, Selection())
        assert lines[0].notes == (f"a.dxf: 3 double lines {with_label}",)


class TestSplines:
    """B-splines as programs write them."""

    def test_a_periodic_spline_has_knots_outside(self, drawn):
        turn = np.arange(11) * 2 * np.pi / 8
        points = [(np.cos(t), np.sin(t), 0) for t in turn]

        def draw(document):
            spline = document.modelspace().add_spline()
            spline.control_points, spline.knots, spline.dxf.degree = points, np.arange(15.0) - 3, 3
            spline.dxf.flags = 11

        path = drawn(draw)
        (ring,) = read_rings(path, Selection())
        assert len(ring.sides) == 1
        # A uniform cubic B-spline passes (a + 4 b + c) / 6.
        assert domain(path).bounds[2] == pytest.approx((4 + 2 * np.cos(np.pi / 4)) / 6, rel=1e-3)

    def test_a_closed_spline_of_points_alone(self, drawn):
        def draw(document):
            spline = document.modelspace().add_spline([(0, 0, 0), (2, -1, 0), (4, 0, 0), (2, 3, 0)])
            spline.closed = True

        (ring,) = read_rings(drawn(draw), Selection())
        assert len(ring.sides) <= 2


class TestFills:
    """Hatches, solids, traces: they count where no curves close."""

    def test_boundaries_of_hatches_with_islands(self, drawn):
        def draw(document):
            hatch = document.modelspace().add_hatch(dxfattribs={"layer": "SOIL"})
            hatch.paths.add_polyline_path([(0, 0, 0), (8, 0, 1), (8, 6, 0), (0, 6, 0)], is_closed=True)
            island = hatch.paths.add_edge_path()
            island.add_ellipse((2, 3), (1, 0), 0.5)
            island = hatch.paths.add_edge_path(flags=16)
            island.add_line((5, 2), (6, 2))
            island.add_arc((6, 3), 1, -90, 90)
            island.add_line((6, 4), (5, 4))
            island.add_spline(control_points=[(5, 4), (4.5, 3.5), (4.5, 2.5), (5, 2)], knot_values=[0] * 4 + [1] * 4)

        path = drawn(draw)
        outer, *holes = read_areas(path, Selection())[0].rings
        assert [type(side.curve) for side in outer.sides] == [Line, Arc, Line, Line]
        assert {side.label for ring in (outer, *holes) for side in ring.sides} == {"SOIL"}
        removed = np.pi / 2 + 2 + np.pi / 2 + 0.525
        assert area(path) == pytest.approx(48 + 4.5 * np.pi - removed, rel=1e-3)

    def test_they_are_left_out_beside_curves_that_close(self, drawn):
        def draw(document):
            space = document.modelspace()
            space.add_lwpolyline(SQUARE, close=True)
            space.add_hatch(dxfattribs={"layer": "SOIL"}).paths.add_polyline_path(SQUARE)
            space.add_solid([(0, 0), (1, 0), (0, 1)])

        path = drawn(draw)
        assert notes_of(path) == ["left out: 2 fill elements"]
        assert area(path, layers=("SOIL",)) == pytest.approx(16)
        assert area(path, feature={"type": "SOLID"}) == pytest.approx(0.5)

    def test_they_count_where_curves_do_not_close(self, drawn):
        def draw(document):
            space = document.modelspace()
            space.add_line((-9, 2), (9, 2))
            space.add_hatch().paths.add_polyline_path(SQUARE)

        path = drawn(draw)
        assert area(path) == pytest.approx(16)
        assert notes_of(path)[0].startswith("lines beside fills do not close and are left out (open ends: LINE")

    def test_solids_have_their_corners_crosswise(self, drawn):
        path = drawn(lambda document: document.modelspace().add_trace([(0, 0), (4, 0), (0, 2), (4, 2)]))
        assert area(path) == pytest.approx(8)


class TestBlocks:
    """Blocks in arrays, scaled, nested, of other drawings."""

    def plate(self, document):
        block = document.blocks.new("HOLE")
        block.add_circle((0, 0), 0.5)
        document.modelspace().add_lwpolyline([(-1, -1), (19, -1), (19, 9), (-1, 9)], close=True)
        return document.modelspace()

    def test_arrays(self, drawn):
        def draw(document):
            grid = {"column_count": 4, "column_spacing": 4, "row_count": 3, "row_spacing": 3}
            self.plate(document).add_blockref("HOLE", (1, 1), dxfattribs=grid)

        path = drawn(draw)
        assert domain(path).hole_count == 12
        assert area(path) == pytest.approx(200 - 3 * np.pi, rel=1e-3)

    def test_an_array_without_end_is_refused(self, drawn):
        def draw(document):
            grid = {"column_count": 30_000, "column_spacing": 4, "row_count": 30_000, "row_spacing": 3}
            self.plate(document).add_blockref("HOLE", (1, 1), dxfattribs=grid)

        with pytest.raises(LimitError, match="its blocks draw more than"):
            domain(drawn(draw))

    @pytest.mark.parametrize("form", ["asc", "bin"])
    def test_scales_of_zero_clips_and_doubled_vertices_are_counted(self, drawn, form):
        from ezdxf.xclip import XClip

        def draw(document):
            document.blocks.new("HOLE").add_circle((0, 0), 0.5)
            space = document.modelspace()
            space.add_lwpolyline([SQUARE[0], *SQUARE, SQUARE[-1], SQUARE[0]], close=True)
            for x, key in ((1, "xscale"), (3, "yscale"), (1.5, "zscale")):
                space.add_blockref("HOLE", (x, 3 if x != 1.5 else 1.5)).dxf.__dict__[key] = (
                    0.0  # the library refuses it
                )
            XClip(space.add_blockref("HOLE", (3, 1))).set_block_clipping_path([(-1, 0), (1, 0), (0.5, 0)])

        path = drawn(draw, form=form)
        assert area(path) == pytest.approx(16 - np.pi, rel=1e-2)
        assert notes_of(path) == [
            "2 blocks with a scale of 0 drawn as with 1",
            "1 block drawn whole, since the clip (XCLIP) bounds no area",
            "2 duplicate points dropped, the first at (0, 0)",
        ]

    def test_scales_of_zero_count_as_one(self, drawn):
        def draw(document):
            space = self.plate(document)
            space.add_blockref("HOLE", (1, 1), dxfattribs={"xscale": 2, "yscale": 2, "zscale": 0})
            space.add_blockref("HOLE", (5, 1), dxfattribs={"xscale": 0})

        path = drawn(draw)
        assert area(path) == pytest.approx(200 - 1.25 * np.pi, rel=1e-3)

    def test_blocks_within_blocks_mirrored_and_stretched(self, drawn):
        def draw(document):
            space = self.plate(document)
            outer = document.blocks.new("PAIR")
            outer.add_blockref("HOLE", (1, 0), dxfattribs={"xscale": 2})
            outer.add_lwpolyline([(3, 0, 0), (4, 0, 1), (4, 1, 0)], "xyb", close=True)
            space.add_blockref("PAIR", (9, 4), dxfattribs={"xscale": -1, "rotation": 0})

        path = drawn(draw)
        assert area(path) == pytest.approx(200 - np.pi / 2 - 0.5 - np.pi / 8, rel=1e-3)
        assert domain(path).hole_count == 2

    def test_other_drawings_are_named(self, drawn):
        def draw(document):
            space = self.plate(document)
            document.add_xref_def("site.dwg", "SITE")
            space.add_blockref("SITE", (0, 0))

        (note,) = notes_of(drawn(draw))
        assert note.startswith("1 XREF (another drawing: bind it) not used, the first on layer 0 at (0, 0)")


class TestLayers:
    """Layers that are off, and layers that close."""

    def test_what_is_off_or_frozen_counts_only_where_it_is_chosen(self, drawn):
        def draw(document):
            space = document.modelspace()
            space.add_lwpolyline(SQUARE, close=True, dxfattribs={"layer": "RIM"})
            for name in ("OFF", "COLD"):
                document.layers.add(name)
                space.add_circle((2, 2), 1, dxfattribs={"layer": name})
            document.layers.get("OFF").off()
            document.layers.get("COLD").freeze()
            space.add_circle((2, 2), 0.5, dxfattribs={"invisible": 1})

        path = drawn(draw)
        assert notes_of(path) == ["left out: 3 hidden elements"]
        assert area(path, layers=("COLD",)) == pytest.approx(np.pi, rel=1e-3)

    def test_paper_space_and_viewports_are_left_out(self, drawn):
        def draw(document):
            document.modelspace().add_lwpolyline(SQUARE, close=True)
            document.paperspace().add_lwpolyline([(0, 0), (9, 0), (9, 9)], close=True)
            document.paperspace().add_viewport((2, 2), (4, 4), (0, 0), 5)

        assert area(drawn(draw)) == pytest.approx(16)
        with pytest.raises(
            CaseError, match=r"no curves in its model space; there are some in the paper space \(Layout1\)"
        ):
            domain(drawn(lambda document: document.paperspace().add_lwpolyline(SQUARE, close=True)))

    def test_layers_that_close_are_listed(self, drawn):
        def draw(document):
            space = document.modelspace()
            space.add_lwpolyline(SQUARE, close=True, dxfattribs={"layer": "RIM"})
            space.add_circle((2, 2), 1, dxfattribs={"layer": "BORE"})
            space.add_line((-5, 2), (9, 2), dxfattribs={"layer": "AXIS"})
            space.add_line((2, -5), (2, 9), dxfattribs={"layer": "AXIS"})

        path = drawn(draw)
        with pytest.raises(
            GeometryError, match=r"open ends: .*; layers that close by themselves: RIM, BORE: choose by"
        ):
            domain(path)
        assert area(path, layers=("RIM", "BORE")) == pytest.approx(16 - np.pi, rel=1e-3)


def test_nothing_of_the_library_reaches_the_terminal(drawn, capfd):
    def draw(document):
        space = document.modelspace()
        space.add_lwpolyline(SQUARE, close=True)
        space.add_body()
        document.layers.add("A").dxf.color = 3

    path = drawn(draw)
    path.write_text(path.read_text().replace("AcDbPolyline", "AcDbPoliline"))
    with contextlib.suppress(CaseError, GeometryError):
        domain(path)
    assert capfd.readouterr() == ("", "")


def test_bodies_are_told_with_advice(drawn):
    def draw(document):
        document.modelspace().add_circle((0, 0), 1)
        document.modelspace().add_region().sat = ["400 0 1 0", "End-of-ACIS-data"]

    (note,) = notes_of(drawn(draw, "R2000"))
    assert note == "1 REGION not used, the first on layer 0: explode them to lines and arcs"


def test_what_has_no_extent_is_named_where_nothing_else_is_there(drawn):
    def draw(document):
        space = document.modelspace()
        space.add_circle((3, 4), -1, dxfattribs={"layer": "BORE"})
        space.add_line((1, 2), (1, 2))
        space.add_line((1, 2), (1, 2))

    told = (
        "no curves in its model space; 1 CIRCLE without an extent not used, the first on layer BORE at (3, 4); "
        "2 LINE without an extent not used, the first on layer 0 at (1, 2)"
    )
    with pytest.raises(CaseError, match=re.escape(told)):
        domain(drawn(draw))


def test_a_dwg_is_told(tmp_path):
    pytest.importorskip("ezdxf")
    (tmp_path / "a.dxf").write_bytes(b"AC1032\0\0\0")
    with pytest.raises(CaseError, match="it is a DWG drawing: save it as DXF"):
        domain(tmp_path / "a.dxf")


def test_a_structure_with_faults_is_read_with_a_note_unless_it_is_cut(drawn):
    path = drawn(lambda document: document.modelspace().add_lwpolyline(SQUARE, close=True))
    text = path.read_text()
    path.write_text(text.replace("  0\nENDSEC\n", "", 1))
    assert area(path) == pytest.approx(16)
    for length in (300, len(text) * 2 // 3):
        path.write_text(text[:length])
        with pytest.raises(CaseError, match=r"not a valid DXF drawing: it is cut off: EOF, .* is missing: save"):
            domain(path)


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("number", ["2,5", "2.5.1", "2.5D+0", ""])
def test_a_number_that_is_none_is_told_with_its_line(tmp_path, number, end):
    pytest.importorskip("ezdxf")
    entity = ["0", "CIRCLE", "8", "0", "10", "0.0", "20", "0.0", "40", number]
    lines = ["0", "SECTION", "2", "ENTITIES", *entity, "0", "ENDSEC", "0", "EOF", ""]
    (tmp_path / "a.dxf").write_bytes(end.join(lines).encode())
    told = f"line 14: '{number}' is no number: save it with decimal points, or correct it there"
    with pytest.raises(CaseError, match=re.escape(told)):
        domain(tmp_path / "a.dxf")
