"""Union, difference and intersection of areas, whose curves stay curves."""

import numpy as np
import pytest
import shapely
from sweeps import sweep

from bubblemesh.errors import GeometryError
from bubblemesh.geometry import rings
from bubblemesh.geometry.arrangement.overlay import overlaid
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.paths import Arc, Area, CurveSection, Ellipse, Spline
from bubblemesh.geometry.rings import ArcTo, LineTo, SplineTo
from bubblemesh.geometry.similarity import Similarity


def box(*corners, label=None):
    return [Area(rings.rectangle(*corners, label=label))]


def disc(center, radius, label=None):
    return [Area(rings.circle(center, radius, label))]


def size(areas):
    """Area of the polygonal copies."""
    return sum(shapely.Polygon(area.outer.outline, [hole.outline for hole in area.holes]).area for area in areas)


def sides(area):
    return [(type(side.curve).__name__, side.label) for side in area.outer.sides]


SQUARES = box(0, 0, 2, 2, label="a"), box(1, 1, 3, 3, label="b")


@pytest.mark.parametrize(
    ("rule", "expected", "labels"), [("union", 7, "aabbbbaa"), ("minus", 3, "aabbaa"), ("intersection", 1, "aabb")]
)
def test_squares_that_overlap(rule, expected, labels):
    (area,) = overlaid(rule, SQUARES)
    assert size([area]) == expected
    assert sorted(label for _, label in sides(area)) == sorted(labels)
    assert not area.holes


@pytest.mark.parametrize(
    ("other", "vertices"),
    [
        (box(2, 0, 4, 2), 6),  # a whole side in common; the corners of both stay
        (box(2, 0.5, 4, 1.5), 8),
        (box(2, 1, 4, 3), 8),
        (box(1, 0, 4, 2), 6),  # sides that run along each other
        (box(0, 0, 4, 2), 6),
        (box(0, 0, 2, 2), 4),  # the same
        (box(0.5, 0.5, 1, 1), 4),  # inside
        (box(0, 0.5, 1, 1), 6),  # inside, on a side: a vertex stays where a corner of the other is
    ],
)
def test_sides_in_common_vanish_inside(other, vertices):
    one = box(0, 0, 2, 2, label="a")
    (area,) = overlaid("union", [one, other])
    polygons = [shapely.Polygon(area.outer.outline) for area in (*one, *other)]
    assert size([area]) == pytest.approx(shapely.union_all(polygons).area)
    assert len(area.outer.vertices) <= vertices
    assert Domain.of_areas([area]).hole_count == 0


def test_what_is_left_of_a_side_keeps_the_label_of_its_ring():
    (area,) = overlaid("minus", [box(0, 0, 4, 2, label="plate"), box(1, 0, 2, 1, label="notch")])
    assert sides(area).count(("Line", "notch")) == 3
    assert sides(area).count(("Line", "plate")) == 5
    assert size([area]) == 7


def test_circles_stay_circles_and_arcs_are_arcs_of_them():
    (area,) = overlaid("minus", [box(0, 0, 2, 2), disc((1, 1), 0.5, "bore"), disc((2, 1), 0.25, "slot")])
    assert [hole.sides[0].curve for hole in area.holes] == [Arc((1, 1), 0.5, 2 * np.pi, -2 * np.pi)]
    (arc,) = [side.curve for side in area.outer.sides if side.label == "slot"]
    assert arc.center == (2, 1)
    assert arc.radius == 0.25
    assert abs(arc.sweep) == pytest.approx(np.pi)


def test_what_no_other_curve_meets_is_not_changed_at_all():
    ring = rings.path(
        (0, 0), [LineTo((2, 0), "floor"), ArcTo((2, 2), (2, 1), True), SplineTo([(1, 2.5), (0, 1), (0, 0)])]
    )
    (area,) = overlaid("union", [[Area(ring)], box(0.5, 0.5, 1, 1)])
    assert [side.label for side in area.outer.sides] == ["floor", None, None]
    assert area.outer.vertices == ring.vertices
    assert area.outer.sides[:2] == ring.sides[:2]
    assert isinstance(area.outer.sides[2].curve, Spline)
    for shape in (disc((0, 0), 1), [Area(rings.ellipse((0, 0), (2, 1), 30))]):
        (area,) = overlaid("intersection", [shape, box(-9, -9, 9, 9)])
        assert area == shape[0]


def test_a_circle_that_is_touched_is_whole_again():
    big, small = disc((0, 0), 2, "rim"), disc((1, 0), 1, "bore")
    (area,) = overlaid("minus", [big, small])
    assert area.outer.sides[0].curve == big[0].outer.sides[0].curve
    assert area.outer.vertices == ()
    assert [len(hole.sides) for hole in area.holes] == [1]
    one, two = overlaid("union", [disc((0, 0), 1, "a"), disc((2, 0), 1, "b")])
    assert [one.outer.sides[0].label, two.outer.sides[0].label] == ["a", "b"]


def test_a_slot_of_a_rectangle_and_two_circles():
    (area,) = overlaid("union", [box(0, -1, 4, 1), disc((0, 0), 1), disc((4, 0), 1)])
    assert [kind for kind, _ in sides(area)] == ["Line", "Arc", "Line", "Arc"]
    assert [side.curve.sweep for side in area.outer.sides[1::2]] == pytest.approx([np.pi, np.pi])


def test_equal_arcs_are_one_however_they_are_made():
    half = [Area(rings.path((-1, 0), [LineTo((1, 0), "cut"), ArcTo((-1, 0), (0, 0), True, "cap")]))]
    (area,) = overlaid("minus", [disc((0, 0), 1, "disc"), half])
    assert sorted(sides(area)) == [("Arc", "disc"), ("Line", "cut")]
    assert size([area]) == pytest.approx(np.pi / 2, rel=1e-3)
    assert overlaid("minus", [half, disc((0, 0), 1)]) == []


