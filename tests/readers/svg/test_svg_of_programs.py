"""SVG drawings as programs write them: logos, icons, maps, layers of Inkscape, style sheets of Illustrator."""

import re

import numpy as np
import pytest
import shapely
from geometry_files import area, domain, read_rings

from bubblemesh.errors import CaseError, LimitError
from bubblemesh.geometry.paths import Arc, Line
from bubblemesh.readers.formats import read_areas
from bubblemesh.readers.selection import Selection

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" {}>{}</svg>'
OUTER, INNER, AGAIN = "M0 0H20V20H0Z", "M6 6H14V14H6Z", "M6 6V14H14V6Z"  # the inner one turns as the outer, or against


@pytest.fixture(autouse=True)
def needs():
    pytest.importorskip("svgelements")


def drawing(written, content, head='viewBox="0 0 24 24"'):
    return written("a.svg", HEAD.format(head, content))


def notes_of(path, **options):
    return [note.partition(": ")[2] for note in domain(path, **options).notes]


class TestFills:
    """Which subpaths bound what is filled."""

    @pytest.mark.parametrize(
        ("inner", "more", "expected"),
        [
            (INNER, "", 400),
            (AGAIN, "", 336),
            (INNER, 'fill-rule="evenodd"', 336),
            (INNER, 'style="fill-rule: evenodd"', 336),
            (INNER, 'class="logo"', 336),
            (INNER, 'fill="none" stroke="red"', 336),
        ],
    )
    def test_the_rule_tells_what_is_a_hole(self, written, inner, more, expected):
        sheet = "<style>.other, path.logo { fill-rule: evenodd }</style>"
        path = drawing(written, f'{sheet}<path {more} d="{OUTER}{inner}"/>')
        assert area(path) == pytest.approx(expected)
        note = "feature 0 (path): 1 subpath within what is filled left out, by fill-rule nonzero"
        assert notes_of(path) == ([note] if expected == 400 else [])

    def test_subpaths_that_overlap_are_united(self, written):
        path = drawing(written, '<path d="M0 0H20V20H0ZM12 12H28V28H12Z"/>')
        assert area(path) == pytest.approx(400 + 256 - 64)
        assert "subpaths that cross are united by fill-rule nonzero: what they bound is 1 ring" in notes_of(path)[0]

    def test_curves_that_cross_stay_curves(self, written):
        discs = "".join(f"M{x} 10a5 5 0 0 1 10 0a5 5 0 0 1 -10 0Z" for x in (2, 8))
        path = drawing(written, f'<path id="rim" d="{discs}"/>')
        (ring,) = read_rings(path, Selection())
        assert {type(side.curve) for side in ring.sides} == {Arc}
        assert {side.label for side in ring.sides} == {"rim"}
        lens = 2 * 25 * np.arccos(0.6) - 6 * 4
        assert area(path) == pytest.approx(50 * np.pi - lens, rel=1e-3)
        path = drawing(written, f'<path fill-rule="evenodd" d="{discs}"/>')
        assert area(path, part="all") == pytest.approx(50 * np.pi - 2 * lens, rel=1e-3)

    def test_a_loop_of_one_curve_that_crosses_itself(self, written):
        path = drawing(written, '<path d="M4 20C40 -10 -16 -10 20 20Z"/>')
        rings = read_rings(path, Selection())
        assert sorted({type(side.curve).__name__ for side in ring.sides} == {"CurveSection"} for ring in rings) == [
            False,
            True,
        ]
        t = np.linspace(0, 1, 20_001)
        x = 4 * (1 - t) ** 3 + 120 * t * (1 - t) ** 2 - 48 * t**2 * (1 - t) + 20 * t**3
        y = 20 * (1 - t) ** 3 - 30 * t * (1 - t) ** 2 - 30 * t**2 * (1 - t) + 20 * t**3
        faces = shapely.polygonize([shapely.node(shapely.LinearRing(np.column_stack([x, y])))])
        assert area(path, part="all") == pytest.approx(faces.area, rel=1e-3)

    def test_subpaths_that_nearly_touch_are_united_with_straight_lines(self, written):
        path = drawing(written, '<path d="M0 0H10V10H0ZM10.000001 2H20V8H9Z"/>')
        assert "of straight lines, since" in notes_of(path)[0]
        assert area(path) == pytest.approx(100 + 60, rel=0.05)

    def test_subpaths_that_cross_too_often_are_refused(self, written):
        points = np.random.default_rng(0).random((500, 2)) * 20
        path = drawing(written, f'<path d="M{"L".join(f"{x:.4f} {y:.4f}" for x, y in points)}Z"/>')
        with pytest.raises(LimitError, match="its subpaths cross in more than 20,000 places: simplify it"):
            area(path)

    def test_a_star_drawn_in_one_line(self, written):
        turn = np.radians(90 + 144 * np.arange(5))
        points = " ".join(f"{x},{y}" for x, y in np.column_stack([np.cos(turn), -np.sin(turn)]) * 10 + 12)
        path = drawing(written, f'<polygon points="{points}"/>')
        tips = np.radians(90 + 36 * np.arange(10))
        inner = 10 * np.cos(np.radians(72)) / np.cos(np.radians(36))
        radii = np.where(np.arange(10) % 2, inner, 10)
        x, y = radii * np.cos(tips), radii * np.sin(tips)
        star = abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2
        assert area(path) == pytest.approx(star)
        assert len(read_rings(path, Selection())[0].vertices) == 10

    def test_curves_stay_curves_where_nothing_crosses(self, written):
        path = drawing(written, '<path d="M0 0H20V20H0Z M10 6A4 4 0 0 0 10 14A4 4 0 0 0 10 6Z"/>')
        outer, hole = read_areas(path, Selection())[0].rings
        assert {type(side.curve) for side in outer.sides} == {Line}
        assert {type(side.curve) for side in hole.sides} == {Arc}

    def test_open_subpaths_close_where_they_are_filled(self, written):
        path = drawing(written, '<path d="M0 0H20V20H0"/><polyline points="2,2 6,2 6,6"/>')
        assert area(path) == pytest.approx(400 - 8)
        widest = "2 open subpaths closed straight, as what is filled is, the widest gap (20) at (0, -20)"
        assert notes_of(path) == [widest]

    def test_filled_sides_that_join_are_not_closed(self, written):
        path = drawing(written, '<path d="M0 0C5 5 15 5 20 0"/><path d="M20 0V20H0V0"/>')
        (ring,) = read_rings(path, Selection())
        assert len(ring.sides) == 4

    def test_what_is_not_painted_is_hidden(self, written):
        frame = '<path d="M0 0h24v24H0z" fill="none"/>'
        path = drawing(written, frame + '<circle cx="12" cy="12" r="5"/>')
        assert area(path) == pytest.approx(25 * np.pi, rel=1e-3)
        assert notes_of(path) == ["left out: 1 hidden element"]
        assert area(drawing(written, frame)) == pytest.approx(576)


