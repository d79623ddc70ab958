"""Cubic Bézier curves by arc length."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import quad
from scipy.optimize import brentq

from bubblemesh.geometry.beziers import Beziers
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.paths import Bezier
from bubblemesh.geometry.rings import BezierTo, SplineTo, path
from bubblemesh.geometry.similarity import Similarity
from bubblemesh.readers.sampling import splines

ARCH = ((0.0, 0.0), (0.0, 2.0), (3.0, 2.0), (4.0, 0.0))
WAVE = ((1.0, 1.0), (3.0, 4.0), (2.0, -1.0), (5.0, 2.0))
DROP = ((0.0, 0.0), (3.0, 4.0), (-3.0, 4.0), (0.0, 0.0))  # ends in a corner at its own start
TIGHT = ((0.0, 0.0), (2.0, 2.0), (1.0, 2.0), (3.0, 0.0))
NARROW = ((0.0, 0.0), (1.0, 0.02), (2.0, -0.02), (3.0, 0.0))


def family(*curves):
    return Beziers(*np.array(curves, float).swapaxes(0, 1))


def at(curve, u):
    """Point of a curve by de Casteljau's construction."""
    points = np.array(curve, float)
    while len(points) > 1:
        points = (1 - u) * points[:-1] + u * points[1:]
    return points[0]


def length_to(curve, u):
    steps = np.diff(curve, axis=0)
    return quad(lambda t: 3 * np.hypot(*at(steps, t)), 0, u, epsabs=1e-13)[0]


def area(curves):
    """Area that curves enclose one after the other, to rounding: Gauss's rule is exact for these polynomials."""
    nodes, weights = np.polynomial.legendre.leggauss(3)
    total = 0
    for curve in curves:
        for u, weight in zip((nodes + 1) / 2, weights / 2, strict=True):
            (x, y), (dx, dy) = at(curve, u), 3 * at(np.diff(curve, axis=0), u)
            total += weight * (x * dy - y * dx) / 2
    return abs(total)


@pytest.mark.parametrize("curve", [ARCH, WAVE, DROP, NARROW, TIGHT], ids=["arch", "wave", "drop", "narrow", "tight"])
def test_points_by_arc_length_are_those_of_the_curve(curve):
    curves = family(curve)
    assert curves.regular.all()
    whole = length_to(curve, 1)
    assert_allclose(curves.lengths, whole, rtol=1e-9)
    for s in whole * np.array([0.1, 0.37, 0.5, 0.81]):
        u = brentq(lambda t, s=s: length_to(curve, t) - s, 0, 1, xtol=1e-13)
        assert_allclose(curves.points(np.zeros(1, int), np.array([s]))[0], at(curve, u), atol=1e-5 * whole)
    assert_allclose(curves.points(np.zeros(2, int), np.append(0, curves.lengths)), [curve[0], curve[-1]], atol=1e-14)


@pytest.mark.parametrize(
    "curve",
    [
        ((0, 0), (0, 0), (1, 1), (2, 0)),
        ((0, 0), (1, 1), (2, 0), (2, 0)),
        ((0, 0), (4, 4), (-1, 4), (3, 0)),
        ((0, 0), (3, 0), (-1, 0), (2, 0)),
        ((1, 1), (1, 1), (1, 1), (1, 1)),
    ],
    ids=["no first handle", "no second handle", "cusp", "there and back", "point"],
)
def test_curves_that_stop_are_not_regular(curve):
    assert_array_equal(family(ARCH, curve, WAVE).regular, [True, False, True])


def test_many_curves_have_the_chords_that_each_has_alone():
    several = [ARCH, WAVE, DROP, TIGHT, NARROW]
    curve, s = family(*several).stations()
    for k, one in enumerate(several):
        assert_allclose(s[curve == k], family(one).stations()[1], rtol=0, atol=1e-12)


def test_a_curve_keeps_its_course_run_backwards_and_moved():
    curve, by = Bezier(*ARCH), Similarity.of(mirror="x", scale=2, rotate=30, move=(5, 1))
    (whole,) = family(curve).lengths
    s = np.linspace(0, whole, 9)
    points = family(curve).points(np.zeros(9, int), s)
    assert_allclose(family(curve.reversed()).points(np.zeros(9, int), s[::-1]), points, atol=1e-5)
    assert_allclose(family(curve.moved(by)).points(np.zeros(9, int), 2 * s), by.points(points), atol=1e-9)


@pytest.mark.parametrize(
    "curve", [ARCH, TIGHT, ((0, 0), (0, 0.5523), (0.4477, 1), (1, 1))], ids=["arch", "tight", "round"]
)
def test_a_ring_encloses_the_area_of_its_curves_as_nearly_as_one_of_splines(curve):
    (knots,) = splines([lambda t: np.array([at(curve, u) for u in t])])[0]
    start, first, second, end = curve
    expected = area([curve, np.linspace(curve[-1], curve[0], 4)])
    exact, spline = (
        abs(Domain.of(path(start, [piece])).polygon.area / expected - 1)
        for piece in (BezierTo(end, first, second), SplineTo(knots[1:].tolist()))
    )
    assert exact < 1e-4
    assert exact < 1.05 * spline


def test_a_curve_that_ends_at_its_own_start_is_a_ring():
    start, first, second, end = DROP
    assert Domain.of(path(start, [BezierTo(end, first, second)])).polygon.area == pytest.approx(area([DROP]), rel=2e-4)
