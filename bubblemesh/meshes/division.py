"""Triangles divided among processes: by METIS on the graph of neighbours, or by geometry."""

from importlib.util import find_spec
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers, components

METIS, GEOMETRY = "METIS", "geometry"
IMBALANCE = 30  # thousandths by which the largest part may exceed the mean; of the triangle beyond that, all
SEED = 1  # of METIS's random numbers


class Division(NamedTuple):
    """Part of each triangle (t,), from 0, what divided them, and why it was not METIS if it was not."""

    owner: Integers
    by: str
    reason: str | None = None


def divided(points: Floats, triangles: Integers, neighbours: Integers, count: int) -> Division:
    """Division of triangles (t, 3), of which pairs (m, 2) are neighbours, into ``count`` parts, t at most.

    METIS looks for parts of one piece each with few edges between them, none larger than 1.03 times the mean, rounded
    up. Where it is not installed, or gives no such parts, which happens if they are of few triangles, geometry divides.
    """
    if find_spec("pymetis") is None:
        reason = 'METIS is not installed, whose parts have shorter borders: pip install "bubblemesh[partition]"'
    else:
        owner = by_metis(neighbours, len(triangles), count)
        sizes = np.bincount(owner, minlength=count)
        if sizes.min() > 0 and sizes.max() <= largest_size(len(triangles), count):
            return Division(owner, METIS)
        mean = f"{len(triangles) / count:.3g}"
        reason = f"the parts of METIS have {sizes.min()} to {sizes.max()} triangles, of {mean} on average"
    return Division(by_geometry(points[triangles].mean(axis=1), count), GEOMETRY, reason)


def largest_size(triangles: int, count: int) -> int:
    """Most triangles that one of ``count`` parts may have."""
    return -(-triangles * (1000 + IMBALANCE) // (1000 * count))


def by_metis(neighbours: Integers, triangles: int, count: int) -> Integers:
    """Part (t,) of each triangle by METIS's multilevel k-way partitioning of the graph of neighbours.

    Its parts are of one piece each if the graph is, but for rare ones.

    Karypis and Kumar, A fast and high quality multilevel scheme for partitioning irregular graphs, SIAM J. Sci. Comput.
    20 (1998) 359-392.
    """
    import pymetis

    both = np.concatenate([neighbours, neighbours[:, ::-1]])
    here, there = both[np.lexsort(both.T[::-1])].T
    starts = np.searchsorted(here, np.arange(triangles + 1))
    joined = not components(neighbours, triangles).any()  # METIS ends the program if it should join what is apart
    options = pymetis.Options(ufactor=IMBALANCE, contig=int(joined), seed=SEED)
    graph = pymetis.CSRAdjacency(starts, there)
    return np.array(pymetis.part_graph(count, graph, recursive=False, options=options).vertex_part, np.int64)


def by_geometry(places: Floats, count: int) -> Integers:
    """Part (t,) of each place (t, 2) by recursive inertial bisection; sizes of parts differ by one at most.

    Each half of the parts gets its share of the places in the order along their longest principal axis.

    Simon, Partitioning of unstructured problems for parallel processing, Comput. Syst. Eng. 2 (1991) 135-148.
    """
    owner = np.zeros(len(places), np.int64)
    pending = [(np.arange(len(places)), 0, count)]
    while pending:
        rows, first, parts = pending.pop()
        owner[rows] = first
        if parts > 1:
            x, y = (places[rows] - places[rows].mean(axis=0)).T
            angle = np.arctan2(2 * (x * y).sum(), (x * x).sum() - (y * y).sum()) / 2
            rows = rows[np.argsort(np.cos(angle) * x + np.sin(angle) * y, kind="stable")]
            half = parts // 2
            cut = len(rows) * half // parts
            pending += [(rows[:cut], first, half), (rows[cut:], first + half, parts - half)]
    return owner
