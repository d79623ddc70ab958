"""Where curves touch with a common tangent, and which ones pass next to each other."""

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.curves import turning
from bubblemesh.geometry.cuts import CONTACT_LENGTH, NEARLY, TOUCHING, Cuts, between_ends
from bubblemesh.geometry.near_chords import NEWTON_STEPS, Pairs, limited
from bubblemesh.wording import place

__all__ = ["touches"]

SAME_BEND = 1e-3  # relative difference of two curvatures, below which curves run beside each other
BESIDE = 2e-5  # radians between them; they turn by 0.025 along a chord, of which they may differ by that 1e-3


def touches(boundary: Boundary, pairs: Pairs, size: float) -> Cuts:
    """Cuts where the curves of chords touch with a common tangent.

    Raises
    ------
    GeometryError
        If one passes the other next to it.
    """
    tolerance = TOUCHING * size
    curved = (boundary.curved[pairs.p] | boundary.curved[pairs.q]) & (pairs.p != pairs.q)
    p, q, a, b, step_a, step_b = (column[curved] for column in pairs)
    bends = np.column_stack([_bend(boundary, p, a, step_a), _bend(boundary, q, b, step_b)])
    for _ in range(NEWTON_STEPS):
        # Where the tangents are parallel, and each point is opposite of the other.
        ahead = np.einsum("ij,ij->i", boundary.points(p, a) - boundary.points(q, b), boundary.tangents(q, b))
        b = boundary.wrapped(q, b + ahead)
        t, v = boundary.tangents(p, a), boundary.tangents(q, b)
        sense = np.where(np.einsum("ij,ij->i", t, v) < 0, -1.0, 1.0)
        angle, bend = turning(t, sense[:, None] * v), bends[:, 0] - sense * bends[:, 1]
        alike = np.abs(bend) <= SAME_BEND * np.abs(bends).max(axis=1, initial=0)
        off = np.where(alike, 0, angle / np.where(alike, 1, bend))
        a = boundary.wrapped(p, a + limited(off, step_a))
    offset, v = boundary.points(p, a) - boundary.points(q, b), boundary.tangents(q, b)
    distance = np.hypot(*offset.T)
    opposite = (np.abs(np.einsum("ij,ij->i", offset, v)) <= tolerance) & (np.abs(off) <= tolerance)
    opposite &= ~alike | (np.abs(angle) <= BESIDE)
    around = CONTACT_LENGTH * tolerance
    opposite &= between_ends(boundary, p, a, around) & between_ends(boundary, q, b, around)
    near = np.flatnonzero(opposite & (alike | (distance > tolerance)) & (distance <= NEARLY * size))
    if len(near):
        k = near[0]
        raise GeometryError(
            f"two curves pass each other at {place(boundary.points(p[[k]], a[[k]])[0])} at a distance of "
            f"{distance[k]:.1g}, next to each other but not the same and not touching in a point: let them touch, "
            "or move them apart"
        )
    k = np.flatnonzero(opposite & (distance <= tolerance) & ~alike)
    points = boundary.points(p[k], a[k])
    return Cuts(np.concatenate([p[k], q[k]]), np.concatenate([a[k], b[k]]), np.tile(points, (2, 1)))


def _bend(boundary: Boundary, piece: Integers, middle: Floats, step: Floats) -> Floats:
    """Mean curvature (m,) along chords."""
    before, after = (boundary.tangents(piece, boundary.wrapped(piece, middle + t * step)) for t in (-0.5, 0.5))
    return np.where(boundary.curved[piece], turning(before, after) / step, 0)
