"""Clips of drawings: clip-paths of SVG and XCLIP of DXF leave of shapes what is to be seen."""

import ezdxf
import numpy as np
import pytest
from ezdxf.xclip import XClip
from geometry_files import SVG, area, domain, labels_of
from scipy.optimize import brentq

from bubblemesh.errors import BubblemeshError, CaseError, LimitError
from bubblemesh.geometry.paths import family
from bubblemesh.readers.formats import read_areas, read_regions
from bubblemesh.readers.lines_and_points import read_lines, read_points
from bubblemesh.readers.selection import Selection

CORNER = '<clipPath id="Corner"><rect width="5" height="5"/></clipPath>'


@pytest.fixture
def svg(written):
    return lambda content, defs=CORNER: written("clipped.svg", SVG.format(f"<defs>{defs}</defs>{content}"))


@pytest.fixture
def dxf(tmp_path):
    def save(draw):
        document = ezdxf.new("R2018")
        draw(document)
        path = tmp_path / "clipped.dxf"
        document.saveas(path)
        return path

    return save


def notes_of(path, **options):
    notes = (note for one in read_areas(path, Selection(**options)) for ring in one.rings for note in ring.notes)
    return [note.removeprefix(f"{path.name}: ") for note in notes]


class TestSvg:
    @pytest.mark.parametrize(
        "content",
        [
            '<rect width="9" height="9" clip-path="url(#Corner)"/>',
            '<rect width="9" height="9" style="clip-path: url(&quot;#Corner&quot;)"/>',
            '<style>.cut { clip-path: url(#Corner) }</style><g class="cut"><rect width="9" height="9"/></g>',
            '<defs><rect id="r" width="9" height="9"/></defs><use href="#r" clip-path="url(#Corner)"/>',
            '<g clip-path="url(#Corner)"><path d="M0 0H9V9H0Z"/></g>',
            '<path d="M0 0H9V9H0Z" fill="none" stroke="red" clip-path="url(#Corner)"/>',
        ],
    )
    def test_a_clip_leaves_what_is_within_it(self, svg, content):
        path = svg(content)
        assert area(path) == pytest.approx(25)
        assert domain(path).bounds == pytest.approx((0, -5, 5, 0))
        assert notes_of(path) == ["by clips: 1 shape cut"]

    @pytest.mark.parametrize(
        ("content", "bounds"),
        [
            ('<svg width="5" height="5"><rect width="9" height="9"/></svg>', (0, -5, 5, 0)),
            ('<svg x="1" width="5px" height="4"><rect width="9" height="9"/></svg>', (1, -4, 6, 0)),
            (
                '<svg width="5" height="5" viewBox="0 0 10 10"><rect x="-8" y="-8" width="12" height="12"/></svg>',
                (0, -2, 2, 0),
            ),
            (
                '<g transform="rotate(90)"><svg width="5" height="2"><rect width="9" height="9"/></svg></g>',
                (-2, -5, 0, 0),
            ),
            (
                '<symbol id="s"><rect width="9" height="9"/></symbol><use href="#s" width="5" height="5"/>',
                (0, -5, 5, 0),
            ),
        ],
    )
    def test_nested_drawings_and_symbols_are_cut_where_their_boxes_end(self, svg, content, bounds):
        path = svg(content)
        assert domain(path).bounds == pytest.approx(bounds)
        assert notes_of(path) == ["by clips: 1 shape cut"]

    @pytest.mark.parametrize(
        "content",
        [
            '<svg width="5" height="5" overflow="visible"><rect width="9" height="9"/></svg>',
            '<style>svg { overflow: visible }</style><svg width="5" height="5"><rect width="9" height="9"/></svg>',
            '<svg><rect width="9" height="9"/></svg>',
            '<svg width="100%" height="5%"><rect width="9" height="9"/></svg>',
            '<svg width="9" height="9"><rect width="9" height="9"/></svg>',
        ],
    )
    def test_what_may_overflow_or_has_no_size_is_not_cut(self, svg, content):
        path = svg(content)
        assert area(path) == pytest.approx(81)
        assert notes_of(path) == []

    def test_what_a_clip_holds_as_a_whole_stays_the_curve_that_it_is(self, svg):
        path = svg('<circle id="disk" cx="2" cy="2" r="1" clip-path="url(#Corner)"/>')
        assert area(path) == pytest.approx(np.pi, rel=1e-3)
        assert notes_of(path) == []

    def test_curves_stay_curves_where_they_are_cut(self, svg):
        path = svg('<circle cx="5" cy="2.5" r="2" clip-path="url(#Corner)"/>')
        (one,) = read_areas(path, Selection())
        kinds = sorted(type(side.curve).__name__ for side in one.outer.sides)
        assert set(kinds) == {"Arc", "Line"}
        assert area(path) == pytest.approx(2 * np.pi, rel=1e-3)

    def test_bezier_curves_stay_curves_where_they_are_cut(self, svg):
        path = svg('<path d="M2 1C8 1 8 4 2 4Z" clip-path="url(#Corner)"/>')
        (one,) = read_areas(path, Selection())
        assert {type(getattr(side.curve, "curve", side.curve)).__name__ for side in one.outer.sides} == {
            "Bezier",
            "Line",
        }
        u = 0.5 - np.sqrt(1 / 12)  # where 2 + 18 u (1 - u) is 5
        y = 1 + 9 * u**2 - 6 * u**3
        np.testing.assert_allclose(sorted(one.outer.vertices)[2:], [(5, y - 5), (5, -y)], atol=1e-6)

    def test_lines_of_bezier_curves_are_cut(self, svg):
        path = svg('<path fill="none" stroke="red" d="M2 1C8 1 8 4 2 4" clip-path="url(#Corner)"/>')
        lines = read_lines(path, Selection())
        assert sorted(line.vertices[0] for line in lines)[0] == (2, -1)
        family_of = [family([line.sides[0].curve]) for line in lines]
        x, y = np.vstack([one.points(np.zeros(9, int), np.linspace(0, one.lengths[0], 9)) for one in family_of]).T
        assert x.max() == pytest.approx(5)
        u = np.array([brentq(lambda t, y=y: 1 + 9 * t**2 - 6 * t**3 + y, 0, 1) for y in y])
        np.testing.assert_allclose(x, 2 + 18 * u * (1 - u), atol=1e-3)

    def test_transforms_of_the_shape_move_its_clip(self, svg):
        path = svg('<g transform="translate(10 0) scale(2)"><rect width="9" height="9" clip-path="url(#Corner)"/></g>')
        assert domain(path).bounds == pytest.approx((10, -10, 20, 0))

    def test_transforms_of_a_clip_and_its_shapes_count(self, svg):
        defs = (
            '<clipPath id="c" transform="translate(1 1)"><rect transform="scale(2)" width="2" height="1"/></clipPath>'
        )
        path = svg('<rect width="9" height="9" clip-path="url(#c)"/>', defs)
        assert domain(path).bounds == pytest.approx((1, -3, 5, -1))

    def test_units_of_the_box_are_those_of_all_that_is_clipped(self, svg):
        defs = '<clipPath id="c" clipPathUnits="objectBoundingBox"><rect width=".5" height=".25"/></clipPath>'
        content = '<g clip-path="url(#c)" transform="scale(2)"><rect x="1" y="1" width="8" height="4"/></g>'
        assert domain(svg(content, defs)).bounds == pytest.approx((2, -4, 10, -2))

    def test_clips_within_clips_leave_what_all_of_them_hold(self, svg):
        defs = (
            '<clipPath id="a"><rect width="5" height="5"/></clipPath>'
            '<clipPath id="b" clip-path="url(#a)"><rect x="2" width="7" height="9"/></clipPath>'
            '<clipPath id="c"><rect y="1" width="40" height="40"/></clipPath>'
        )
        path = svg('<g clip-path="url(#c)"><rect width="9" height="9" clip-path="url(#b)"/></g>', defs)
        assert domain(path).bounds == pytest.approx((2, -5, 5, -1))

    def test_shapes_of_a_clip_are_one_by_its_rule(self, svg):
        defs = (
            '<clipPath id="c"><rect width="4" height="4"/><rect x="2" width="4" height="4"/>'
            '<path clip-rule="evenodd" d="M0 20H8V28H0Z M2 22H6V26H2Z"/></clipPath>'
        )
        path = svg('<rect width="9" height="40" clip-path="url(#c)"/>', defs)
        assert area(path, part="all") == pytest.approx(24 + 64 - 16)

    def test_a_hole_across_a_clip_is_cut_with_its_area(self, svg):
        path = svg('<g clip-path="url(#Corner)"><rect width="9" height="9"/><circle cx="5" cy="2" r="1"/></g>')
        assert area(path) == pytest.approx(25 - np.pi / 2, rel=1e-3)
        assert domain(path).hole_count == 0

    def test_what_is_outside_is_left_out_and_counted(self, svg):
        path = svg(
            '<g clip-path="url(#Corner)"><rect width="9" height="9"/><rect x="20" width="3" height="3"/></g>'
            '<rect x="30" width="1" height="1" clip-path="url(#none)"/><rect x="33" width="1" height="1"'
            ' clip-path="circle(3)"/>'
        )
        assert area(path, part="all") == pytest.approx(27)
        assert notes_of(path, part="all") == [
            "1 element not clipped: there is no clipPath 'none'",
            "1 element not clipped: 'circle(3)' is not read",
            "by clips: 1 shape cut, 1 shape left out",
        ]

    def test_a_clip_that_cannot_be_applied_is_told_once(self, svg):
        nearly = '<rect width="5" height="5"/><rect x="1" y="1e-6" width="5" height="5"/>'
        defs = f'<clipPath id="c">{nearly}</clipPath>'
        path = svg(
            '<rect width="9" height="9" clip-path="url(#c)"/><rect x="20" width="9" height="9" clip-path="url(#c)"'
            ' transform="translate(5)"/>',
            defs,
        )
        assert area(path, part="all") == pytest.approx(162)
        (note,) = notes_of(path, part="all")
        assert note.startswith("2 elements not clipped: clipPath 'c' in line 1: ")

    def test_an_empty_clip_leaves_nothing(self, svg):
        path = svg('<rect width="9" height="9" clip-path="url(#c)"/>', '<clipPath id="c"/>')
        with pytest.raises(CaseError, match="there is no ring in it"):
            area(path)

    def test_labels_go_along_the_cut(self, svg):
        path = svg('<rect id="plate" width="9" height="9" clip-path="url(#Corner)"/>')
        assert labels_of(path) == [["plate"]]

    def test_lines_end_at_the_clip(self, svg):
        path = svg('<path fill="none" stroke="red" d="M1 1L9 1" clip-path="url(#Corner)"/>')
        (line,) = read_lines(path, Selection())
        assert line.vertices == ((1, -1), (5, -1))

    def test_regions_are_clipped_one_by_one(self, svg):
        path = svg(
            '<g clip-path="url(#Corner)"><rect id="left" width="3" height="9"/><rect id="right" x="3" width="6"'
            ' height="9"/></g>'
        )
        found = {one.name: one for one in read_regions(path, Selection(), "id")}
        assert {name: np.ptp(one.outer.vertices, axis=0).tolist() for name, one in found.items()} == {
            "left": [3, 5],
            "right": [2, 5],
        }

    def test_text_in_a_clip_is_told(self, svg):
        defs = '<clipPath id="c"><text>A</text><rect width="5" height="5"/></clipPath>'
        path = svg('<rect width="9" height="9" clip-path="url(#c)"/>', defs)
        assert notes_of(path)[0] == "1 text of a clip-path not used"

    @pytest.mark.parametrize(
        "defs",
        [
            '<clipPath id="c"><rect width="5" height="5" clip-path="url(#c)"/></clipPath>',
            '<clipPath id="c" clip-path="url(#c)"><rect width="5" height="5"/></clipPath>',
            '<clipPath id="c"><use href="#d"/></clipPath><g id="d"><use href="#d"/></g>',
        ],
    )
    def test_clips_of_themselves_are_refused(self, svg, defs):
        with pytest.raises(CaseError, match=r"it clips itself|it uses 'd'"):
            area(svg('<rect width="9" height="9" clip-path="url(#c)"/>', defs))

    @pytest.mark.parametrize(("times", "shapes"), [(25, 1), (6, 9)])
    def test_uses_within_clips_do_not_multiply_without_end(self, times, shapes, svg, monkeypatch):
        """One clip alone, and each time that it is made for a shape with another transform."""
        monkeypatch.setattr("bubblemesh.readers.svg.tree.MOST_ELEMENTS", 400)
        doubled = "".join(f'<g id="d{k}"><use href="#d{k + 1}"/><use href="#d{k + 1}"/></g>' for k in range(times))
        defs = f'<clipPath id="c"><use href="#d0"/></clipPath>{doubled}<rect id="d{times}" width="5" height="5"/>'
        rect = '<rect width="9" height="9" clip-path="url(#c)" transform="translate({0} {0})"/>'
        with pytest.raises(LimitError, match="its clips draw more than"):
            area(svg("".join(map(rect.format, range(shapes))), defs))

    def test_a_ring_that_crosses_itself_is_told_as_such(self, svg):
        path = svg('<path fill="none" stroke="red" d="M0 0L9 9V0L0 9Z" clip-path="url(#Corner)"/>')
        with pytest.raises(BubblemeshError, match="crosses or touches itself"):
            area(path)


