"""Pairs of near points: the twin of the search in `packing.neighbours`."""

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.kernels.library import Library

USUAL = 12  # pairs of each point for which room is made at first


def near_pairs(compiled: Library, x: Floats, d: Floats, reach: float) -> Integers:
    """Sorted pairs (m, 2) of points x (n, 2) that are nearer than ``reach`` times the mean of their spacings d (n,)."""
    count, room = np.zeros(1, np.int64), USUAL * len(x)
    places, spacings = np.ascontiguousarray(x, np.float64), np.ascontiguousarray(d, np.float64)
    while True:
        pairs = np.empty((room, 2), np.int64)
        compiled.call(
            "pairs_within", n=len(x), x=places, d=spacings, reach=float(reach), room=room, ordered=pairs, count=count
        )
        if count[0] <= room:
            return pairs[: count[0]].copy()
        room = int(count[0])
