"""Distances from curves along their chords: the twin of those in `geometry.distance.bulges`."""

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.kernels.library import call


def bulge_distances(cubics: Floats, points: Floats, of: Integers, steps: int, flattest: float) -> Floats:
    """Distances (k,) of points (k, 2) from some (k,) of the ``cubics`` (c, 9), whose columns are those of `Bulges`."""
    found = np.empty(len(points))
    call(
        "bulge_distances",
        n=len(points),
        places=np.ascontiguousarray(points, np.float64),
        of=np.ascontiguousarray(of, np.int64),
        cubics=cubics,
        steps=steps,
        flattest=flattest,
        distance=found,
    )
    return found
