import numpy as np
import pytest
from lattices import uniform

from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.confinement import Confinement, Sliding
from bubblemesh.packing.placement.subdivision import HierarchicalSubdivision

CURVES = {
    "square": rings.rectangle(-1, -1, 1, 1),
    "circle": rings.circle((0.3, -0.2), 1.0),
    "ellipse": rings.ellipse((0, 0), (2, 1), 30),
    "half disc": rings.path((1, 0), [rings.ArcTo((-1, 0), (0, 0), True), rings.LineTo((1, 0))]),
    "spline": rings.path((1, 0), [rings.SplineTo([(0, 1), (-1, 0), (0, -0.7), (1, 0)])]),
}


def bubbles_of(domain, d=0.2):
    return HierarchicalSubdivision()(domain, uniform(d), 10_000)


def jolted(domain, bubbles, steps=30):
    """The sliding and the positions after random steps."""
    rng = np.random.default_rng(0)
    sliding, x = Sliding(domain.boundary, bubbles), bubbles.x.copy()
    for _ in range(steps):
        v = sliding.project(rng.standard_normal(x.shape))
        x, v = sliding.advance(x + 0.05 * v, v)
    return sliding, x, v


@pytest.mark.parametrize("curve", CURVES)
def test_corners_stay(curve):
    domain = Domain.of(CURVES[curve])
    bubbles = bubbles_of(domain)
    _, x, v = jolted(domain, bubbles)
    np.testing.assert_array_equal(x[: bubbles.corners], domain.boundary.corners)
    assert (v[: bubbles.corners] == 0).all()


@pytest.mark.parametrize("curve", CURVES)
def test_sliding_bubbles_stay_on_their_curve(curve):
    domain = Domain.of(CURVES[curve])
    bubbles = bubbles_of(domain)
    sliding, x, v = jolted(domain, bubbles)
    slide = bubbles.sliding
    assert np.abs(domain.signed_distance(x[slide])).max() < 1e-12
    np.testing.assert_allclose(x[slide], domain.boundary.points(bubbles.piece, sliding.s), atol=1e-14)
    assert np.hypot(*(x - bubbles.x)[slide].T).min() > 1e-3
    normal = sliding.tangents @ [[0, 1], [-1, 0]]
    np.testing.assert_allclose((v[slide] * normal).sum(axis=1), 0, atol=1e-14)


def test_circle_keeps_its_radius_under_any_motion():
    domain = Domain.of(CURVES["circle"])
    bubbles = bubbles_of(domain)
    _, x, _ = jolted(domain, bubbles)
    np.testing.assert_allclose(np.hypot(*(x[bubbles.sliding] - [0.3, -0.2]).T), 1, rtol=0, atol=1e-12)


def test_sliding_bubbles_do_not_run_past_a_corner():
    domain = Domain.of(CURVES["square"])
    bubbles = bubbles_of(domain)
    sliding, x = Sliding(domain.boundary, bubbles), bubbles.x.copy()
    x[bubbles.sliding] += 100 * sliding.tangents
    x, _ = sliding.advance(x, np.zeros_like(x))
    np.testing.assert_array_equal(sliding.s, domain.boundary.lengths[bubbles.piece])
    np.testing.assert_array_equal(x[bubbles.sliding], domain.boundary.corners[domain.boundary.end[bubbles.piece]])


def test_force_keeps_what_the_boundary_does_not_take_up():
    domain = Domain.of(CURVES["square"])
    bubbles = bubbles_of(domain)
    sliding = Sliding(domain.boundary, bubbles)
    force = sliding.projecting(lambda x: np.tile([1.0, 2.0], (len(x), 1)))(bubbles.x)
    assert (force[: bubbles.corners] == 0).all()
    on_bottom = np.abs(bubbles.x[bubbles.sliding, 1] + 1) < 1e-12
    on_right = np.abs(bubbles.x[bubbles.sliding, 0] - 1) < 1e-12
    assert (force[bubbles.sliding][on_bottom] == [1, 0]).all()
    assert (force[bubbles.sliding][on_right] == [0, 2]).all()
    assert (force[bubbles.interior] == [1, 2]).all()


@pytest.mark.parametrize("curve", CURVES)
def test_crossing_bubbles_are_put_back_inside_and_at_rest(curve):
    domain = Domain.of(CURVES[curve])
    bubbles = bubbles_of(domain)
    inside = bubbles.x[bubbles.interior]
    d = np.full(len(inside), 0.2)
    confinement = Confinement(domain, inside)
    near = domain.signed_distance(inside) < 0.25
    x, v = inside.copy(), np.ones_like(inside)
    foot = domain.nearest(inside[near]).foot
    x[near] = foot + 0.1 * (foot - inside[near])  # a little beyond the boundary
    confinement.put_back(x, v, d)
    assert near.any()
    distance = domain.signed_distance(x[near])
    assert (distance > 0.05).all()
    assert (distance < 0.06 + 1e-9).all()
    assert (v[near] == 0).all()
    assert (v[~near] == 1).all()
    np.testing.assert_array_equal(x[~near], inside[~near])


def test_bubbles_may_come_near_the_boundary():
    domain = Domain.of(CURVES["circle"])
    x = np.array([[0.3, -0.2]])
    confinement = Confinement(domain, x)
    moved, v = np.array([[1.29, -0.2]]), np.ones((1, 2))
    confinement.put_back(moved, v, np.ones(1))
    assert moved.tolist() == [[1.29, -0.2]]
    assert (v == 1).all()


def test_ended_gives_the_bubbles_where_they_are():
    domain = Domain.of(CURVES["ellipse"])
    bubbles = bubbles_of(domain)
    sliding, x, _ = jolted(domain, bubbles)
    ended = sliding.bubbles_at(x, np.full(len(x), 0.3))
    np.testing.assert_array_equal(ended.x, x)
    np.testing.assert_array_equal(ended.s, sliding.s)
    assert (ended.d == 0.3).all()
