"""Segments that meet, decided by exact arithmetic only where rounding could decide."""

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats
from bubblemesh.kernels.predicates import turns


def segments_meet(first: Floats, second: Floats) -> Booleans:
    """Whether each of the segments ``first`` (m, 2, 2) meets the ``second`` (m, 2, 2) beside it, be it in one point."""
    (a, b), (c, d) = first.swapaxes(0, 1), second.swapaxes(0, 1)
    start, end, begin, last = turns(a, b, c), turns(a, b, d), turns(c, d, a), turns(c, d, b)
    apart = (start * end > 0) | (begin * last > 0)
    met: Booleans = (start * end < 0) & (begin * last < 0)
    unsure = np.flatnonzero(~(apart | met))
    met[unsure] = shapely.intersects(shapely.linestrings(first[unsure]), shapely.linestrings(second[unsure]))
    return met