class TestDxf:
    """A block of a square of 4 with a hole of 1 in its middle, drawn by lines."""

    @staticmethod
    def block(document, closed=True):
        block = document.blocks.new("PLATE")
        corners = [(0, 0), (4, 0), (4, 4), (0, 4)]
        for k in range(4 if closed else 3):
            block.add_line(corners[k], corners[(k + 1) % 4])
        block.add_circle((2, 2), 0.5)
        block.add_point((1, 1))
        block.add_point((3, 3))
        return document.modelspace()

    def test_a_block_is_cut_where_its_clip_ends(self, dxf):
        def draw(document):
            XClip(self.block(document).add_blockref("PLATE", (10, 0))).set_block_clipping_path([(0, 0), (2.8, 4)])

        path = dxf(draw)
        assert area(path) == pytest.approx(11.2 - np.pi / 4, rel=1e-3)
        assert notes_of(path) == ["by clips: 1 shape cut, 1 shape left out", "left out: 1 point"]
        (place,), _ = read_points(path, Selection(), None)
        assert place.at == (11, 1)

    def test_a_clip_turns_and_grows_with_its_block(self, dxf):
        def draw(document):
            attributes = {"xscale": 2, "yscale": 2, "rotation": 90}
            insert = self.block(document).add_blockref("PLATE", (10, 0), dxfattribs=attributes)
            XClip(insert).set_block_clipping_path([(0, 0), (4, 1)])

        assert domain(dxf(draw)).bounds == pytest.approx((8, 0, 10, 8))

    def test_a_clip_through_a_hole_cuts_it(self, dxf):
        def draw(document):
            XClip(self.block(document).add_blockref("PLATE", (0, 0))).set_block_clipping_path([(0, 0), (2, 4)])

        path = dxf(draw)
        assert area(path) == pytest.approx(8 - np.pi / 8, rel=1e-3)
        assert domain(path).hole_count == 0

    def test_an_inner_block_is_clipped_by_both(self, dxf):
        def draw(document):
            self.block(document)
            outer = document.blocks.new("OUTER")
            XClip(outer.add_blockref("PLATE", (0, 0))).set_block_clipping_path([(0, 0), (4, 1)])
            XClip(document.modelspace().add_blockref("OUTER", (0, 0))).set_block_clipping_path([(0, 0), (1, 4)])

        assert domain(dxf(draw)).bounds == pytest.approx((0, 0, 1, 1))

    def test_a_clip_that_is_off_does_nothing(self, dxf):
        def draw(document):
            clip = XClip(self.block(document).add_blockref("PLATE", (0, 0)))
            clip.set_block_clipping_path([(0, 0), (4, 1)])
            clip.disable_clipping()

        assert area(dxf(draw)) == pytest.approx(16 - np.pi / 4, rel=1e-3)

    def test_a_clip_turned_round_leaves_what_is_outside(self, dxf):
        def draw(document):
            clip = XClip(self.block(document).add_blockref("PLATE", (0, 0)))
            clip.set_block_clipping_path([(1, 1), (3, 3)])
            clip.invert_clipping_path(ignore_acad_compatibility=True)

        assert area(dxf(draw)) == pytest.approx(12)

    def test_lines_that_do_not_close_are_cut_as_lines(self, dxf):
        def draw(document):
            insert = self.block(document, closed=False).add_blockref("PLATE", (0, 0))
            XClip(insert).set_block_clipping_path([(-1, -1), (3, 5)])

        lines = read_lines(dxf(draw), Selection())
        assert sorted(line.vertices for line in lines if line.vertices) == [((0, 0), (3, 0)), ((3, 4), (0, 4))]
