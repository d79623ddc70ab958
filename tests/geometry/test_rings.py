import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from bubblemesh.errors import GeometryError
from bubblemesh.geometry import paths
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.paths import Line, family, outlines
from bubblemesh.geometry.polygonal_copy import PolygonalCopy
from bubblemesh.geometry.rings import (
    ArcTo,
    BezierTo,
    LineTo,
    SplineTo,
    circle,
    ellipse,
    path,
    polygon,
    rectangle,
    straight_ring,
)

SQUARE = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
MIXED = path(
    (0, 0),
    [
        LineTo((2, 0), "base"),
        ArcTo((2, 2), (2, 1), True, "nose"),
        SplineTo([(1.5, 2.2), (0.5, 1.8), (0, 2)], "top"),
    ],
    "rest",
)


def ends(side):
    curve = family([side.curve])
    return curve.points(np.zeros(2, int), np.array([0, curve.lengths[0]]))


def assert_closed(ring):
    for side, start, end in zip(ring.sides, ring.vertices, ring.vertices[1:] + ring.vertices[:1], strict=True):
        assert_allclose(ends(side), [start, end], atol=1e-12)


def test_polygon_has_a_side_from_each_point_to_the_next():
    ring = polygon(SQUARE, labels=["a", "b", "c", "d"])
    assert ring.vertices == SQUARE
    assert [side.label for side in ring.sides] == ["a", "b", "c", "d"]
    assert_closed(ring)


def test_one_label_names_every_side_and_none_leaves_them_open():
    assert {side.label for side in polygon(SQUARE, label="wall").sides} == {"wall"}
    assert {side.label for side in polygon(SQUARE).sides} == {None}


def test_explicit_closing_point_changes_nothing():
    assert polygon([*SQUARE, SQUARE[0]]) == polygon(SQUARE)


@pytest.mark.parametrize("corners", [(0, 0, 2, 1), (2, 1, 0, 0), (2, 0, 0, 1)])
def test_rectangle_takes_any_two_opposite_corners(corners):
    ring = rectangle(*corners, labels=["bottom", "right", "top", "left"])
    assert ring.vertices == ((0, 0), (2, 0), (2, 1), (0, 1))
    assert ring.sides[1].label == "right"


def test_duplicate_points_are_merged_with_a_note_and_labels_stay_with_their_sides():
    ring = polygon([SQUARE[0], SQUARE[1], SQUARE[1], *SQUARE[2:]], labels=["a", "gone", "b", "c", "d"])
    assert ring.vertices == SQUARE
    assert [side.label for side in ring.sides] == ["a", "b", "c", "d"]
    assert ring.notes == ("duplicate point (1, 0) merged", "left out: 1 side without length, labelled 'gone'")


def test_labels_of_merged_sides_are_told_once_unless_other_sides_have_them():
    corners = [SQUARE[0], *(SQUARE[1],) * 4, *SQUARE[2:]]
    ring = polygon(corners, labels=["a", "x", "y", "a", "b", "c", "d"])
    assert ring.notes[-1] == "left out: 2 sides without length, labelled 'x', 'y'"
    assert len(polygon(corners, label="a").notes) == len(polygon(corners).notes) == 3
    assert path((0, 0), [LineTo((1, 0)), LineTo((1, 0), "gone"), LineTo((1, 1))]).notes[1:] == (
        "left out: 1 side without length, labelled 'gone'",
    )


def test_points_that_differ_by_rounding_are_merged_too():
    ring = polygon([SQUARE[0], SQUARE[1], (1, 1e-15), *SQUARE[2:], (1e-15, 0)])
    assert ring.vertices == SQUARE
    assert len(ring.notes) == 2


@pytest.mark.parametrize("scale", [1e15, 1e-12, 1e-150])
def test_small_distances_in_small_rings_are_kept(scale):
    ring = polygon(np.array(SQUARE) * scale)
    assert len(ring.sides) == 4
    assert ring.notes == ()


