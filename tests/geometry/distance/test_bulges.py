"""Distances from curves by cubics along their chords, against those from the nearest points on the true curves."""

import numpy as np
import pytest

from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.rings import ArcTo, BezierTo, LineTo, SplineTo, circle, ellipse, path

RANDOM = np.random.default_rng(3)
SHAPES = {
    "circle": (circle((1, 2), 1.0), 1.0),
    "small circle": (circle((1, 2), 1e-3), 1e-3),
    "flat ellipse": (ellipse((0, 0), (1, 0.1), 20), 10.0),  # the radius of its flat sides
    "arc and chord": (path((1, 0), [ArcTo((-1, 0), (0, 0), True), LineTo((1, 0))]), 1.0),
    # Its third derivative jumps at the points, which are within chords.
    "spline": (path((1, 0), [SplineTo([(0.5, 0.6), (0, 0.8), (-0.9, 0.3), (-0.7, -0.5), (0.2, -0.9), (1, 0)])]), 20.0),
    "bezier": (path((0, 0), [BezierTo((2, 0), (0.2, 1.2), (1.5, 1.4)), LineTo((0, 0))]), 1.0),
}


def places_about(domain):
    """Points near the boundary, around the domain, and far away."""
    x0, y0, x1, y1 = domain.bounds
    boundary, size = domain.boundary, domain.size
    piece = RANDOM.integers(0, len(boundary.kind), 2000)
    on = boundary.points(piece, RANDOM.uniform(0, 1, 2000) * boundary.lengths[piece])
    near = on + 1e-3 * size * RANDOM.normal(size=on.shape)
    around = RANDOM.uniform((x0 - size, y0 - size), (x1 + size, y1 + size), (4000, 2))
    return np.vstack([on, near, around, around * 50, [[(x0 + x1) / 2, (y0 + y1) / 2]]])


@pytest.mark.parametrize(("ring", "radius"), SHAPES.values(), ids=SHAPES)
def test_distances_are_those_of_the_nearest_points_on_the_curves(ring, radius):
    domain = Domain.of(ring)
    points = places_about(domain)
    nearest = domain.nearest(points)
    far = np.finfo(float).eps * np.abs(points).max()
    np.testing.assert_allclose(domain.distances(points), nearest.distance, atol=1e-7 * radius + 10 * far, rtol=1e-12)


def test_straight_sides_have_exactly_the_distances_of_their_nearest_points():
    domain = Domain.of(path((0, 0), [LineTo((3, 1)), LineTo((2, 2.5)), LineTo((0, 0))]))
    points = places_about(domain)
    np.testing.assert_array_equal(domain.distances(points), domain.nearest(points).distance)


@pytest.mark.parametrize(("ring", "radius"), SHAPES.values(), ids=SHAPES)
def test_feet_are_the_nearest_points_with_the_tangents_there(ring, radius):
    domain = Domain.of(ring)
    points = places_about(domain)[:6000]
    points = points[domain.distances(points) < 0.05 * radius]  # farther away two feet may be as near
    foot, tangent = domain.feet(points, *domain.labels)
    nearest = domain.nearest(points)
    np.testing.assert_allclose(foot, nearest.foot, atol=1e-5 * radius)
    np.testing.assert_allclose(np.hypot(*tangent.T), 1)
    along = domain.boundary.tangents(nearest.piece, nearest.s)
    inside = (nearest.s > 0) & (nearest.s < domain.boundary.lengths[nearest.piece])
    np.testing.assert_allclose(tangent[inside], along[inside], atol=1e-3)
