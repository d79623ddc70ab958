"""Means over the cells of nodes, beside exact integrals."""

import numpy as np
import pytest

from bubblemesh.meshes.cell_means import cell_means

ONE = np.array([[0.0, 0.0], [6.0, 0.0], [0.0, 6.0]]), np.array([[0, 1, 2]])


def test_quadratic_functions_have_exact_means_in_small_parts():
    points, triangles = ONE
    # Over the cell of (0, 0), with the corners (0, 0), (3, 0), (2, 2), (0, 3): integrals of x and x^2 by hand.
    area, first, second = 6.0, 7.0, 11.5
    np.testing.assert_allclose(cell_means(points, triangles, lambda x, y: x, np.inf)[0], first / area)
    for across in (4, 1, 0.5):
        np.testing.assert_allclose(cell_means(points, triangles, lambda x, y: x**2, across)[0], second / area)


def test_jumps_are_as_right_as_the_parts_are_small():
    points, triangles = ONE
    # 1 where x < 1, of the cell's (0, 0), (3, 0), (2, 2), (0, 3): between y = 0 and 3 - x / 2, an area of 2.75.
    found = [cell_means(points, triangles, lambda x, y: 1.0 * (x < 1), across)[0] for across in (np.inf, 0.1)]
    assert abs(found[0] - 2.75 / 6) < 0.2
    assert abs(found[1] - 2.75 / 6) < 0.005


@pytest.mark.parametrize("across", [np.inf, 0.3, 1e-9])
def test_areas_and_constants_are_exact_on_any_parts(across):
    rng = np.random.default_rng(0)
    points, triangles = rng.uniform(0, 1, (6, 2)), np.array([[0, 1, 2], [3, 4, 5]])
    np.testing.assert_allclose(cell_means(points, triangles, lambda x, y: 0 * x + 7, across), 7)
    # The three means of a triangle have the mean that a linear function has on it.
    means = cell_means(points, triangles, lambda x, y: 1 + 2 * x - 3 * y, across)
    expected = 1 + points[triangles].mean(axis=1) @ [2, -3]
    np.testing.assert_allclose(means[triangles].mean(axis=1), expected)


def test_nodes_of_no_triangle_have_none():
    points, triangles = ONE
    means = cell_means(np.vstack([points, [[9.0, 9.0]]]), triangles, lambda x, y: 1 + 0 * x, np.inf)
    np.testing.assert_allclose(means, [1, 1, 1, 0])
