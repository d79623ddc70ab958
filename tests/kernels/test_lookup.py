import numpy as np
import pytest
from twins import needs_compiler

from bubblemesh.kernels.lookup import interpolated, interpolated_in_numpy, ranks
from bubblemesh.spacing.grid.quadtree import Quadtree

pytestmark = needs_compiler


def grown(random, rounds=6):
    """A grid with some cells split at random, again and again."""
    grid = Quadtree.around((-3.0, 2.0, 1.0, 4.0))
    for _ in range(rounds):
        grid, _, _ = grid.split((random.random(len(grid)) < 0.6) & grid.divisible)
    return grid


@pytest.mark.parametrize("with_equal", [False, True])
@pytest.mark.parametrize("seed", range(8))
def test_both_engines_find_the_same_ranks(seed, with_equal):
    random = np.random.default_rng(seed)
    ascending = np.sort(random.integers(-50, 50, random.integers(0, 200)))  # many are equal
    walk = np.cumsum(random.integers(-3, 4, 300))
    numbers = np.concatenate([walk, random.integers(-80, 80, 300), np.iinfo(np.int64).max + np.array([-1, 0])])
    numbers = np.append(numbers, [np.iinfo(np.int64).min, 0])
    expected = np.searchsorted(ascending, numbers, side="right" if with_equal else "left")
    np.testing.assert_array_equal(ranks(ascending, numbers, with_equal), expected)


@pytest.mark.parametrize("seed", range(8))
def test_both_engines_interpolate_to_the_last_bit(seed):
    random = np.random.default_rng(seed)
    grid = grown(random)
    vertices = np.where(random.random((len(grid), 1)) < 0.8, grid.vertices.corners, -1)
    values = random.uniform(0.1, 3.0, len(grid.vertices.key))
    values[random.random(len(values)) < 0.05] = np.inf
    points = np.vstack([random.uniform([-4, 1], [2, 7], (2000, 2)), grid.vertices.points, grid.centers])
    points = np.vstack([points, [[np.inf, 3.0], [-np.inf, -np.inf], [np.nan, 3.0], [0.0, np.nan]]])
    points = points[random.permutation(len(points))]
    with np.errstate(invalid="ignore"):
        expected = interpolated_in_numpy(grid.cells, vertices, values, points)
    found = interpolated(grid.cells, vertices, values, points)
    np.testing.assert_array_equal(found, expected)  # one that is no number may be another such one
    known = ~np.isnan(expected)
    assert found[known].tobytes() == expected[known].tobytes()
    assert np.isfinite(found).any()
    assert np.isinf(found).any()


def test_coordinates_that_are_no_numbers_are_in_the_first_column_and_row():
    cells = grown(np.random.default_rng(0), 2).cells
    points = np.array([[np.nan, 3.0], [0.0, np.nan], [np.nan, np.nan]])
    with np.errstate(invalid="raise"):
        found = cells.keys_of(points)
    assert found.tolist() == cells.keys_of(np.where(np.isnan(points), cells.low, points)).tolist()


def test_no_points_and_no_numbers():
    grid = grown(np.random.default_rng(0), 2)
    corners = grid.vertices.corners
    assert interpolated(grid.cells, corners, np.ones(len(grid.vertices.key)), np.zeros((0, 2))).shape == (0,)
    none = np.zeros(0, np.int64)
    assert ranks(none, np.array([3, -3])).tolist() == [0, 0]
    assert ranks(np.array([1, 2]), none).shape == (0,)