def test_parts_of_ellipses_and_splines_are_sections_of_the_same_curve():
    ellipse = rings.ellipse((1, 1), (1.5, 0.5), 20, "e")
    one, two = overlaid("minus", [box(0, 0, 2, 2, label="a"), [Area(ellipse)]])
    for area in (one, two):
        (section,) = [side.curve for side in area.outer.sides if isinstance(side.curve, CurveSection)]
        assert section.curve in (ellipse.sides[0].curve, ellipse.sides[0].curve.reversed())
        assert isinstance(section.curve, Ellipse)
    corner = disc((0.1, 0.5), 0.2)
    rest, common = overlaid("minus", [[one, two], corner]), overlaid("intersection", [[one, two], corner])
    assert size(rest) + size(common) == pytest.approx(size([one, two]), rel=1e-5)


def test_results_have_holes_and_several_areas():
    frame = overlaid("union", [box(0, 0, 4, 1), box(0, 3, 4, 4), box(0, 0, 1, 4), box(3, 0, 4, 4)])
    assert [(len(area.outer.sides), len(area.holes)) for area in frame] == [(8, 1)]
    assert size(frame) == 12
    bars = overlaid("minus", [box(0, 0, 9, 1), box(2, -1, 3, 2), box(5, -1, 6, 2)])
    assert [shapely.Polygon(area.outer.outline).bounds for area in bars] == [(0, 0, 2, 1), (3, 0, 5, 1), (6, 0, 9, 1)]
    island = overlaid("union", [frame, box(1.5, 1.5, 2.5, 2.5)])
    assert Domain.of_areas(island).piece_count == 2
    assert Domain.of_areas(overlaid("union", [frame, box(1, 1, 3, 3)])).hole_count == 0


def test_areas_that_touch_in_a_point_stay_two_and_holes_that_touch_stay_holes():
    two = overlaid("union", [box(0, 0, 2, 2), box(2, 2, 4, 4)])
    assert len(two) == 2
    (area,) = overlaid("minus", [box(0, 0, 4, 4), box(1, 1, 2, 2), box(2, 2, 3, 3)])
    assert len(area.holes) == 2
    diamond = [Area(rings.polygon([(2, 0), (3, 1), (2, 2), (1, 1)]))]
    (area,) = overlaid("minus", [box(0, 0, 4, 4), diamond])
    assert len(area.holes) == 1
    parts = overlaid("minus", [box(0, 0, 4, 2), diamond])
    assert [size([part]) for part in parts] == [3, 3]


def test_an_empty_result_is_no_area():
    assert overlaid("intersection", [box(0, 0, 1, 1), box(2, 0, 3, 1)]) == []
    assert overlaid("intersection", [box(0, 0, 1, 1), box(1, 0, 2, 1)]) == []
    assert overlaid("minus", [disc((0, 0), 1), disc((0, 0), 2)]) == []


def test_rings_that_cross_themselves_are_told():
    bow = [Area(rings.polygon([(0, 0), (2, 2), (2, 0), (0, 2.5)]))]
    with pytest.raises(GeometryError, match="crosses or touches itself at"):
        overlaid("union", [bow, box(0, 0, 1, 1)])


def random_shape(random):
    move = Similarity.of(rotate=random.uniform(0, 360), move=tuple(random.uniform(-1, 1, 2)))
    turn = Similarity.of(rotate=90 * random.integers(4), move=tuple(random.integers(-3, 4, 2) / 2))
    match random.integers(6):
        case 0:
            return rings.rectangle(0, 0, 1, 1).moved(turn)
        case 1:
            return rings.rectangle(-0.5, 0, 1.5, 1).moved(turn)
        case 2:
            return rings.circle((0, 0), 0.5).moved(turn)
        case 3:
            return rings.path((-0.5, 0), [ArcTo((0.5, 0), (0, 0), True), LineTo((0.5, 1)), LineTo((-0.5, 1))]).moved(
                turn
            )
        case 4:
            return rings.ellipse((0, 0), (1, 0.4), 20).moved(move)
    return rings.path((0, 0), [SplineTo([(0.7, 0.4), (1, 0), (0.9, -0.8), (0, 0)])]).moved(move)


@pytest.mark.parametrize("rule", ["union", "minus", "intersection"])
@pytest.mark.parametrize("seed", sweep(range(25), quick=3))
def test_areas_are_those_of_polygons(rule, seed):
    random = np.random.default_rng(seed)
    operands = [[Area(random_shape(random))] for _ in range(5)]
    polygons = [shapely.Polygon(area.outer.outline) for (area,) in operands]
    first, *others = polygons
    expected = {
        "union": shapely.union_all(polygons),
        "minus": shapely.difference(first, shapely.union_all(others)),
        "intersection": shapely.intersection_all(polygons[:2]),
    }[rule]
    found = overlaid(rule, operands[:2] if rule == "intersection" else operands)
    assert size(found) == pytest.approx(expected.area, abs=2e-3)
    if found:
        whole = [area for area in found if shapely.Polygon(area.outer.outline).area > 1e-2]
        assert Domain.of_areas(whole).piece_count == len(whole)


@pytest.mark.parametrize("thin", [0.1, 1e-3, 1e-5])
def test_a_ring_thinner_than_the_error_of_its_chords_is_left_of_two_discs(thin):
    (area,) = overlaid("minus", [disc((0, 0), 1 + thin), disc((0, 0), 1)])
    radii = [hole.sides[0].curve.radius for hole in area.holes]
    assert (area.outer.sides[0].curve.radius, radii) == (1 + thin, [1])