@pytest.mark.parametrize("points", [[], [(0, 0)], [(0, 0), (1, 1)], [(0, 0), (1, 1), (0, 0)], [(2, 3)] * 5])
def test_fewer_than_three_different_points_are_refused(points):
    with pytest.raises(GeometryError, match="at least three"):
        polygon(points)


def test_path_of_lines_arcs_and_splines_is_closed_by_a_line():
    assert [type(side.curve).__name__ for side in MIXED.sides] == ["Line", "Arc", "Spline", "Line"]
    assert [side.label for side in MIXED.sides] == ["base", "nose", "top", "rest"]
    assert_closed(MIXED)


def test_path_that_ends_at_its_start_gets_no_further_side():
    ring = path((1, 0), [ArcTo((-1, 0), (0, 0), True), LineTo((1, 0))])
    assert len(ring.sides) == 2
    assert_closed(ring)


@pytest.mark.parametrize(("left", "length"), [(True, 3 * np.pi / 2), (False, np.pi / 2)])
def test_arc_turns_as_told(left, length):
    ring = path((1, 0), [ArcTo((0, -1), (0, 0), left)])
    assert family([ring.sides[0].curve]).lengths == pytest.approx(length)
    assert_closed(ring)


def test_arc_back_to_its_start_is_a_whole_circle():
    ring = path((1, 0), [ArcTo((1, 0), (0, 0), False)])
    assert ring.vertices == ((1, 0),)
    assert family([ring.sides[0].curve]).lengths == pytest.approx(2 * np.pi)


def test_slightly_wrong_arc_center_is_mended_with_a_note():
    ring = path((1, 0), [ArcTo((-0.7071, 0.7071), (0, 0), True)])
    assert len(ring.notes) == 1
    assert "center of the arc from (1, 0) to (-0.7071, 0.7071) moved" in ring.notes[0]
    assert_closed(ring)


def test_rounded_arc_center_is_mended_silently():
    ring = path((np.cos(1), np.sin(1)), [ArcTo((np.cos(2), np.sin(2)), (1e-15, 0), True)])
    assert ring.notes == ()
    assert_closed(ring)


def test_wrong_arc_center_is_refused_with_both_radii():
    with pytest.raises(GeometryError, match=r"from \(1, 0\) to \(-2, 0\) is 1 from its center \(0, 0\).* and 2 at"):
        path((1, 0), [ArcTo((-2, 0), (0, 0), True)])


def test_arc_without_a_radius_is_refused():
    with pytest.raises(GeometryError, match=r"arc at \(1, 2\).*move its center"):
        path((1, 2), [ArcTo((1, 2), (1, 2), True), LineTo((3, 3)), LineTo((0, 3))])


def test_duplicate_spline_points_are_merged_with_a_note():
    ring = path((0, 0), [SplineTo([(1, 1), (1, 1), (2, 0)])])
    assert ring.notes == ("duplicate spline point (1, 1) merged",)
    assert len(ring.sides[0].curve.knots) == 3


@pytest.mark.parametrize("through", [[(0, 0)], [(1, 1), (0, 0)]])
def test_spline_with_too_few_points_is_refused(through):
    with pytest.raises(GeometryError, match=r"spline at \(0, 0\)"):
        path((0, 0), [SplineTo(through), LineTo((1, 0)), LineTo((1, 1))])


@pytest.mark.parametrize("ring", [circle((1, 2), 3), ellipse((1, 2), (3, 1), 30), MIXED, polygon(SQUARE)])
def test_reversed_ring_has_the_same_points_run_the_other_way(ring):
    for number, side in enumerate(ring.sides):
        curve, back = family([side.curve]), family([ring.reversed().sides[-1 - number].curve])
        s = np.linspace(0, curve.lengths[0], 101)
        index = np.zeros(101, int)
        if ring.vertices:
            there = back.points(index, curve.lengths[0] - s)
            assert_allclose(there, curve.points(index, s), atol=1e-6)
            assert_allclose(back.tangents(index, curve.lengths[0] - s), -curve.tangents(index, s), atol=1e-4)
        assert back.lengths == pytest.approx(curve.lengths)
        assert side.label == ring.reversed().sides[-1 - number].label


