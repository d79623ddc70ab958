"""Distances from curves along their chords: the twin of those in `geometry.distance.bulges`."""

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.kernels.library import Library


def bulge_distances(
    compiled: Library, cubics: Floats, points: Floats, of: Integers, steps: int, flattest: float
) -> Floats:
    """Distances (k,) of points (k, 2) from some (k,) of the ``cubics`` (c, 9), whose columns are those of `Bulges`."""
    found = np.empty(len(points))
    arrays = np.ascontiguousarray(points, np.float64), np.ascontiguousarray(of, np.int64), cubics
    compiled.call("bulge_distances", len(points), *arrays, steps, flattest, found)
    return found
