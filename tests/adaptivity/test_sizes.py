"""Sizes from indicators."""

import numpy as np
import pytest

from bubblemesh.adaptivity.estimate import Estimate
from bubblemesh.adaptivity.sizes import (
    equivalent_sizes,
    predicted_error,
    sizes_for_error,
    sizes_for_nodes,
    smooth_sizes,
)

RANDOM = np.random.default_rng(3)
SIZES = RANDOM.uniform(0.5, 2, 500)
UNEVEN = Estimate(RANDOM.uniform(0.2, 1, 500), norm=100.0)


@pytest.mark.parametrize("error", [1.0, 5.0, 15.0])
def test_sizes_for_an_error_lead_to_it_evenly(error):
    new = sizes_for_error(UNEVEN, SIZES, error)
    assert predicted_error(UNEVEN, SIZES, new) == pytest.approx(error)
    number = (SIZES / new) ** 2
    each = UNEVEN.indicators * new / SIZES / np.sqrt(number)
    np.testing.assert_allclose(each, each[0])


@pytest.mark.parametrize("error", [2.0, 6.0])
def test_no_other_sizes_reach_the_error_with_fewer_triangles(error):
    best = sizes_for_error(UNEVEN, SIZES, error)
    for _ in range(50):
        other = best * RANDOM.uniform(0.9, 1.1, len(best))
        other *= error / predicted_error(UNEVEN, SIZES, other)
        assert ((SIZES / other) ** 2).sum() > ((SIZES / best) ** 2).sum()


@pytest.mark.parametrize("nodes", [200, 1000, 5000])
def test_sizes_for_nodes_are_those_of_the_error_they_reach(nodes):
    new = sizes_for_nodes(UNEVEN, SIZES, nodes)
    assert ((SIZES / new) ** 2).sum() / 2 == pytest.approx(nodes)
    np.testing.assert_allclose(new, sizes_for_error(UNEVEN, SIZES, predicted_error(UNEVEN, SIZES, new)))


def test_sizes_change_by_limited_factors():
    extreme = Estimate(np.array([*[1e-9] * 500, *[1.0] * 499, 1e9]), norm=1e9)
    new = sizes_for_nodes(extreme, np.full(1000, 0.1), 1000)
    assert (new[0], new[-1]) == (pytest.approx(0.2), pytest.approx(0.1 / 16 / np.sqrt(2)))
    assert sizes_for_nodes(extreme, np.full(1000, 0.1), 5).max() == pytest.approx(0.2 * 10)
    assert sizes_for_error(extreme, np.full(1000, 0.1), 1e20).max() == pytest.approx(0.2)


@pytest.mark.parametrize("indicators", [np.zeros(4), np.array([0, 1, 2, 3]) * 1e-17])
def test_sizes_without_an_error_grow_alike(indicators):
    nothing = Estimate(indicators, norm=1.0)
    np.testing.assert_allclose(sizes_for_error(nothing, SIZES[:4], 0.1), 2 * SIZES[:4])
    np.testing.assert_allclose(sizes_for_nodes(nothing, SIZES[:4], 2), 2 * SIZES[:4])


def test_equivalent_sizes_and_their_means():
    height = np.sqrt(3) / 2
    points = np.array([[0.0, 0], [1, 0], [0.5, height], [1.5, height], [1, 2 * height]]) * 0.3
    triangles = np.array([[0, 1, 2], [1, 3, 2], [2, 3, 4]])
    np.testing.assert_allclose(equivalent_sizes(points, triangles), 0.3)
    np.testing.assert_allclose(smooth_sizes(points, triangles), 0.3)
    points[4] += [0, 0.5]
    smooth = smooth_sizes(points, triangles)
    assert 0.3 < smooth[0] < smooth[4] < equivalent_sizes(points, triangles)[2]
