"""Pairs of near points."""

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.kernels.library import call, or_numpy

CLASSES_PER_OCTAVE = 2  # of points, by their spacing
USUAL = 12  # pairs of each point for which room is made at first


def pairs_within_in_numpy(x: Floats, d: Floats, reach: float) -> Integers:
    """The pairs of `pairs_within`, by searches in NumPy and SciPy.

    Points are sorted into classes of like spacing; each class searches itself and every finer one, so that the work
    stays proportional to the pairs however much d varies.
    """
    from scipy.spatial import cKDTree  # takes longer to load than to mesh a small case without it

    if len(x) == 0:
        return np.empty((0, 2), np.int64)
    octave = np.floor(CLASSES_PER_OCTAVE * np.log2(d / d.min())).astype(int)
    order = np.argsort(octave, kind="stable")
    classes = np.split(order, np.flatnonzero(np.diff(octave[order])) + 1)
    coarsest = [float(d[some].max()) for some in classes]
    found = []
    for number, mine in enumerate(classes):
        tree = cKDTree(x[mine])
        found.append(mine[tree.query_pairs(reach * coarsest[number], output_type="ndarray")])
        for finer, largest in zip(classes[:number], coarsest, strict=False):
            # Around a fine spot lie bubbles of all sizes: a radius for each size keeps far ones out.
            radius = reach * (coarsest[number] + largest) / 2
            others = _within(finer, x, x[mine], radius)
            if len(others):
                near = tree.sparse_distance_matrix(cKDTree(x[others]), radius, output_type="ndarray")
                found.append(np.column_stack([mine[near["i"]], others[near["j"]]]))
    pairs = np.concatenate(found).astype(np.int64)
    i, j = pairs.T
    squared = np.square(x[i] - x[j]).sum(axis=1)
    pairs = pairs[squared < np.square(reach * (d[i] + d[j]) / 2)]
    pairs.sort(axis=1)
    return pairs[np.lexsort(pairs.T[::-1])]


def _within(candidates: Integers, x: Floats, around: Floats, margin: float) -> Integers:
    """Candidates (k,) that lie in the bounding box of other points (m, 2), widened by a margin."""
    low, high = around.min(axis=0) - margin, around.max(axis=0) + margin
    return candidates[((x[candidates] >= low) & (x[candidates] <= high)).all(axis=1)]


@or_numpy(pairs_within_in_numpy)
def pairs_within(x: Floats, d: Floats, reach: float) -> Integers:
    """Pairs (m, 2) of points (n, 2) that are nearer than ``reach`` times the mean of their spacings d (n,).

    The first member of each pair has the lower number; the pairs ascend.
    """
    count, room = np.zeros(1, np.int64), USUAL * len(x)
    places, spacings = np.ascontiguousarray(x, np.float64), np.ascontiguousarray(d, np.float64)
    while True:
        pairs = np.empty((room, 2), np.int64)
        call("pairs_within", n=len(x), x=places, d=spacings, reach=float(reach), room=room, ordered=pairs, count=count)
        if count[0] <= room:
            return pairs[: count[0]].copy()
        room = int(count[0])
