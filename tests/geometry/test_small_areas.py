"""Small areas and holes among neighbours become part of what is beside them."""

import numpy as np
import pytest
import shapely

from bubblemesh.geometry.neighbours import owners
from bubblemesh.geometry.small_areas import absorbed, notes_of

LEFT, RIGHT, TOP = shapely.box(0, 0, 10, 10), shapely.box(10, 0, 20, 10), shapely.box(0, 10, 20, 20)
PIXEL = shapely.box(10, 5, 11, 6)


def pieces(*shapes):
    return np.array(shapes, dtype=object)


def noded(*shapes):
    """The polygons with the vertices of all others that lie on their borders."""
    points = shapely.multipoints(shapely.get_coordinates(list(shapes)))
    return np.array([shapely.snap(shape, points, 1e-9) for shape in shapes], dtype=object)


def areas(found):
    return {name: shape.area for name, shape in zip(found.names, found.shapes, strict=True)}


def test_a_piece_goes_to_the_longest_border_and_the_first_of_equal_ones():
    shapes = noded(LEFT, RIGHT.difference(PIXEL), PIXEL, shapely.box(20, 0, 21, 1), shapely.box(21, 0, 22, 1))
    assert owners(shapes, np.array([0, 0, 1, 1, 1], bool)).tolist() == [0, 1, 1, 1, 1]
    halves = pieces(shapely.box(0, 0, 1, 1), shapely.box(1, 0, 2, 1), shapely.box(2, 0, 3, 1), shapely.box(5, 0, 6, 1))
    assert owners(halves, np.array([0, 1, 0, 1], bool)).tolist() == [0, 0, 2, -1]


def test_a_hole_is_filled_and_the_neighbours_stay_as_they_are():
    """A small hole in one of two that have a common side."""
    shapes = pieces(LEFT.difference(shapely.box(3, 3, 4, 4)), RIGHT)
    found = absorbed(shapes, ["a", "b"], 2)
    assert areas(found) == {"a": 100, "b": 100}
    assert found.shapes[1] is shapes[1]
    assert [hole.area for hole in found.filled] == [1]
    assert absorbed(shapes, ["a", "b"], 0.5).shapes == shapes.tolist()


def test_an_area_between_neighbours_leaves_no_hole():
    shapes = noded(LEFT, RIGHT.difference(PIXEL), TOP, PIXEL)
    names = ["a", "b", "c", "c"]
    found = absorbed(shapes, names, 2)
    assert areas(found) == {"a": 100, "b": 100, "c": 200}
    assert shapely.coverage_is_valid(found.shapes)
    assert notes_of(found, shapes, names, 2) == [
        "1 area below 2 given to a neighbour, the largest (1) of 'c' to 'b' at (10.5, 5.5)"
    ]


def test_a_hole_that_three_leave_between_them_is_filled():
    a = shapely.Polygon([(0, 0), (100, 0), (100, 50), (50.5, 50), (49.5, 50), (0, 50)])
    b = shapely.Polygon([(0, 50), (49.5, 50), (50, 50.5), (50, 100), (0, 100)])
    c = shapely.Polygon([(100, 50), (100, 100), (50, 100), (50, 50.5), (50.5, 50)])
    found = absorbed(pieces(a, b, c), ["a", "b", "c"], 1)
    assert areas(found) == {"a": 5000.25, "b": 2499.875, "c": 2499.875}


def test_areas_without_a_neighbour_are_left_out_and_those_within_another_one_go_to_it():
    within, alone = shapely.box(4, 4, 5, 5), shapely.box(30, 0, 31, 1)
    in_a_hole = shapely.box(13.2, 3.2, 13.4, 3.4)
    shapes = pieces(LEFT, RIGHT.difference(shapely.box(13, 3, 14, 4)), within, alone, in_a_hole)
    names = ["a", "b", "c", "d", "e"]
    found = absorbed(shapes, names, 2)
    assert areas(found) == {"a": 100, "b": 100}
    assert (found.owner.tolist(), found.given, found.left) == ([0, 1, 0, -1, 1], [2, 4], [3])
    assert notes_of(found, shapes, names, 2) == [
        "2 areas below 2 given to a neighbour, the largest (1) of 'c' to 'a' at (4.5, 4.5)",
        "1 area below 2 left out and given to none, the largest (1) of 'd' at (30.5, 0.5)",
        "all of 'c', 'd', 'e' is below 2: no such region is left",
    ]


def test_outer_rings_of_curved_areas_stay():
    """What is between two is left out, since their curves could not be joined exactly; what is in one goes to it."""
    within = shapely.Point(3, 3).buffer(0.5)
    shapes = noded(LEFT.difference(within), RIGHT.difference(PIXEL), PIXEL, within)
    found = absorbed(shapes, ["a", "b", "c", "d"], 2, curved=True)
    assert areas(found) == pytest.approx({"a": 100, "b": 99})
    assert (found.given, found.left) == ([3], [2])


def test_areas_of_one_name_that_come_to_meet_become_one():
    shapes = noded(LEFT, shapely.box(10, 0, 11, 10), shapely.box(11, 0, 21, 10))
    found = absorbed(shapes, ["a", "b", "a"], 15)
    assert areas(found) == {"a": 210}


@pytest.mark.parametrize("seed", range(5))
def test_pictures_of_labels_lose_no_area(seed):
    """Random pixels of three names, some of them void: what is large stays, what is small is part of a neighbour."""
    label = np.random.default_rng(seed).choice(4, p=[0.07, 0.31, 0.31, 0.31], size=(12, 12))
    boxes = [[shapely.box(x, y, x + 1, y + 1) for x, y in np.argwhere(label == k)] for k in (1, 2, 3)]
    parts = [shapely.get_parts(shapely.coverage_union_all(some)) for some in boxes]
    shapes = noded(*np.concatenate(parts))
    names = np.repeat(["a", "b", "c"], [len(some) for some in parts]).tolist()
    found = absorbed(shapes, names, 4)
    assert shapely.coverage_is_valid(found.shapes)
    solid = shapely.area(shapely.polygons(shapely.get_exterior_ring(shapes)))
    kept = np.flatnonzero(solid >= 4)
    now = shapely.STRtree(found.shapes).query(shapely.point_on_surface(shapes[kept]), predicate="within")
    assert [names[kept[k]] for k in now[0]] == [found.names[k] for k in now[1]]
    assert len(now[0]) == len(kept) > 0
    lost = shapely.difference(shapely.union_all(shapes), shapely.union_all(found.shapes)).area
    assert lost == sum(shapes[k].area for k in found.left)
    for name in "abc":
        own = [shape for shape, other in zip(found.shapes, found.names, strict=True) if other == name]
        assert shapely.length(shapely.coverage_union_all(own)) == shapely.length(own).sum()
