"""Rings and domains from drawings in SVG."""

import re

import numpy as np
import pytest
from geometry_files import SVG, area, domain, read_rings
from sweeps import sweep

from bubblemesh.errors import CaseError, GeometryError
from bubblemesh.geometry import polygonal_copy
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.paths import Bezier
from bubblemesh.readers.formats import read_areas
from bubblemesh.readers.selection import Selection

TRANSFORMS = [
    "rotate(30)",
    "skewX(60)",
    "scale(1 3) rotate(40)",
    "matrix(1 .2 -.9 1.5 3 4)",
    "scale(-1 2) skewY(20)",
    "scale(.05 1) rotate(45)",
]
ROUND_SHAPES = [
    ('<circle cx="5" cy="3" r="2"/>', 4 * np.pi),
    ('<ellipse cx="5" cy="3" rx="2" ry="1"/>', 2 * np.pi),
    ('<rect width="8" height="6" rx="2" ry="1"/>', 48 - 8 + 2 * np.pi),
    ('<path d="M-5 0A5 5 0 0 0 5 0A5 5 0 0 0 -5 0Z"/>', 25 * np.pi),
    ('<path d="M2 0A2 1 0 1 1 0 -1L2 -1Z"/>', 1.5 * np.pi + 2),
]


class TestPictures:
    """SVG."""

    @pytest.fixture(autouse=True)
    def needs(self):
        pytest.importorskip("svgelements")

    def test_y_is_turned_up_transforms_apply_and_lengths_are_the_numbers_of_the_file(self, written):
        path = written("a.svg", SVG.format('<g transform="translate(10 5)"><path d="M0 0 H8 V4 Z"/></g>'))
        (ring,) = read_rings(path, Selection())
        np.testing.assert_allclose(ring.vertices, [(10, -5), (18, -5), (18, -9)], atol=1e-12)

    def test_arcs_circles_and_curves(self, written):
        shapes = (
            '<path d="M0 0 H30 V30 A 10 10 0 0 1 20 40 H0 Z"/><circle cx="5" cy="5" r="2"/>'
            '<path d="M10 10 C 10 20 20 20 20 10 Z"/><path d="M25 20 A 3 1 0 0 1 25 25 Z"/>'
        )
        ((outer, *holes),) = [area.rings for area in read_areas(written("a.svg", SVG.format(shapes)), Selection())]
        assert [type(side.curve).__name__ for side in outer.sides] == ["Line", "Line", "Arc", "Line", "Line"]
        assert sorted(type(hole.sides[0].curve).__name__ for hole in holes) == ["Arc", "Bezier", "Spline"]
        assert Domain.of(outer, []).polygon.area == pytest.approx(1200 - 100 + 25 * np.pi, rel=1e-4)

    @pytest.mark.parametrize(
        ("path", "size"),
        [
            ("M0 0 A0 1 0 0 0 2 0 L2 1Z", 1),
            ("M0 0 A1 0 0 0 0 2 0 L2 1Z", 1),
            ("M0 0 A1 1 0 0 0 0 0 L2 0 L2 1Z", 1),
            ("M0 0 H2 V1 Z M5 5 h2 z", 1),
            ("M0 0 H2 V1 Z M5 5 l2 1 z", 1),
        ],
    )
    def test_arcs_without_a_radius_are_lines_and_what_has_no_area_bounds_nothing(self, path, size, written):
        assert area(written("a.svg", SVG.format(f'<path d="{path}"/>'))) == pytest.approx(size)

    @pytest.mark.parametrize(
        ("shape", "size", "transform"), sweep([(*one, how) for one in ROUND_SHAPES for how in TRANSFORMS], quick=11)
    )
    def test_round_shapes_are_themselves_under_any_transform(self, shape, size, transform, written):
        matrix = pytest.importorskip("svgelements").Matrix(transform)
        drawing = SVG.format(f'<g transform="{transform}">{shape}</g>')
        assert area(written("a.svg", drawing)) == pytest.approx(size * abs(matrix.determinant), rel=2e-4)

    @pytest.mark.parametrize("transform", TRANSFORMS)
    def test_points_of_an_ellipse_are_where_its_transform_takes_them(self, transform, written):
        svgelements = pytest.importorskip("svgelements")
        shape = '<path d="M5 2 A4 1.5 30 1 0 3 4 L4 3 Z"/>'
        plain, moved = (
            Domain.of(*read_rings(written("a.svg", SVG.format(one)), Selection()))
            for one in (shape, f'<g transform="{transform}">{shape}</g>')
        )
        matrix = svgelements.Matrix(transform)
        points = plain.polygon.exterior.coords[:]
        taken = [svgelements.Point(x, -y) * matrix for x, y in points]
        assert moved.nearest(np.array([(p.x, -p.y) for p in taken])).distance.max() < 1e-3

    @pytest.mark.parametrize("more", ['<path d="M5 5h2z"/>', '<rect width="1" height="1" transform="scale(0, 1)"/>'])
    def test_shapes_without_an_area_are_left_out(self, more, written):
        assert area(written("a.svg", SVG.format(f'<rect width="2" height="1"/>{more}'))) == pytest.approx(2)

    def test_a_bezier_curve_is_followed(self, written):
        (ring,) = read_rings(written("a.svg", SVG.format('<path d="M0 0 C 0 20 20 20 20 0 Z"/>')), Selection())
        t = np.linspace(0, 1, 1001)[:, None]
        exact = 3 * t * (1 - t) ** 2 * [0, -20] + 3 * t**2 * (1 - t) * [20, -20] + t**3 * [20, 0]
        away = Domain.of(ring).nearest(exact).distance
        assert away.max() < 1e-12

    def test_outlines_of_curves_are_made_once(self, written, monkeypatch):
        made, outlines_of = [], polygonal_copy.outlines_of
        monkeypatch.setattr(polygonal_copy, "outlines_of", lambda rings: made.extend(rings) or outlines_of(rings))
        drops = " ".join(f"M{x} 0 C {x} 2 {x + 2} 2 {x + 2} 0 Z" for x in range(0, 30, 3))
        path = written("a.svg", SVG.format(f'<path d="{drops}"/>'))
        assert len(read_areas(path, Selection(part="all"))) == 10
        assert len(made) == 10

    def test_bezier_curves_stay_what_they_are(self, written):
        d = "M0 0 Q 3 6 6 0 T 12 0 C 12 9 6 9 6 6 S 0 9 0 0 Z"
        (ring,) = read_rings(written("a.svg", SVG.format(f'<path d="{d}"/>')), Selection())
        assert [type(side.curve) for side in ring.sides] == [Bezier] * 4
        expected = [
            [(0, 0), (2, -4), (4, -4), (6, 0)],
            [(6, 0), (8, 4), (10, 4), (12, 0)],
            [(12, 0), (12, -9), (6, -9), (6, -6)],
            [(6, -6), (6, -3), (0, -9), (0, 0)],
        ]
        np.testing.assert_allclose([side.curve for side in ring.sides], expected, atol=1e-12)

    @pytest.mark.parametrize("d", ["M0 0 C 0 0 8 0 8 8 H0 Z", "M0 0 C 8 8 -2 8 6 0 V9 H0 Z"])
    def test_a_bezier_curve_that_stops_is_followed_by_splines(self, written, d):
        areas = read_areas(written("a.svg", SVG.format(f'<path d="{d}"/>')), Selection(part="largest"))
        (ring,) = areas[0].rings
        assert "Spline" in {type(getattr(side.curve, "curve", side.curve)).__name__ for side in ring.sides}

    def test_bezier_curves_join_either_way_and_their_ends_close_gaps(self, written):
        one, other = "M0 0 C 0 4 8 4 8 0", "M0.02 0 C 0 -4 8 -4 8.02 0"
        shapes = f'<g fill="none" stroke="red"><path d="{one}"/><path d="{other}"/></g>'
        (ring,) = read_rings(written("a.svg", SVG.format(shapes)), Selection(join=0.1))
        first, second = (np.array(side.curve) for side in ring.sides)
        np.testing.assert_allclose(first, [(0.01, 0), (0.01, -4), (8.01, -4), (8.01, 0)], atol=1e-12)
        np.testing.assert_allclose(second, [(8.01, 0), (7.99, 4), (-0.01, 4), (0.01, 0)], atol=1e-12)

    def test_bezier_curves_given_twice_count_once(self, written):
        one, other = "M0 0 C 0 4 8 4 8 0", "M0 0 C 0 -4 8 -4 8 0"
        back = "M8 0 C 8 4 0 4 0 0"
        paths = "".join(f'<path d="{d}"/>' for d in (one, other, back))
        shapes = f'<g fill="none" stroke="red">{paths}</g>'
        (ring,) = read_rings(written("a.svg", SVG.format(shapes)), Selection())
        assert len(ring.sides) == 2

    def test_names_of_elements_groups_and_layers_are_labels(self, written):
        text = """
          <g inkscape:groupmode="layer" inkscape:label="Umriß" id="layer1"><path id="path10" d="M0 0 H30 V30 H0 Z"/>
            <g id="g5"><path id="path12-3" inkscape:label="Bohrung" d="M1 1 H2 V2 Z"/></g>
            <circle id="vent" class="round" cx="5" cy="5" r="1"/>
            <g id="slots"><rect class="cls-1" x="10" y="10" width="3" height="2"/>
              <rect class="wide cls-1" x="15" y="10" width="3" height="2"/></g>
            <use id="pin" href="#proto" x="20" y="20"/>
          </g>
          <g inkscape:groupmode="layer" inkscape:label="Layer 2"><circle id="circle9" cx="25" cy="10" r="1"/></g>
          <defs><circle id="proto" r="1"/></defs>"""
        head = SVG.replace("<svg", '<svg xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"')
        path = written("a.svg", head.format(text))
        ((outer, *holes),) = [area.rings for area in read_areas(path, Selection())]
        assert {side.label for side in outer.sides} == {"Umriß"}
        found = [{side.label for side in hole.sides} for hole in holes]
        assert sorted(str(*labels) for labels in found) == ["Bohrung", "None", "pin", "slots", "vent", "wide"]
        assert area(path, layers=("slots",), feature={"label": "wide"}) == pytest.approx(6)
        assert area(path, feature={"id": "vent"}) == pytest.approx(np.pi, rel=1e-3)
        assert area(path, feature={"class": "wide cls-1"}) == pytest.approx(6)
        with pytest.raises(CaseError, match="no layer 'Umriss': did you mean 'Umriß'"):
            area(path, layers=("Umriss",))

    def test_sides_of_a_ring_may_be_paths_of_their_own(self, written):
        text = '<path id="inflow" d="M0 0 V10"/><path id="walls" d="M0 10 H20 M20 0 H0"/><path id="out" d="M20 10 V0"/>'
        found = domain(written("a.svg", SVG.format(text))).boundary
        sides = [(found.labels[k], length) for k, length in zip(found.label, found.lengths, strict=True)]
        assert sorted(sides) == [("inflow", 10), ("out", 10), ("walls", 20), ("walls", 20)]

    @pytest.mark.parametrize("how", ["style='display:none'", "opacity='0'", "style='opacity:0.0%'"])
    def test_what_is_hidden_is_noted(self, written, how):
        text = f'<circle id="c" cx="5" cy="5" r="2"/><g {how}><circle id="old" cx="5" cy="5" r="1"/></g>'
        plate = domain(written("a.svg", SVG.format(text)))
        assert plate.hole_count == 0
        assert plate.notes == ("a.svg: left out: 1 hidden element",)

    @pytest.mark.parametrize("shape", ['<path id="a" d="M1 1"/>', '<path id="a" d="M1 1 L1 1"/>'])
    def test_what_has_no_extent_is_noted(self, written, shape):
        plate = domain(written("a.svg", SVG.format(shape + '<circle cx="5" cy="5" r="2"/>')))
        assert plate.notes == ("a.svg: left out: 1 empty feature",)

    def test_zero_is_not_negative(self, written):
        with pytest.raises(GeometryError, match=r"open ends: feature 0 \(path\) at \(0, 0\), "):
            domain(written("a.svg", SVG.format('<path fill="none" stroke="red" d="M0 0 H4 V2"/>')))

    def test_what_bounds_nothing_is_noted(self, written):
        path = written("a.svg", SVG.format('<circle cx="5" cy="5" r="2"/><text id="t" x="1" y="2">A</text>'))
        assert domain(path).notes == ("a.svg: 1 text not used",)

    @pytest.mark.parametrize(
        ("content", "message"),
        [
            *(("", "no closed paths or shapes"), ("<path d='M0 0 L", "not valid XML"), ("<g>", "not valid XML")),
            *(
                (
                    f'<g transform="scale(2) {step}"><rect width="1" height="1"/></g>',
                    rf"g in line \d: its transform is not valid: '{re.escape(step)}': correct it",
                )
                for step in ("rotate(foo)", "rotate()", "matrix(1 2 3)", "translate(1,2,3)", "skewX(1 2)")
            ),
        ],
    )
    def test_faulty_pictures_are_refused(self, written, content, message):
        with pytest.raises(CaseError, match=message):
            domain(written("a.svg", SVG.format(content)))
