"""Where curves cross."""

import numpy as np

from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.cuts import CONTACT_LENGTH, TOUCHING, Cuts, between_ends
from bubblemesh.geometry.near_chords import NEWTON_STEPS, PARALLEL, Pairs, limited

__all__ = ["crossings"]


def crossings(boundary: Boundary, pairs: Pairs, size: float) -> Cuts:
    """Cuts where the curves of chords cross."""
    p, q, a, b, step_a, step_b = pairs
    tolerance = TOUCHING * size
    for _ in range(NEWTON_STEPS):
        # Both curves as their tangents: where these meet.
        (ux, uy), (vx, vy) = boundary.tangents(p, a).T, boundary.tangents(q, b).T
        gx, gy = (boundary.points(q, b) - boundary.points(p, a)).T
        across = ux * vy - uy * vx
        slope = np.where(across == 0, np.inf, across)
        ahead = limited((gx * vy - gy * vx) / slope, step_a)
        a = boundary.wrapped(p, a + ahead)
        b = boundary.wrapped(q, b + limited((gx * uy - gy * ux) / slope, step_b))
    points = boundary.points(p, a)
    met = (np.hypot(*(points - boundary.points(q, b)).T) <= tolerance) & (np.abs(across) > PARALLEL)
    met &= np.abs(ahead) <= tolerance  # where curves touch, the steps halve only
    met &= between_ends(boundary, p, a, tolerance) & between_ends(boundary, q, b, tolerance)
    met &= (p != q) | (np.abs(a - b) > CONTACT_LENGTH * tolerance)
    return Cuts(np.concatenate([p[met], q[met]]), np.concatenate([a[met], b[met]]), np.tile(points[met], (2, 1)))