class TestSizes:
    """Lengths in metres by the size on paper."""

    @pytest.mark.parametrize(
        ("head", "millimetres"),
        [
            ('width="80mm" height="80mm" viewBox="0 0 40 40"', 2),
            ('width="8cm" viewBox="-5 -5 40 40"', 2),
            ('height="2in" viewBox="0 0 40 50.8"', 1),
            ('height="2in" viewBox="0-0+40,50.8"', 1),
            ('width="72pt" height="100" viewBox="0 0 127 127"', 0.2),
            ('width="80mm" height="40mm" viewBox="0 0 40 40"', 1),
            ('width="80mm" height="40mm" viewBox="0 0 40 40" preserveAspectRatio="xMidYMid slice"', 2),
        ],
    )
    def test_width_and_height_tell_it(self, written, head, millimetres):
        path = drawing(written, '<rect width="20" height="30"/>', head)
        assert area(path, unit="mm") == pytest.approx(600e-6 * millimetres**2)
        assert area(path, unit="in") == pytest.approx(600e-6 * millimetres**2)
        assert area(path) == pytest.approx(600)
        assert notes_of(path, unit="mm") == []

    @pytest.mark.parametrize(
        ("head", "stretch", "millimetres"),
        [
            ('width="100mm" height="100mm" viewBox="0 0 50 25"', 2, 2),
            ('width="100mm" height="10cm" viewBox="0 0 50 100"', 0.5, 2),
            ('width="9.6" height="50.8mm" viewBox="0 0 25.4 25.4"', 20, 0.1),
            ('width="50.8mm" viewBox="0 0 25.4 25.4"', 1, 2),
            ('width="0.3mm" height="0.1mm" viewBox="0 0 3 1"', 1, 0.1),
        ],
    )
    def test_a_drawing_may_fill_its_box(self, written, head, stretch, millimetres):
        path = drawing(written, '<rect width="20" height="10"/>', f'{head} preserveAspectRatio="none"')
        assert domain(path).bounds == pytest.approx((0, -10 * stretch, 20, 0))
        assert area(path, unit="mm") == pytest.approx(200e-6 * stretch * millimetres**2)
        note = f"its y are stretched by {stretch}, since preserveAspectRatio is none"
        assert notes_of(path, unit="mm") == ([note] if stretch != 1 else [])

    @pytest.mark.parametrize("head", ["", 'width="80mm"', 'viewBox="0 0 40 40"', 'width="40" viewBox="0 0 40 40"'])
    def test_else_96_pixels_are_an_inch_with_a_note(self, written, head):
        path = drawing(written, '<rect width="96" height="96"/>', head)
        assert area(path, unit="mm") == pytest.approx(0.0254**2)
        (note,) = notes_of(path, unit="mm")
        assert "96 of its lengths are an inch; if they are in mm, set scale: 0.001 in place of units" in note
        assert area(path, scale=0.001) == pytest.approx(0.096**2)


