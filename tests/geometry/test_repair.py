"""Areas are mended as asked for, with exact areas, labels and curves kept; what was changed is told."""

import numpy as np
import pytest
import shapely

from bubblemesh.errors import GeometryError
from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.paths import Arc, Area
from bubblemesh.geometry.repair import Repair

MEND = Repair(mend=True)


def square(x, y, side):
    return rings.polygon([(x, y), (x + side, y), (x + side, y + side), (x, y + side)])


def told(areas):
    return [(change.what, change.area) for change in areas[0].outer.changes]


def area(areas):
    return Domain.of_areas(areas).polygon.area


def test_what_is_sound_stays_as_it_is():
    given = [Area(square(0, 0, 4), (rings.circle((2, 2), 1),))]
    assert MEND(given) == given


def test_a_bow_tie_becomes_two_areas():
    made = MEND([Area(rings.polygon([(0, 0), (2, 2), (2, 0), (0, 2)]))])
    assert len(made) == 2
    assert area(made) == 2
    assert told(made) == [("ring that crosses or touches itself", 2)]
    assert made[0].outer.changes[0].at == (1, 1)


def test_a_ring_that_turns_twice_encloses_its_area_once():
    corners = [(0, 0), (4, 0), (4, 4), (0, 4)]
    made = MEND([Area(rings.polygon([*corners, (0, -1), (5, -1), (5, 5), (-1, 5), (-1, 0)]))])
    assert area(made) == 36 - 1


def test_labels_stay_with_the_sides():
    ring = rings.polygon([(0, 0), (4, 0), (4, 4), (2, 4), (2, -1), (1, -1), (1, 4), (0, 4)], labels=list("abcdefgh"))
    curves = {side.label: side.curve for one in MEND([Area(ring)]) for side in one.outer.sides}
    assert set(curves) <= set("abcdefgh")
    assert {curves["e"].start, curves["e"].end} == {(2, -1), (1, -1)}
    assert {curves["b"].start, curves["b"].end} == {(4, 0), (4, 4)}


def test_holes_outside_and_across_and_over_each_other():
    holes = square(5, 5, 1), square(3, 1, 2), square(1, 1, 1), square(1.5, 1.5, 1)
    made = MEND([Area(square(0, 0, 4), holes)])
    assert area(made) == 16 - 2 - 1.75
    assert told(made) == [
        ("hole outside the area left out", 0),
        ("hole across the outer ring cut off there", 2),
        ("holes that overlap united", 0.25),
    ]


def test_cuts_leave_no_spikes():
    """A hole whose sides lie on those of the outer ring, but for rounding, from a common vertex on."""
    angle = np.arange(40) * np.pi / 20
    outer = np.column_stack([np.cos(angle), np.sin(angle)]) * (1 + 0.1 * np.cos(3 * angle + 1))[:, None]
    inner = 0.3 * outer + 0.7 * outer[0]
    made = MEND([Area(rings.polygon(outer.tolist()), (rings.polygon(inner.tolist()),))])
    assert area(made) == pytest.approx(shapely.Polygon(outer).area * (1 - 0.09), rel=1e-6)
    points = np.array(made[0].outer.vertices)
    back, ahead = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
    cosine = (back * ahead).sum(axis=1) / np.hypot(*back.T) / np.hypot(*ahead.T)
    assert cosine.min() > -0.99


def test_curves_that_no_change_touches_stay_curves():
    made = MEND([Area(square(0, 0, 4), (rings.circle((2, 2), 0.5), square(3, 3, 2)))])
    assert [isinstance(hole.sides[0].curve, Arc) for hole in made[0].holes] == [True]


def test_areas_that_overlap_or_share_a_side_become_one():
    made = MEND([Area(square(0, 0, 2)), Area(square(1, 1, 2)), Area(square(2, 0, 1)), Area(square(9, 9, 1))])
    assert len(made) == 2
    assert area(made) == 4 + 4 - 1 + 1 + 1


def grains(inner):
    """Four areas of a square that meet in two points, (1, 1) and another one."""
    (x, y), first = inner, (1, 1)
    corners = [(0, 0), (1, 0), first, (0, 1)], [(1, 0), (2, 0), (2, y), (x, y), first]
    corners = *corners, [(2, y), (2, 2), (1, 2), (x, y)], [(0, 1), first, (x, y), (1, 2), (0, 2)]
    return [Area(rings.polygon(points)) for points in corners]


def test_borders_that_are_too_short_become_points():
    made = Repair(simplify=0.05)(grains((1.01, 1.02)), united=False)
    assert {len({*one.outer.vertices} & {(1, 1)}) for one in made} == {1}
    assert shapely.coverage_is_valid([shapely.Polygon(one.outer.outline) for one in made])
    assert sum(shapely.Polygon(one.outer.outline).area for one in made) == pytest.approx(4)
    ((what, _),) = told(made)
    assert what == "1 short border between areas closed to a point, up to 0.0224 off"


