import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial import Delaunay

from bubblemesh.errors import GeometryError
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.meshes.triangulation import circumcircles, linked, sorted_triangles, triangulated

SQUARE = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])


def ring(first, count):
    numbers = first + np.arange(count)
    return np.column_stack([numbers, np.roll(numbers, -1)])


def random_square(seed, count=200):
    rng = np.random.default_rng(seed)
    return np.vstack([SQUARE, rng.uniform(0.01, 0.99, (count, 2))])


def test_triangles_of_a_convex_domain_are_those_of_delaunay():
    points = random_square(0)
    expected = {frozenset(t) for t in Delaunay(points).simplices.tolist()}
    assert {frozenset(t) for t in triangulated(points, ring(0, 4)).tolist()} == expected


@pytest.mark.parametrize(
    "triangles",
    [
        [[0, 1, 2], [0, 2, 3], [1, 4, 2]],
        [[0, 2, 3], [0, 1, 2], [1, 4, 2]],  # second nodes do not ascend
        [[1, 4, 2], [0, 1, 2], [0, 2, 3]],  # first nodes do not ascend
        [[1, 2, 0], [0, 2, 3], [1, 4, 2]],  # one begins with another node than its lowest
        [[0, 1, 2], [2, 3, 0], [2, 1, 4]],
    ],
)
def test_triangles_are_sorted_however_they_come(triangles):
    triangles = np.array(triangles)
    assert sorted_triangles(triangles).tolist() == [[0, 1, 2], [0, 2, 3], [1, 4, 2]]


def test_triangles_are_counter_clockwise_and_rows_are_sorted():
    points = random_square(1)
    triangles = triangulated(points, ring(0, 4))
    assert triangles.dtype == np.int64
    assert signed_areas(points, triangles).min() > 0
    assert (triangles.argmin(axis=1) == 0).all()
    assert triangles.tolist() == sorted(triangles.tolist())


@pytest.mark.parametrize("seed", range(3))
def test_linked_triangles_are_the_same_with_each_edge_once(seed):
    points = random_square(seed)
    triangles, sides = linked(points, ring(0, 4))
    np.testing.assert_array_equal(sorted_triangles(triangles), triangulated(points, ring(0, 4)))
    expected, count = unique_edges(triangles)
    assert sorted(map(sorted, sides.tolist())) == expected.tolist()
    assert np.issubdtype(sides.dtype, np.integer)
    assert (count == 1).sum() == 4


def test_a_single_triangle_has_three_edges():
    triangles, sides = linked(SQUARE[:3], ring(0, 3))
    assert sorted_triangles(triangles).tolist() == [[0, 1, 2]]
    assert sorted(map(sorted, sides.tolist())) == [[0, 1], [0, 2], [1, 2]]


@given(st.integers(0, 2**32 - 1))
def test_holes_stay_empty_and_constraints_are_edges_of_one_triangle(seed):
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.random(7)) * 2 * np.pi
    hole = 0.5 + 0.2 * np.column_stack([np.cos(angle), np.sin(angle)])
    far = rng.uniform(0.01, 0.99, (60, 2))
    far = far[np.hypot(*(far - 0.5).T) > 0.21]
    points = np.vstack([SQUARE, hole, far])
    constraints = np.vstack([ring(0, 4), ring(4, 7)])
    triangles = triangulated(points, constraints)
    sides, count = unique_edges(triangles)
    assert {tuple(side) for side in sides[count == 1].tolist()} == {tuple(sorted(e)) for e in constraints.tolist()}
    x, y = hole.T
    area = 1 - np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) / 2
    assert signed_areas(points, triangles).sum() == pytest.approx(area)


def test_order_of_constraints_does_not_change_the_result():
    points = random_square(2)
    constraints = ring(0, 4)
    assert (triangulated(points, constraints) == triangulated(points, constraints[::-1, ::-1])).all()


def test_rings_may_touch_in_a_node():
    points = np.vstack([SQUARE, [[0.3, 0.6], [0.6, 0.3]]])
    hole = np.array([[0, 4], [4, 5], [5, 0]])
    triangles = triangulated(points, np.vstack([ring(0, 4), hole]))
    assert signed_areas(points, triangles).sum() == pytest.approx(1 - (0.36 - 0.09) / 2)


@pytest.mark.parametrize("scale", [1e15, 1e-12])
def test_scale_does_not_matter(scale):
    points = random_square(3)
    assert (triangulated(points * scale, ring(0, 4)) == triangulated(points, ring(0, 4))).all()


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_points_that_are_not_finite_never_reach_the_library(value):
    points = SQUARE.copy()
    points[2, 0] = value
    with pytest.raises(ValueError, match="finite"):
        triangulated(points, ring(0, 4))


def test_coinciding_points_are_refused():
    with pytest.raises(GeometryError, match=r"cannot be connected at \(.*: duplicate vertex"):
        triangulated(np.vstack([SQUARE, SQUARE[:1]]), ring(0, 4))


def test_crossing_constraints_are_refused():
    with pytest.raises(GeometryError, match=r"cannot be connected at \(.*: intersecting"):
        triangulated(SQUARE, np.array([[0, 1], [1, 3], [3, 2], [2, 0]]))


def test_circumcircles_pass_through_the_corners():
    points = random_square(4) + 5
    triangles = triangulated(points, ring(0, 4))
    center, radius = circumcircles(points, triangles)
    for k in range(3):
        assert_allclose(np.hypot(*(points[triangles[:, k]] - center).T), radius, rtol=1e-6)


def test_circumcircle_of_a_flat_triangle_is_infinite():
    radius = circumcircles(np.array([[0, 0], [1, 1], [2, 2.0]]), np.array([[0, 1, 2]]))[1]
    assert radius.tolist() == [np.inf]