class TestStructure:
    """Uses, symbols, nested drawings, clips, switches."""

    def test_symbols_are_drawn_where_they_are_used(self, written):
        path = drawing(
            written,
            '<symbol id="s" viewBox="0 0 10 10"><rect x="1" y="1" width="8" height="8"/></symbol>'
            '<use xlink:href="#s" x="4" y="6" width="5" height="5"/><g transform="translate(10 0) scale(2)">'
            '<use href="#s" width="5" height="5"/></g>',
        )
        rings = read_rings(path, Selection())
        corners = [sorted(ring.vertices)[0] + sorted(ring.vertices)[-1] for ring in rings]
        np.testing.assert_allclose(corners, [(4.5, -10.5, 8.5, -6.5), (11, -9, 19, -1)])

    @pytest.mark.parametrize("box", ["0 0 100 100", "0 0 100+100"])
    def test_nested_drawings_have_their_own_box(self, written, box):
        path = drawing(
            written,
            f'<svg x="10" y="10" width="10" height="10" viewBox="{box}"><rect width="50%" height="50%"/></svg>',
            f'viewBox="{box}"',
        )
        assert domain(path).bounds == pytest.approx((10, -15, 15, -10))

    def test_definitions_markers_masks_and_alternatives_are_not_drawn(self, written):
        unseen = '<rect x="30" width="5" height="5"/>'
        tags = ("defs", "symbol", "marker", "mask", "clipPath", "pattern", "metadata")
        content = "".join(f"<{tag}>{unseen}</{tag}>" for tag in tags)
        content += (
            f'<switch><foreignObject requiredExtensions="x">{unseen}</foreignObject><g><rect width="9" height="9"/>'
        )
        path = drawing(written, content + f"</g><g>{unseen}</g></switch>")
        assert area(path) == pytest.approx(81)
        assert notes_of(path) == []

    def test_masks_and_texts_and_images_are_counted(self, written):
        path = drawing(
            written,
            '<mask id="c"><rect width="1" height="1"/></mask><g mask="url(#c)"><rect width="9" height="9"/></g>'
            '<text x="1" y="1">A</text><text>B</text><image width="5" height="5" href="a.png"/>',
        )
        assert area(path) == pytest.approx(81)
        assert notes_of(path) == [
            "2 texts not used",
            "1 image not used",
            "1 shape under a mask used whole: masks are not applied",
        ]

    def test_styles_of_ancestors_hide(self, written):
        path = drawing(
            written,
            "<style>g.off path, #gone { display: none } .ghost { visibility: hidden } g > .seen { fill: red }</style>"
            '<g class="off"><path d="M1 1H2V2Z"/></g><g id="gone"><rect width="50" height="50"/></g>'
            '<g class="ghost"><circle r="3"/><rect visibility="visible" width="8" height="8"/></g>',
        )
        assert area(path) == pytest.approx(64)
        assert notes_of(path) == ["left out: 3 hidden elements"]

    def test_lengths_may_have_units_and_percents(self, written):
        path = drawing(written, '<rect width="50%" height="0.25in"/>', 'width="80mm" height="40mm" viewBox="0 0 40 20"')
        assert area(path) == pytest.approx(20 * 24)

    def test_groups_and_shapes_are_transformed_from_the_inside_out(self, written):
        path = drawing(written, '<g transform="rotate(90)"><rect transform="translate(3,0)" width="2" height="1"/></g>')
        assert domain(path).bounds == pytest.approx((-1, -5, 0, -3))

    @pytest.mark.parametrize(
        ("given", "bounds"),
        [
            ('style="transform: scale(2)"', (0, -2, 4, 0)),
            ('style="transform: rotate(90deg) translateX(3px)"', (-1, -5, 0, -3)),
            ('style="transform: none" transform="scale(2)"', (0, -1, 2, 0)),
            ('style="translate: 3px 1px; scale: 2" transform="scale(2 1)"', (3, -3, 11, -1)),
            ('class="moved" transform="scale(2)"', (10, -1, 12, 0)),
            ('class="moved" style="transform: translate(1px)"', (1, -1, 3, 0)),
            ('transform="rotate(90)" transform-origin="2 1"', (2, -1, 3, 1)),
            ('style="transform: scale(2); transform-origin: 2px 0"', (-2, -2, 2, 0)),
            ('style="transform: scale(2); transform-origin: bottom 50%"', (-12, 22, -8, 24)),
            ('style="transform-box: fill-box; transform-origin: 50% 50%"', (0, -1, 2, 0)),
            ('style="transform-box: fill-box" transform="translate(3)"', (3, -1, 5, 0)),
        ],
    )
    def test_transforms_of_css_and_their_origins(self, written, given, bounds):
        path = drawing(
            written, f"<style>.moved {{ transform: translate(10px, 0) }}</style><rect {given} width='2' height='1'/>"
        )
        assert domain(path).bounds == pytest.approx(bounds)

    @pytest.mark.parametrize(
        ("style", "told"),
        [
            ("transform: rotate(45)", "rotate(45)"),
            ("transform: translate(50%)", "translate(50%)"),
            ("transform: scale3d(2, 2, 1)", "scale3d(2, 2, 1)"),
            ("rotate: x 45deg", "rotate(x 45deg)"),
            ("transform: scale(2); transform-box: fill-box", "transform-box: fill-box"),
            ("transform: scale(2); transform-origin: 1px calc(1px)", "transform-origin: 1px calc(1px)"),
        ],
    )
    def test_transforms_that_are_not_read_are_refused(self, written, style, told):
        path = drawing(written, f'<rect style="{style}" width="2" height="1"/>')
        message = f"rect in line 1: '{told}' is not read: write it as the attribute transform, in numbers"
        with pytest.raises(CaseError, match=re.escape(message)):
            domain(path)

    def test_important_declarations_win(self, written):
        path = drawing(
            written,
            "<style>#a { display: none !important } rect { fill: none ! important; fill: red }</style>"
            '<rect id="a" style="display: inline" width="9" height="9"/>'
            '<rect style="fill: red" width="8" height="8"/><rect style="fill: red !important" width="2" height="1"/>',
        )
        assert area(path) == pytest.approx(2)
        assert notes_of(path) == ["left out: 2 hidden elements"]

    def test_a_use_that_leads_nowhere_is_told(self, written):
        path = drawing(written, '<rect width="2" height="1"/><use href="other.svg#a"/>')
        assert notes_of(path) == ["1 use of nothing that is there not used"]