def test_longer_borders_stay():
    made = Repair(simplify=0.02)(grains((1.01, 1.02)), united=False)
    assert told(made) == []


def test_areas_that_would_vanish_stay():
    small = [(1, 1), (1.01, 1), (1, 1.01)]
    around = (
        [(0, 0), (4, 0), small[1], small[0]],
        [(4, 0), (0, 4), small[2], small[1]],
        [(0, 4), (0, 0), small[0], small[2]],
    )
    made = Repair(simplify=0.1)([Area(rings.polygon(points)) for points in (small, *around)], united=False)
    assert [len(one.outer.vertices) for one in made] == [3, 4, 4, 4]


def test_gaps_between_areas_are_closed_up_to_the_tolerance():
    given = [Area(square(0, 0, 1)), Area(square(1.01, 0, 1)), Area(square(2.1, 0, 1))]
    assert len(MEND(given)) == 3
    made = Repair(mend=True, gap=0.02)(given)
    assert len(made) == 2
    assert area(made) == pytest.approx(3.01, abs=1e-7)
    assert [what for what, _ in told(made)] == ["gap between areas closed"]
    assert sorted(len(one.outer.vertices) for one in made) == [4, 4]


def test_small_islands_and_holes_are_left_out():
    given = [
        Area(square(0, 0, 4), (square(1, 1, 1), square(3, 3, 0.5))),
        Area(square(1.2, 1.2, 0.5)),
        Area(square(8, 8, 2)),
    ]
    made = Repair(smallest=1.5)(given)
    assert area(made) == 16 + 4
    assert told(made) == [
        ("1 island below 1.5 left out", -0.25),
        ("2 holes below 1.5 left out, the largest", 1.25),
    ]
    with pytest.raises(GeometryError, match="nothing is left of 3 areas"):
        Repair(smallest=100)(given)


def test_a_small_hole_of_neighbours_does_not_unite_them():
    hole = square(1, 1, 1)
    made = Repair(smallest=2)([Area(square(0, 0, 4), (hole,)), Area(square(4, 0, 4))], united=False)
    assert [shapely.Polygon(one.outer.outline).area for one in made] == [16, 16]
    assert told(made) == [("1 hole below 2 left out", 1)]


def test_small_neighbours_are_told_and_sides_keep_their_labels():
    a, b = (
        Area(rings.polygon(points, label=name), name=name)
        for name, points in {
            "a": [(0, 0), (4, 0), (4, 2), (4, 3), (4, 4), (0, 4)],
            "b": [(4, 0), (8, 0), (8, 4), (4, 4), (4, 3), (5, 3), (5, 2), (4, 2)],
        }.items()
    )
    stray = Area(rings.polygon([(4, 2), (5, 2), (5, 3), (4, 3)], label="c"), name="c")
    made = Repair(smallest=2).of_neighbours([a, b, stray])
    assert [(one.name, shapely.Polygon(one.outer.outline).area) for one in made] == [("a", 16), ("b", 16)]
    assert [{side.label for side in one.outer.sides} for one in made] == [{"a"}, {"b"}]
    assert told(made) == [("1 area below 2 given to a neighbour", 0)]
    assert made[0].outer.notes[0].startswith("1 area below 2 given to a neighbour, the largest (1) of 'c' to 'b' at (")
    assert Repair(smallest=0.5).of_neighbours([a, b, stray]) == [a, b, stray]


def test_regions_within_others_are_not_simplified():
    areas = [Area(square(0, 0, 4), name="a"), Area(square(1, 1, 1), name="b")]
    with pytest.raises(GeometryError, match="'b' lies within 'a', which has no hole there") as caught:
        Repair(simplify=0.1).of_neighbours(areas)
    assert not caught.value.mendable


def test_neighbours_are_simplified_alike():
    x = np.linspace(0, 4, 401)
    wave = np.column_stack([x, 0.05 * np.sin(40 * x)])
    low = rings.polygon([(0, -2), (4, -2), *wave[::-1].tolist()])
    high = rings.polygon([*wave.tolist(), (4, 2), (0, 2)])
    made = Repair(simplify=0.3)([Area(low), Area(high)])
    shapes = [shapely.Polygon(one.outer.vertices) for one in made]
    assert shapely.coverage_is_valid(shapes)
    assert sum(shape.area for shape in shapes) == pytest.approx(16, abs=1e-9)
    assert max(len(one.outer.vertices) for one in made) < 40
    assert "vertices left out" in told(made)[0][0]


