import numpy as np
import pytest
from quadtrees import balanced

from bubblemesh.spacing.grid.quadtree import GRID_LEVELS, Quadtree


def grown(bounds=(-1.0, 2.0, 3.0, 5.0), rounds=5, seed=0):
    """A grid with some cells split at random, again and again."""
    random = np.random.default_rng(seed)
    grid = Quadtree.around(bounds)
    for _ in range(rounds):
        grid, _, _ = grid.split(random.random(len(grid)) < 0.6)
    return grid


def spans(grid):
    half = grid.sides[:, None] / 2
    return grid.centers - half, grid.centers + half


def test_cells_tile_the_square():
    grid = grown()
    assert len(grid) > 50
    assert (grid.sides**2).sum() == pytest.approx(grid.size**2, rel=1e-12)
    assert len(np.unique(grid.column_row, axis=0)) == len(grid)


@pytest.mark.parametrize("seed", [0, 1])
def test_every_point_is_located_in_the_cell_that_holds_it(seed):
    grid = grown(seed=seed)
    points = np.random.default_rng(9).uniform([-1, 2], [3, 5], (500, 2))
    low, high = spans(grid)
    holding = ((points[:, None] >= low) & (points[:, None] < high)).all(axis=2)
    assert (holding.sum(axis=1) == 1).all()
    np.testing.assert_array_equal(grid.located(points), holding.argmax(axis=1))


def test_points_beyond_the_square_count_as_on_its_rim():
    grid = grown()
    inside, outside = np.array([[-1.0, 2.0], [3.0, 6.0]]), np.array([[-7.0, -7.0], [9.0, 99.0]])
    np.testing.assert_array_equal(grid.located(outside), grid.located(np.clip(outside, inside[0], inside[1])))


def test_split_tells_where_cells_come_from():
    grid = grown(rounds=3)
    chosen = np.arange(len(grid)) % 3 == 0
    finer, origin, fresh = grid.split(chosen)
    assert len(finer) == len(grid) + 3 * chosen.sum()
    np.testing.assert_array_equal(fresh, chosen[origin])
    np.testing.assert_array_equal(grid.located(finer.centers), origin)
    np.testing.assert_allclose(finer.sides, grid.sides[origin] / np.where(fresh, 2, 1))


def test_quarters_are_those_of_a_split_of_all_cells():
    grid = grown(rounds=3)
    split, _, _ = grid.split(np.ones(len(grid), bool))
    quarters = grid.quarters()
    for name in ("level", "column_row", "key"):
        np.testing.assert_array_equal(getattr(quarters, name), getattr(split, name))
    np.testing.assert_allclose(quarters.centers.reshape(-1, 4, 2).mean(axis=1), grid.centers)
    meeting = quarters.between_quarters()
    np.testing.assert_allclose(meeting[:, 2], grid.centers)
    np.testing.assert_allclose(meeting.mean(axis=1), grid.centers)
    np.testing.assert_allclose(np.ptp(meeting, axis=1), grid.sides[:, None] * [1, 1])


def test_balanced_cells_beside_each_other_differ_by_one_level_at_most():
    grid = Quadtree.around((0, 0, 1, 1))
    for _ in range(9):
        grid, _, _ = grid.split(np.arange(len(grid)) == grid.located(np.array([[0.3, 0.61]]))[0])
    assert len(grid.unbalanced())
    even = balanced(grid)
    assert len(even.unbalanced()) == 0
    (a, b), level = spans(even), even.level
    touching = (a[:, None] <= b + 1e-12).all(axis=2) & (b[:, None] >= a - 1e-12).all(axis=2)
    overlap = np.minimum(b[:, None], b) - np.maximum(a[:, None], a)
    sharing = touching & (overlap.max(axis=2) > 1e-9)  # a side, not a corner alone
    assert np.abs(level[:, None] - level)[sharing].max() == 1
    assert even.level.max() == grid.level.max()


def test_vertices_are_the_corners_each_once():
    grid = balanced(grown())
    _, points, corners, *_ = grid.vertices
    assert len(np.unique(points.round(12), axis=0)) == len(points)
    low, high = spans(grid)
    for k, place in enumerate(
        [low, np.column_stack([high[:, 0], low[:, 1]]), np.column_stack([low[:, 0], high[:, 1]])]
    ):
        np.testing.assert_allclose(points[corners[:, k]], place, atol=1e-12)
    np.testing.assert_allclose(points[corners[:, 3]], high, atol=1e-12)


def test_hanging_vertices_are_in_the_middle_of_a_side_and_none_is_missed():
    grid = balanced(grown())
    _, points, corners, hanging, level = grid.vertices
    middle, first, last = hanging.T
    assert len(hanging) > 10
    lengths = np.abs(points[first] - points[last]).max(axis=1)
    np.testing.assert_allclose(lengths, grid.size / 2.0**level)
    assert (np.diff(level) >= 0).all()
    np.testing.assert_allclose(points[middle], (points[first] + points[last]) / 2, atol=1e-12)
    sides = {tuple(sorted(pair)) for pair in corners[:, [[0, 1], [2, 3], [0, 2], [1, 3]]].reshape(-1, 2).tolist()}
    assert {tuple(sorted(pair)) for pair in hanging[:, 1:].tolist()} <= sides
    low, high = spans(grid)
    on_rim = (points[:, None] >= low - 1e-12).all(axis=2) & (points[:, None] <= high + 1e-12).all(axis=2)
    cells_at = on_rim.sum(axis=1)
    corner_of = np.bincount(corners.ravel(), minlength=len(points))
    assert set(middle.tolist()) == set(np.flatnonzero(cells_at > corner_of).tolist())


def test_bilinear_functions_are_interpolated_exactly():
    grid = balanced(grown())

    def function(points):
        x, y = points.T
        return 1 + 2 * x - 3 * y + 0.5 * x * y

    points = np.random.default_rng(2).uniform([-1, 2], [3, 5], (400, 2))
    cells = grid.located(points)
    found = grid.cells.bilinear(function(grid.vertices.points)[grid.vertices.corners[cells]], points, cells)
    np.testing.assert_allclose(found, function(points), rtol=1e-12)


def test_deepest_level_is_reached_without_overflow():
    grid = Quadtree.around((0, 0, 1, 1))
    place = np.array([[0.999999999, 0.999999999]])
    for _ in range(GRID_LEVELS):
        grid, _, _ = grid.split(np.arange(len(grid)) == grid.located(place)[0])
    assert grid.level.max() == GRID_LEVELS
    assert (np.abs(grid.centers[grid.located(place)] - place) <= grid.size / 2**GRID_LEVELS).all()