@pytest.mark.parametrize("ring", [circle((1, 2), 3), ellipse((1, 2), (3, 1), 30), MIXED, polygon(SQUARE)])
def test_reversing_flips_the_sign_of_the_area(ring):
    def area(ring):
        x, y = PolygonalCopy.of(Boundary.of([ring])).points.T
        return np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) / 2

    assert area(ring.reversed()) == pytest.approx(-area(ring), rel=1e-6)
    assert area(ring) > 0


def test_reversed_ring_keeps_its_first_vertex():
    assert polygon(SQUARE).reversed().vertices == (SQUARE[0], SQUARE[3], SQUARE[2], SQUARE[1])
    assert_closed(polygon(SQUARE).reversed())
    assert_closed(MIXED.reversed())


def test_ellipse_is_turned_by_degrees():
    curve = family([ellipse((1, 1), (2, 0.5), 90).sides[0].curve])
    assert_allclose(curve.points(np.zeros(1, int), np.zeros(1)), [[1, 3]])


@given(st.lists(st.tuples(st.integers(-3, 3), st.integers(-3, 3)), min_size=1, max_size=12))
def test_polygon_is_the_list_without_its_repetitions_or_an_error(points):
    merged = [p for k, p in enumerate(points) if k == 0 or p != points[k - 1]]
    if len(merged) > 1 and merged[-1] == merged[0]:
        merged.pop()
    if len(set(points)) < 3:
        with pytest.raises(GeometryError):
            polygon(points)
        return
    ring = polygon(points)
    assert ring.vertices == tuple(merged)
    assert all(isinstance(side.curve, Line) for side in ring.sides)
    assert_closed(ring)


def test_outlines_of_rings_together_are_those_of_each_alone():
    def made():
        cusp = [ArcTo((22, 2), (20, 2), True), LineTo((21, 1)), ArcTo((20, 0), (20, 1), False)]
        bent = [BezierTo((2, 9), (0, 10), (2, 10)), LineTo((0, 9))]
        return [
            MIXED,
            polygon(SQUARE),
            circle((2, 2), 0.5),
            path((20, 0), cusp),
            path((0, 9), bent),
            path((0, 9), [ArcTo((-2, 9), (-1, 9), True), LineTo((0, 9))]),  # meets the one before in a corner
            ellipse((5, 5), (2, 1)),
        ]

    for together, ring in zip(outlines(made()), made(), strict=True):
        assert_allclose(together, PolygonalCopy.of(Boundary.of([ring])).points, rtol=0, atol=1e-13)
        assert not together.flags.writeable


def test_outline_is_computed_once_and_cannot_be_changed():
    ring = path((0, 0), [SplineTo([(1, 1), (2, 0)]), LineTo((0, 0))])
    assert ring.outline is ring.outline
    assert outlines([ring])[0] is ring.outline
    with pytest.raises(ValueError, match="read-only"):
        ring.outline[0] = 7


@pytest.mark.parametrize("ring", [MIXED, circle((2, 2), 0.5), polygon(SQUARE)])
def test_a_reversed_ring_keeps_its_outline(ring, monkeypatch):
    anew = ring.reversed().outline
    points = ring.outline
    monkeypatch.setattr(paths, "_outlined", None)
    turned = ring.reversed()
    assert_allclose(turned.outline, anew, rtol=0, atol=1e-13)
    assert_allclose(turned.reversed().outline, points, rtol=0, atol=0)
    assert not turned.outline.flags.writeable


def test_straight_ring_is_the_polygon_through_its_vertices():
    assert straight_ring(SQUARE, "wall") == polygon(SQUARE, label="wall")
    with pytest.raises(GeometryError, match="fewer than three different points"):
        straight_ring([(0.0, 0.0), (1.0, 0.0)])
