import numpy as np
import pytest
from quadtrees import balanced

from bubblemesh.spacing.grid.quadtree import Quadtree
from bubblemesh.spacing.rules.eikonal import limited_values


def lattice(level):
    grid = Quadtree.around((0, 0, 1, 1))
    for _ in range(level):
        grid, _, _ = grid.split(np.ones(len(grid), bool))
    return grid


def everywhere(grid):
    return np.ones(len(grid), bool)


def from_the_middle(grid, value=0.1):
    values = np.full(len(grid.vertices.points), np.inf)
    away = np.hypot(*(grid.vertices.points - 0.5).T)
    values[away.argmin()] = value
    return values, away


def test_distance_from_a_point_is_met_to_first_order():
    errors = []
    for level in (4, 5, 6, 7):
        grid = lattice(level)
        values, away = from_the_middle(grid)
        errors.append(np.abs(limited_values(grid, values, 0.3, everywhere(grid)) - 0.1 - 0.3 * away).max())
    assert np.polyfit([4, 5, 6, 7], np.log2(errors), 1)[0] < -0.6
    assert errors[-1] < 0.004


def test_distance_from_a_line_is_exact_along_the_axes():
    grid = lattice(4)
    x = grid.vertices.points[:, 0]
    values = np.where(x < 0.01, 0.2, np.inf)
    np.testing.assert_allclose(limited_values(grid, values, 0.5, everywhere(grid)), 0.2 + 0.5 * x, rtol=1e-6, atol=1e-8)


def test_values_that_grow_slowly_stay():
    grid = lattice(5)
    values = 0.1 + 0.29 * np.hypot(*grid.vertices.points.T)
    np.testing.assert_array_equal(limited_values(grid, values, 0.3, everywhere(grid)), values)


@pytest.mark.parametrize("growth", [0.1, 0.5])
def test_values_grow_no_faster_than_the_limit_and_are_the_largest_such(growth):
    grid = lattice(4)
    values = np.random.default_rng(0).uniform(0.1, 2, len(grid.vertices.points))
    found, points = limited_values(grid, values, growth, everywhere(grid)), grid.vertices.points
    assert (found <= values).all()
    for first, last in ([0, 1], [2, 3], [0, 2], [1, 3], [0, 3], [1, 2]):
        a, b = grid.vertices.corners[:, first], grid.vertices.corners[:, last]
        length = np.hypot(*(points[a] - points[b]).T)
        assert (np.abs(found[a] - found[b]) <= growth * length * (1 + 1e-4)).all()
    away = np.hypot(*(points[:, None] - points).transpose(2, 0, 1))
    largest = (values + growth * away).min(axis=1)
    assert (found >= largest * 0.97).all()
    assert (found <= largest * 1.1 + growth * 0.1).all()


def test_growth_is_the_same_on_cells_of_many_sizes():
    grid = Quadtree.around((0, 0, 1, 1))
    for _ in range(8):
        grid, _, _ = grid.split(np.hypot(*(grid.centers - 0.5).T) < 1.5 * grid.sides)
    grid = balanced(grid)
    values, away = from_the_middle(grid, 0.01)
    np.testing.assert_allclose(limited_values(grid, values, 0.3, everywhere(grid)), 0.01 + 0.3 * away, rtol=0.08)


def test_hanging_vertices_are_means_so_that_the_interpolation_is_continuous():
    grid = Quadtree.around((0, 0, 1, 1))
    for _ in range(6):
        grid, _, _ = grid.split(np.hypot(*(grid.centers - 0.4).T) < 1.5 * grid.sides)
    grid = balanced(grid)
    values, _ = from_the_middle(grid, 0.01)
    found = limited_values(grid, values, 0.3, everywhere(grid))
    middle, first, last = grid.vertices.hanging.T
    assert len(middle) > 5
    np.testing.assert_allclose(found[middle], (found[first] + found[last]) / 2, rtol=1e-14)


def test_values_go_around_what_is_outside():
    grid = lattice(6)
    wall = (np.abs(grid.centers[:, 0] - 0.5) < 0.05) & (grid.centers[:, 1] < 0.9)
    points = grid.vertices.points
    values = np.where(np.hypot(*(points - [0.25, 0.125]).T) < 1e-6, 0.0, np.inf)
    found = limited_values(grid, values, 1.0, ~wall)
    behind = np.hypot(*(points - [0.75, 0.125]).T).argmin()
    around = 2 * np.hypot(0.2, 0.775) + 0.1
    assert found[behind] == pytest.approx(around, rel=0.02)
    assert np.isfinite(found).all()  # outside they follow from those inside


def test_nothing_known_stays_unknown():
    grid = lattice(3)
    assert np.isinf(limited_values(grid, np.full(len(grid.vertices.points), np.inf), 0.3, everywhere(grid))).all()
