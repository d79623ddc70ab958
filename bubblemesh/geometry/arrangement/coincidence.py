"""Curves that run along each other: one of them is to be kept, cut where the other one has corners."""

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.arrangement.crossings import NEWTON_STEPS, Pairs, limited
from bubblemesh.geometry.arrangement.cuts import TOUCHING, Cuts
from bubblemesh.geometry.boundary import Boundary

ENDS = -0.5, 0.5  # of a chord, in its length from the middle


def following(boundary: Boundary, pairs: Pairs, size: float) -> Booleans:
    """Which pairs (m,) are of two curves that have a stretch in common, however each of them is made.

    The middle and an end of the first chord are on the second curve. Curves that only touch part within half a
    chord, or are so much alike that `require_room` refuses them.
    """
    result = np.zeros(len(pairs.p), bool)
    curved = boundary.curved[pairs.p] & boundary.curved[pairs.q] & (pairs.p != pairs.q)
    found = np.flatnonzero(curved)
    found = found[_is_on(boundary, pairs.kept(found), 0.0, size)]
    rest = pairs.kept(found)
    result[found] = _is_on(boundary, rest, ENDS[0], size) | _is_on(boundary, rest, ENDS[1], size)
    return result


def openings(boundary: Boundary, pairs: Pairs) -> Cuts:
    """A cut of both curves for each two closed ones that are the same, given by pairs of their chords."""
    closed = np.flatnonzero(boundary.closed[pairs.p] & boundary.closed[pairs.q])
    first = closed[np.unique(np.column_stack([pairs.p, pairs.q])[closed], axis=0, return_index=True)[1]]
    p, q, a = pairs.p[first], pairs.q[first], pairs.a[first]
    points = boundary.points(p, a)
    b = _foot(boundary, q, pairs.b[first], pairs.step_b[first], points)
    return Cuts(np.concatenate([p, q]), np.concatenate([a, b]), np.tile(points, (2, 1)))


def _is_on(boundary: Boundary, pairs: Pairs, share: float, size: float) -> Booleans:
    """Whether a place on the first chord, given from its middle in its length, is on the second curve."""
    p, q, a, b, step_a, step_b = pairs
    points = boundary.points(p, boundary.wrapped(p, a + share * step_a))
    foot = boundary.points(q, _foot(boundary, q, b, step_b, points))
    return np.hypot(*(points - foot).T) <= TOUCHING * size


def _foot(boundary: Boundary, piece: Integers, s: Floats, step: Floats, points: Floats) -> Floats:
    """Arc lengths (m,) on the pieces of the feet of points (m, 2) next to them."""
    for _ in range(NEWTON_STEPS):
        ahead = np.einsum("ij,ij->i", points - boundary.points(piece, s), boundary.tangents(piece, s))
        s = boundary.wrapped(piece, s + limited(ahead, step))
    return s
