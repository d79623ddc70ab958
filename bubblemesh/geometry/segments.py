"""Segments that meet, decided by exact arithmetic only where rounding could decide."""

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats

# Of the sum of its terms: a larger determinant has the sign of the exact one.
ROUNDING = (3 + 16 * 2.0**-53) * 2.0**-53


def segments_meet(first: Floats, second: Floats) -> Booleans:
    """Whether each of the segments ``first`` (m, 2, 2) has a point in common with the ``second`` (m, 2, 2) beside it.

    References
    ----------
    J. R. Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric predicates", Discrete &
    Computational Geometry 18 (1997), for the bound of the rounding.
    """
    start, end = _sides(first, second[:, 0]), _sides(first, second[:, 1])
    begin, last = _sides(second, first[:, 0]), _sides(second, first[:, 1])
    apart = (start * end > 0) | (begin * last > 0)
    met: Booleans = (start * end < 0) & (begin * last < 0)
    unsure = np.flatnonzero(~(apart | met))
    met[unsure] = shapely.intersects(shapely.linestrings(first[unsure]), shapely.linestrings(second[unsure]))
    return met


def _sides(segments: Floats, points: Floats) -> Floats:
    """On which side of segments (m, 2, 2) points (m, 2) lie: 1 left, -1 right, 0 where rounding could decide."""
    (ax, ay), (bx, by) = (segments[:, 0] - points).T, (segments[:, 1] - points).T
    left, right = ax * by, ay * bx
    turn = left - right
    return np.where(np.abs(turn) > ROUNDING * (np.abs(left) + np.abs(right)), np.sign(turn), 0.0)
