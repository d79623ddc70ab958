"""Cells divided among processes: by METIS on the graph of neighbours, or by geometry."""

from importlib.util import find_spec
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers, components

METIS, GEOMETRY = "METIS", "geometry"
IMBALANCE = 30  # thousandths by which the largest part may exceed the mean, rounded up to a whole triangle
SEED = 1  # of METIS's random numbers


class Division(NamedTuple):
    """Part of each cell (c,), from 0; what divided them, and the reason if that was not METIS."""

    owner: Integers
    by: str
    reason: str | None = None


def divided(places: Floats, neighbours: Integers, weights: Integers, count: int) -> Division:
    """Division of cells at places (c, 2), of which pairs (m, 2) are neighbours, into ``count`` parts, c at most.

    The weight (c,) of a cell is the number of its triangles. METIS looks for parts in one piece each, with few edges
    between them, none larger than 1.03 times the mean, rounded up. If it is not installed, or finds no such parts, as
    may happen if they have few triangles, the cells are divided by geometry.
    """
    if find_spec("pymetis") is None:
        reason = 'METIS is not installed, whose parts have shorter borders: pip install "bubblemesh[partition]"'
    else:
        owner, total = by_metis(neighbours, weights, count), int(weights.sum())
        sizes = np.bincount(np.repeat(owner, weights), minlength=count)
        if sizes.min() > 0 and sizes.max() < largest_size(total, count) + weights.max():
            return Division(owner, METIS)
        mean = f"{total / count:.3g}"
        reason = f"the parts of METIS have {sizes.min()} to {sizes.max()} triangles, of {mean} on average"
    return Division(by_geometry(places, weights, count), GEOMETRY, reason)


def largest_size(triangles: int, count: int) -> int:
    """Most triangles that one of ``count`` parts may have."""
    return -(-triangles * (1000 + IMBALANCE) // (1000 * count))


def by_metis(neighbours: Integers, weights: Integers, count: int) -> Integers:
    """Part (c,) of each cell, with weights (c,), by METIS's multilevel k-way partitioning of the graph of neighbours.

    The parts are in one piece each if the graph is, with rare exceptions.

    Karypis and Kumar, A fast and high quality multilevel scheme for partitioning irregular graphs, SIAM J. Sci. Comput.
    20 (1998) 359-392.
    """
    import pymetis

    both = np.concatenate([neighbours, neighbours[:, ::-1]])
    here, there = both[np.lexsort(both.T[::-1])].T
    starts = np.searchsorted(here, np.arange(len(weights) + 1))
    joined = not components(neighbours, len(weights)).any()  # if not, METIS would end the program
    options = pymetis.Options(ufactor=IMBALANCE, contig=int(joined), seed=SEED)
    graph = pymetis.CSRAdjacency(starts, there)
    found = pymetis.part_graph(count, graph, vweights=weights, recursive=False, options=options)
    return np.array(found.vertex_part, np.int64)


def by_geometry(places: Floats, weights: Integers, count: int) -> Integers:
    """Part (c,) of each place (c, 2) by recursive inertial bisection; with weights of 1 sizes of parts differ by 1.

    Each half of the parts gets its share of the weights (c,) in the order along their longest principal axis.

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
            upto = np.cumsum(weights[rows])
            cut = int(np.searchsorted(upto, upto[-1] * half // parts, side="right"))
            cut = min(max(cut, half), len(rows) - (parts - half))  # each part needs a place
            pending += [(rows[:cut], first, half), (rows[cut:], first + half, parts - half)]
    return owner
