import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import interpolate

from bubblemesh.errors import GeometryError
from bubblemesh.geometry.cubic_splines import CubicSpline


def by_scipy(points, slopes=None, ends="not-a-knot"):
    u = np.append(0, np.cumsum(np.hypot(*np.diff(points, axis=0).T)))
    return interpolate.CubicSpline(
        u / u[-1], points, bc_type=ends if slopes is None else tuple((1, s * u[-1]) for s in slopes)
    )


def walk(count, seed=0):
    return np.random.default_rng(seed).standard_normal((count, 2)).cumsum(axis=0)


def require_same(spline, other):
    u = np.append(np.random.default_rng(1).random(50), [0, 1])
    assert_allclose(spline.breaks, other.x, rtol=0, atol=0)
    assert_allclose(spline.points(u), other(u), rtol=1e-11, atol=1e-11)
    assert_allclose(spline.rates(u), other(u, 1), rtol=1e-11, atol=1e-10)


@pytest.mark.parametrize("count", [2, 3, 4, 5, 40, 3000])
def test_ends_are_not_a_knot_as_those_of_scipy(count):
    points = walk(count)
    require_same(CubicSpline.through(points), by_scipy(points))


@pytest.mark.parametrize("count", [4, 5, 6, 41])
def test_closed_points_give_the_periodic_spline_of_scipy_unless_they_are_cornered(count):
    points = walk(count)
    points[-1] = points[0]
    require_same(CubicSpline.through(points), by_scipy(points, ends="periodic"))
    require_same(CubicSpline.through(points, cornered=True), by_scipy(points))


@pytest.mark.parametrize("count", [2, 3, 17])
def test_slopes_at_the_ends_are_kept(count):
    points, slopes = walk(count), np.array([[0.6, 0.8], [-1, 0]])
    spline = CubicSpline.through(points, slopes)
    require_same(spline, by_scipy(points, slopes))
    length = np.hypot(*np.diff(points, axis=0).T).sum()
    assert_allclose(spline.rates(np.array([0.0, 1.0])) / length, slopes, atol=1e-12)


def test_very_uneven_chords_do_not_spoil_the_solution():
    points = np.column_stack([np.cumsum(10.0 ** -np.array([0, 3, 0, 6, 1, 5, 0, 2])), walk(8)[:, 1]])
    require_same(CubicSpline.through(points), by_scipy(points))


def test_points_that_rounding_makes_one_are_told_with_their_place():
    points = np.array([[0, 0], [1e9, 1.0], [1e9, 1 + 1e-9], [2e9, 5]])
    with pytest.raises(
        GeometryError, match=r"two points of the spline at \(1000000000, 1\) are too near .*: remove one"
    ):
        CubicSpline.through(points)
