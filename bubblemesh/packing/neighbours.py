"""Neighbours: pairs of bubbles nearer than a multiple of the sum of their radii."""

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, all_of_rows, taken
from bubblemesh.kernels.library import library
from bubblemesh.kernels.pairs import near_pairs
from bubblemesh.records import record

CLASSES_PER_OCTAVE = 2


@record
class Neighbours:
    """Pairs of bubbles, with the positions they were found for."""

    pairs: Integers  # (m, 2): indices i and j of neighbours, each pair once
    contact: Floats  # (m,): distance l0 = r_i + r_j at which a pair is at rest
    x: Floats  # (n, 2): centres when the pairs were found
    d: Floats  # (n,): spacing there

    @classmethod
    def of(cls, x: Floats, d: Floats, reach: float) -> "Neighbours":
        """Pairs nearer than ``reach`` times l0."""
        return cls.along(pairs_within(x, d, reach), x, d)

    @classmethod
    def along(cls, edges: Integers, x: Floats, d: Floats) -> "Neighbours":
        """Pairs at the ends of edges (m, 2)."""
        of_ends = d.take(edges)
        return cls(edges, (of_ends[:, 0] + of_ends[:, 1]) / 2, x, d)

    @property
    def distances(self) -> Floats:
        """Distances (m,) of the pairs when they were found."""
        i, j = self.pairs.T
        return np.hypot(*(taken(self.x, i) - taken(self.x, j)).T)

    def drift(self, x: Floats) -> float:
        """Largest distance of a bubble at x (n, 2) from where it was then, in units of its spacing."""
        return float(np.sqrt(np.max(((x - self.x) ** 2).sum(axis=1) / self.d**2)))


def pairs_within(x: Floats, d: Floats, reach: float) -> Integers:
    """Pairs (m, 2) of points (n, 2) that are nearer than ``reach`` times the mean of their spacings d (n,).

    The first member of each pair has the lower number; the pairs ascend.
    """
    compiled = library()
    return _pairs_by_classes(x, d, reach) if compiled is None else near_pairs(compiled, x, d, reach)


def _pairs_by_classes(x: Floats, d: Floats, reach: float) -> Integers:
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


def next_to(pairs: Integers, marked: Booleans) -> Booleans:
    """Members (n,) of ``pairs`` (m, 2) whose other member is marked (n,)."""
    i, j = pairs.T
    result = np.zeros(len(marked), bool)
    result[j[marked[i]]] = True
    result[i[marked[j]]] = True
    return result


def maximal_independent_set(candidates: Booleans, pairs: Integers, rank: Integers) -> Booleans:
    """Greedy choice (n,) of candidates (n,) no two of which form one of the ``pairs`` (m, 2), lowest rank (n,) first.

    Ranks are distinct. Whoever outranks all neighbours still in play is chosen, and they go; that repeats until all
    are settled, which gives the choice of the sequential algorithm without its loop.
    """
    chosen, alive = np.zeros(len(rank), bool), candidates.copy()
    pairs = taken(pairs, all_of_rows(alive[pairs]))
    while alive.any():
        rival = np.full(len(rank), np.iinfo(np.int64).max)
        i, j = pairs.T
        np.minimum.at(rival, i, rank[j])
        np.minimum.at(rival, j, rank[i])
        won = alive & (rank < rival)
        chosen |= won
        alive &= ~won
        alive[j[won[i]]] = False
        alive[i[won[j]]] = False
        pairs = taken(pairs, alive[i] & alive[j])
    return chosen
