"""Neighbours: pairs of bubbles nearer than a multiple of the sum of their radii."""

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, all_of_rows, taken
from bubblemesh.kernels.pairs import pairs_within
from bubblemesh.records import record


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
