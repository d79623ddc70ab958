from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.interpolate import CubicSpline
from scipy.special import ellipe

from bubblemesh.geometry import cubic_splines
from bubblemesh.geometry.beziers import Beziers
from bubblemesh.geometry.curves import Arcs, Ellipses, Lines, Splines, turning

OPEN_KNOTS = np.array([[0, 0], [1, 2], [3, 1], [4, 4], [6, 3.5]])

CLOSED_KNOTS = np.array([[1, 0], [0, 1.2], [-1, 0.1], [0, -1], [1, 0]])


def splines(*knots):
    return Splines([cubic_splines.CubicSpline.through(points) for points in knots])


FAMILIES = {
    "lines": Lines(np.array([[0, 0], [1, 1.0]]), np.array([[3, 4], [1, -2.0]])),
    "arcs": Arcs(np.array([[1, 2], [-3, 0.5]]), np.array([2, 0.3]), np.array([0.4, -1]), np.array([1.3, -5])),
    "ellipses": Ellipses(
        np.array([[0, 0], [5, -1.0]]), np.array([[2, 1], [0.5, 3]]), np.array([0.3, -1]), np.array([1.0, -1])
    ),
    "beziers": Beziers(*np.array([[[0, 0], [2, 3]], [[0, 2], [3, 5]], [[3, 2], [4, 1]], [[4, 0], [6, 2.0]]])),
    "splines": splines(OPEN_KNOTS, CLOSED_KNOTS),
}
every_family = pytest.mark.parametrize("family", FAMILIES.values(), ids=FAMILIES)


def sampled(family, k, count=999):
    s = np.linspace(0, family.lengths[k], count)
    return np.full(count, k), s


def ellipse(a, b):
    return Ellipses(np.zeros((1, 2)), np.array([[a, b]], float), np.zeros(1), np.ones(1))


def test_line_divides_its_chord_evenly():
    line = FAMILIES["lines"]
    assert_allclose(line.lengths, [5, 3])
    assert_allclose(line.points(np.array([0, 1]), np.array([2.5, 1.0])), [[1.5, 2], [1, 0]])


def test_points_of_arcs_lie_on_the_circle_at_the_right_angle():
    arcs = FAMILIES["arcs"]
    for k in range(2):
        index, s = sampled(arcs, k)
        x, y = (arcs.points(index, s) - arcs.center[k]).T
        assert_allclose(np.hypot(x, y), arcs.radius[k], rtol=1e-12)
        assert_allclose(np.unwrap(np.arctan2(y, x)), arcs.angle[k] + np.sign(arcs.sweep[k]) * s / arcs.radius[k])


def test_points_of_ellipses_satisfy_the_equation():
    family = FAMILIES["ellipses"]
    for k in range(2):
        x, y = (family.points(*sampled(family, k)) - family.center[k]).T
        c, s = np.cos(family.angle[k]), np.sin(family.angle[k])
        a, b = family.radii[k]
        assert_allclose(((c * x + s * y) / a) ** 2 + ((c * y - s * x) / b) ** 2, 1, rtol=1e-12)


@pytest.mark.parametrize("aspect", [1, 1.5, 10, 100, 1000])
def test_ellipse_has_the_length_of_the_elliptic_integral(aspect):
    assert_allclose(ellipse(1, 1 / aspect).lengths, 4 * ellipe(1 - aspect**-2), rtol=1e-12)


@pytest.mark.parametrize("aspect", [1, 1.5, 10, 60])
def test_arc_length_along_an_ellipse_is_that_of_quadrature(aspect):
    family = ellipse(1, 1 / aspect)
    s = family.lengths[0] * np.array([0.02, 0.1, 0.2])
    x, y = family.points(np.zeros(3, int), s).T
    for end, length in zip(np.arctan2(y * aspect, x), s, strict=True):
        assert quad(lambda a: np.hypot(np.sin(a), np.cos(a) / aspect), 0, end)[0] == pytest.approx(length, rel=1e-5)


@pytest.mark.parametrize("aspect", [100, 1000, 1e6])
def test_points_of_a_flat_ellipse_keep_their_order(aspect):
    family = ellipse(1, 1 / aspect)
    x, y = family.points(*sampled(family, 0, 20001)).T
    angle = np.unwrap(np.arctan2(y * aspect, x))
    assert (np.diff(angle) > 0).all()
    assert angle[-1] - angle[0] == pytest.approx(2 * np.pi)