def test_curves_are_not_simplified():
    made = Repair(simplify=0.3)(
        [Area(rings.polygon([(0, 0), (2, 0.01), (4, 0), (4, 4), (0, 4)]), (rings.circle((2, 2), 1),))]
    )
    assert len(made[0].outer.vertices) == 4
    assert isinstance(made[0].holes[0].sides[0].curve, Arc)


def test_rings_that_cross_are_not_simplified():
    with pytest.raises(GeometryError, match="set repair: true as well"):
        Repair(simplify=0.1)([Area(rings.polygon([(0, 0), (2, 2), (2, 0), (0, 2)]))])


def test_nodes_slide_along_what_is_left_of_curves():
    (made,) = MEND([Area(square(0, 0, 4), (rings.circle((4, 2), 1, label="cut"),))])
    assert len(made.outer.sides) == 4 + 2
    assert len([side for side in made.outer.sides if side.label == "cut"]) == 1
    assert area([made]) == pytest.approx(16 - np.pi / 2, abs=1e-3)


@pytest.mark.parametrize("neighbours", [1, 2])
def test_no_vertex_is_farther_from_a_simplified_ring_than_allowed(neighbours):
    random = np.random.default_rng(1)
    border = [(x, 0.3 * random.standard_normal()) for x in np.linspace(0, 20, 200)]
    sides = [[*border, (20, 9), (0, 9)], [*border, (20, -9), (0, -9)]][:neighbours]
    areas = [Area(rings.polygon(side)) for side in sides]
    for length in (0.05, 0.4):
        made = Repair(simplify=length)(areas)
        left = shapely.union_all([shapely.Polygon(one.outer.vertices).exterior for one in made])
        off = shapely.distance(shapely.points(border), left)
        assert off.max() <= length
        assert sum(len(one.outer.vertices) for one in made) < sum(map(len, sides))


def test_longer_lengths_leave_fewer_vertices_of_pixels():
    random = np.random.default_rng(2)
    height = 20 + np.cumsum(random.integers(-3, 4, 60))
    border = [(x + k, int(y)) for x, y in enumerate(height) for k in (0, 1)]
    areas = [Area(rings.polygon([*border, (60, far), (0, far)])) for far in (-200, 200)]
    left = [
        sum(len(one.outer.vertices) for one in Repair(simplify=length)(areas)) for length in np.arange(2, 6.1, 0.25)
    ]
    assert (np.diff(left) <= 0).all(), left
    assert left[0] > 1.5 * left[-1]


@pytest.mark.parametrize(
    ("corners", "count"),
    [
        (
            [(3.1, 1.3), (0.1, 3.3), (2.6, 1.5), (3.2, 2.7), (1.8, 2.4), (1.8, 3.1)],
            4,
        ),  # the wedge at a crossing is sharp
        ([(0, 0), (8, 0.1), (8, 0), (0, 0.1)], 2),
        # Three sides through one point, which the cuts give several times, with different roundings.
        (
            [
                (3.4, 2.6),
                (1.3, 2.3),
                (1.7, 0.6),
                (0.6, 3.5),
                (2, 2.7),
                (1, 1),
                (0.3, 1.9),
                (3.7, 3.6),
                (2.4, 3.3),
                (1.9, 2.9),
                (2.4, 2),
                (0.6, 2.2),
            ],
            2,
        ),
    ],
)
def test_what_a_ring_that_crosses_itself_falls_into_touches_in_points(corners, count):
    made = MEND([Area(rings.polygon(corners))])
    enclosed = shapely.make_valid(shapely.Polygon(corners), method="structure", keep_collapsed=False)
    assert len(made) == count
    assert area(made) == pytest.approx(enclosed.area, rel=1e-9)
    points = shapely.points(sorted({vertex for one in made for ring in one.rings for vertex in ring.vertices}))
    assert shapely.STRtree(points).query(points, predicate="dwithin", distance=1e-4).shape == (2, len(points))


def wedge(first, last):
    """A triangle with a corner at (0, 0), between two angles in degrees."""
    away = [(np.cos(angle), np.sin(angle)) for angle in np.radians([first, last])]
    return Area(rings.polygon([(0, 0), *away]))


@pytest.mark.parametrize(
    ("angles", "count"),
    [
        ([(0, 80), (90, 170)], 2),
        ([(0, 80), (90, 170), (180, 260)], 3),
        ([(0, 80), (80.001, 170), (180, 260)], 2),  # a gap that is closed up to the corner of the third one
    ],
)
def test_areas_that_touch_in_a_point_stay_apart_unless_there_is_a_long_gap(angles, count):
    made = MEND([wedge(*pair) for pair in angles])
    assert len(made) == count
    assert all((0, 0) in one.outer.vertices for one in made)
    assert Domain.of_areas(made).piece_count == count
