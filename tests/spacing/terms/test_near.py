import numpy as np
import pytest

from bubblemesh.geometry.distance.distances import distance_to_line
from bubblemesh.spacing.terms.proximity import TOGETHER, Proximities, Proximity

X, Y = np.random.default_rng(0).uniform(-1, 2, (2, 1000))


class Counted:
    """A distance that counts how often it is asked."""

    costly = True

    def __init__(self, point):
        self.distance, self.asked = distance_to_line([point]), 0

    def __call__(self, points):
        self.asked += len(points)
        return self.distance(points)


def near(point, size, growth, until=0.0):
    return Proximity(Counted(point), size, growth, until)


def test_size_grows_with_the_distance():
    values = near((1, 0.5), 0.01, 0.15)(X, Y)
    np.testing.assert_allclose(values, 0.01 + 0.15 * np.hypot(X - 1, Y - 0.5), rtol=1e-14)
    assert near((1, 0.5), 0.01, 0.15)(np.array([1.0]), np.array([0.5])) == 0.01


def test_size_stays_until_a_distance():
    values = near((1, 0.5), 0.01, 0.15, until=0.4)(X, Y)
    r = np.hypot(X - 1, Y - 0.5)
    np.testing.assert_allclose(values, np.where(r <= 0.4, 0.01, 0.01 + 0.15 * (r - 0.4)), rtol=1e-14)
    assert (values == 0.01).any()


def test_of_several_terms_the_smallest_counts():
    terms = (near((0, 0), 0.01, 0.3), near((1, 1), 0.05, 0.1, until=0.2), near((1.5, -1), 0.002, 1.0))
    expected = np.min([term(X, Y) for term in terms], axis=0)
    assert len(np.unique(np.argmin([term(X, Y) for term in terms], axis=0))) == 3
    np.testing.assert_array_equal(Proximities(terms)(X, Y), expected)


@pytest.mark.parametrize("count", [0, 1, 2, TOGETHER, TOGETHER + 1])
def test_few_points_are_answered_too(count):
    terms = (near((0, 0), 0.01, 0.3), near((1, 1), 0.05, 0.1))
    expected = np.minimum(*(term(X[:count], Y[:count]) for term in terms))
    np.testing.assert_array_equal(Proximities(terms)(X[:count], Y[:count]), expected)


def test_equal_terms_and_points_are_no_obstacle():
    terms = (near((0, 0), 0.01, 0.3), near((0, 0), 0.01, 0.3))
    np.testing.assert_allclose(Proximities(terms)(np.ones(99), np.zeros(99)), 0.31, rtol=1e-15)


def test_distances_that_cannot_matter_are_not_computed():
    terms = tuple(near((10.0 * k, 0), 0.01, 0.2) for k in range(9))
    Proximities(terms)(X, Y)
    assert terms[0].distance.asked >= len(X)
    assert sum(term.distance.asked for term in terms[1:]) < len(X)