@pytest.mark.parametrize(("k", "ends"), [(0, "not-a-knot"), (1, "periodic")])
def test_spline_is_that_of_scipy_by_arc_length(k, ends):
    family = FAMILIES["splines"]
    knots = (OPEN_KNOTS, CLOSED_KNOTS)[k]
    u = np.append(0, np.cumsum(np.hypot(*np.diff(knots, axis=0).T)))
    spline = CubicSpline(u, knots, bc_type=ends)
    lengths = [quad(lambda t: np.hypot(*spline(t, 1)), *panel, epsabs=1e-13)[0] for panel in pairwise(u)]
    assert family.lengths[k] == pytest.approx(sum(lengths), rel=1e-10)
    at_knots = np.append(0, np.cumsum(lengths))
    assert_allclose(family.points(np.full(len(u), k), at_knots), knots, atol=1e-9)
    middle = (u[1] + u[2]) / 2
    s = at_knots[1] + quad(lambda t: np.hypot(*spline(t, 1)), u[1], middle)[0]
    assert_allclose(family.points(np.array([k]), np.array([s]))[0], spline(middle), atol=1e-6)


def test_spline_with_many_uneven_knots_has_the_length_of_its_chords():
    t = np.sort(np.random.default_rng(1).random(300)) * 2 * np.pi
    family = splines(np.column_stack([np.cos(t), np.sin(t)]))
    assert family.lengths[0] == pytest.approx(t[-1] - t[0], rel=1e-5)
    points = family.points(*sampled(family, 0, 10001))
    assert_allclose(np.hypot(*np.diff(points, axis=0).T), family.lengths[0] / 10000, rtol=1e-4)


def test_closed_spline_is_smooth_at_its_seam():
    family = splines(CLOSED_KNOTS)
    first, last = family.tangents(np.zeros(2, int), np.array([0, family.lengths[0]]))
    assert_allclose(first, last, atol=1e-12)


@every_family
def test_curves_are_run_at_unit_speed(family):
    for k in range(2):
        index, s = sampled(family, k, 20001)
        chords = np.hypot(*np.diff(family.points(index, s), axis=0).T)
        assert_allclose(chords, np.diff(s), rtol=2e-5)


@every_family
def test_tangents_are_unit_vectors_and_central_differences_tend_to_them_with_order_two(family):
    steps = family.lengths.min() * 0.004 / 2 ** np.arange(4)
    errors = []
    for h in steps:
        error = 0
        for k in range(2):
            index, s = sampled(family, k, 101)
            s = s[10:-10]
            index = index[10:-10]
            tangents = family.tangents(index, s)
            assert_allclose(np.hypot(*tangents.T), 1, rtol=1e-14)
            difference = (family.points(index, s + h) - family.points(index, s - h)) / (2 * h)
            error = max(error, np.abs(difference - tangents).max())
        errors.append(error)
    if isinstance(family, Lines):
        assert max(errors) < 1e-12
    else:
        order = np.polyfit(np.log(steps), np.log(errors), 1)[0]
        assert order == pytest.approx(2, abs=0.3)


@every_family
def test_many_curves_are_evaluated_as_one_by_one(family):
    rng = np.random.default_rng(0)
    index = rng.integers(0, 2, 50)
    s = rng.random(50) * family.lengths[index]
    one_by_one = [family.points(index[k : k + 1], s[k : k + 1])[0] for k in range(50)]
    assert_allclose(family.points(index, s), one_by_one, rtol=1e-14)


@every_family
def test_places_are_points_and_tangents(family):
    index, s = sampled(family, 1, 50)
    points, tangents = family.places(index, s)
    np.testing.assert_array_equal(points, family.points(index, s))
    np.testing.assert_array_equal(tangents, family.tangents(index, s))


@every_family
def test_chords_follow_the_curves(family):
    for k in range(2):
        curve, stations = family.stations()
        s = np.append(stations[curve == k], family.lengths[k])
        index = np.full(len(s), k)
        ends = family.points(index, s)
        middles = family.points(index[1:], (s[1:] + s[:-1]) / 2)
        away = np.hypot(*(middles - (ends[1:] + ends[:-1]) / 2).T)
        turned = np.abs(turning(family.tangents(index[1:], s[:-1]), family.tangents(index[1:], s[1:])))
        assert away.max() < 1e-3 * family.lengths[k]
        assert turned.max() < 2 * np.pi / 250 or family.exact


@pytest.mark.parametrize("aspect", [1, 50, 1000])
def test_flat_ellipses_need_no_more_chords_than_round_ones(aspect):
    assert len(ellipse(1, 1 / aspect).stations()[0]) < 400


def test_turning_is_signed_and_may_exceed_a_right_angle():
    angles = np.array([0.1, -0.1, 3, -3])
    before = np.tile([0.6, 0.8], (4, 1))
    c, s = np.cos(angles), np.sin(angles)
    after = np.column_stack([0.6 * c - 0.8 * s, 0.6 * s + 0.8 * c])
    assert_allclose(turning(before, after), angles)
