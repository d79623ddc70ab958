"""Splines that follow parametric curves."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from bubblemesh.geometry.cubic_splines import CubicSpline
from bubblemesh.readers import sampling
from bubblemesh.readers.sampling import splines


def bezier(*points):
    p = np.array(points, float)

    def curve(t):
        t = t[:, None]
        return (1 - t) ** 3 * p[0] + 3 * t * (1 - t) ** 2 * p[1] + 3 * t**2 * (1 - t) * p[2] + t**3 * p[3]

    return curve


WIDE = bezier((0, 0), (1, 2), (3, 2), (4, 0))
SHARP = bezier((0, 0), (4, 1), (-3, 1), (1, 0))
LOOP = bezier((0, 0), (6, 4), (-5, 4), (0, 0))  # ends in a corner at its own start


def departure(curve, points):
    """Distance of the curve from the spline, at many places of each."""
    on_spline = CubicSpline.through(points).points(np.linspace(0, 1, 20_001))
    on_curve = curve(np.linspace(0, 1, 301))
    return np.min(np.hypot(*(on_curve[:, None] - on_spline).transpose(2, 0, 1)), axis=1).max()


@pytest.mark.parametrize("curve", [WIDE, SHARP], ids=["wide", "sharp"])
def test_spline_follows_the_curve_to_a_millionth_of_its_extent_and_more_points_are_not_taken(curve):
    ((points,),) = splines([curve])
    extent = np.ptp(points, axis=0).max()
    assert departure(curve, points) < 1e-4 * extent  # as far apart as the places on the spline
    assert_allclose(points[[0, -1]], curve(np.array([0.0, 1.0])))
    assert len(points) in {8 * 2**k + 1 for k in range(10)}


def test_curves_together_have_the_points_that_each_has_alone(monkeypatch):
    curves = [WIDE, SHARP, LOOP, bezier((5, 5), (6, 5), (7, 5), (8, 5))] * 3
    alone = [splines([curve])[0] for curve in curves]
    for most in (1, 3000, 10**6):
        monkeypatch.setattr(sampling, "MOST_TOGETHER", most)
        together = splines(curves)
        assert [len(parts) for parts in together] == [1, 1, 2, 1] * 3
        for one, other in zip(alone, together, strict=True):
            for a, b in zip(one, other, strict=True):
                np.testing.assert_array_equal(a, b)


def test_a_curve_of_no_length_is_as_few_points_as_there_are_and_no_curves_are_none():
    ((points,),) = splines([lambda t: np.zeros((len(t), 2))])
    assert points.shape == (9, 2)
    assert splines([]) == []
