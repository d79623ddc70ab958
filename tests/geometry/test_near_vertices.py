"""Short sides and spikes of rings are left out, and neighbours keep their common borders."""

import numpy as np
import pytest
import shapely

from bubblemesh.geometry.near_vertices import without_near_vertices

NEAR = 1e-6


def cleaned(*shapes):
    found, changed = without_near_vertices(np.array(shapes), NEAR)
    return found.tolist(), changed.tolist()


def test_shapes_without_any_stay_the_same():
    hole = shapely.box(0, 0, 3, 3) - shapely.box(1, 1, 2, 2)
    (found, beside), changed = cleaned(hole, shapely.box(3, 0, 4, 3))
    assert (found, beside, changed) == (hole, shapely.box(3, 0, 4, 3), [False, False])


@pytest.mark.parametrize("turned", [False, True])
def test_neighbours_have_the_same_end_of_a_short_side(turned):
    border = [(1, 0), (1, 1), (1 + 5e-7, 1 + 5e-7), (1, 2)]
    left = shapely.Polygon([(0, 0), *border, (0, 2)])
    right = shapely.Polygon([(2, 2), *border[::-1], (2, 0)])
    (left, right), changed = cleaned(left.reverse() if turned else left, right)
    assert changed == [True, True]
    assert len(left.exterior.coords) == len(right.exterior.coords) == 6
    assert shapely.coverage_is_valid([left, right])


def test_chains_of_short_sides_become_a_point():
    steps = [(1 + k * 4e-7, 0) for k in range(20)]
    (found,), changed = cleaned(shapely.Polygon([(0, 0), *steps, (2, 0), (2, 1)]))
    assert changed == [True]
    assert len(found.exterior.coords) == 5


@pytest.mark.parametrize("width", [0, 1e-7])
def test_spikes_are_left_out(width):
    (found,), changed = cleaned(shapely.Polygon([(0, 0), (1, 0), (5, 3e-8), (1, width), (1, 1), (0, 1)]))
    assert changed == [True]
    assert found.bounds == pytest.approx((0, 0, 1, 1), abs=1e-6)
    assert found.area == pytest.approx(1, abs=1e-6)


def test_a_shape_that_would_vanish_stays_and_with_it_its_neighbour():
    tiny = shapely.Polygon([(1, 1), (1 + 5e-7, 1), (1, 1 + 5e-7)])
    beside = shapely.Polygon([(0, 0), (1, 1), (1 + 5e-7, 1), (2, 0)])
    found, changed = cleaned(tiny, beside)
    assert (found, changed) == ([tiny, beside], [False, False])


def test_parts_and_holes_are_cleaned_too():
    hole = shapely.Polygon([(1, 1), (2, 1), (2, 1 + 5e-7), (2, 2), (1, 2)])
    shape = shapely.MultiPolygon([shapely.box(0, 0, 3, 3) - hole, shapely.box(5, 0, 6, 1)])
    (found,), changed = cleaned(shape)
    assert changed == [True]
    assert [len(ring.coords) for part in found.geoms for ring in (part.exterior, *part.interiors)] == [5, 5, 5]
