"""Merging of nodes that are in a file several times, once for each cell."""

from collections.abc import Sequence

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import CaseError, FileError

ROUNDING = 64  # last digits of a coordinate by which copies of a node may differ
AGREEING = 1e-6  # of the largest value: smaller differences between copies of a node are ignored
MOST_COPIES = 1000  # of a node, on average
MOST_VALUES = 16  # different values of the copies of a node that are kept apart
JUMPS = 0.5  # share of nodes with several values from which on a solution counts as not continuous


def are_apart(cells: Sequence[Integers]) -> bool:
    """Whether each cell, given by blocks (m, k) of nodes, has nodes of its own, so that no two cells are connected."""
    nodes = np.concatenate([block.ravel() for block in cells])
    return sum(map(len, cells)) > 1 and len(np.unique(nodes)) == nodes.size


def places(points: Floats, digits: float) -> Integers:
    """Number of the place (n,) of each point (n, 2), from 0; ``digits`` is the rounding error of a number near 1.

    FileError if very many points are in one place.
    """
    distinct, number = np.unique(points, axis=0, return_inverse=True)
    number = number.ravel()
    near = ROUNDING * digits * np.abs(points).max(initial=0)
    if near == 0 or len(distinct) < 2:
        return number
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    tree = cKDTree(distinct)
    if tree.count_neighbors(tree, near) > MOST_COPIES * len(distinct):
        raise FileError("very many nodes are in one place: the file is damaged")
    i, j = tree.query_pairs(near, output_type="ndarray").T
    pairs = coo_array((np.ones(len(i), bool), (i, j)), shape=(len(distinct), len(distinct)))
    _, group = connected_components(pairs, directed=False)
    merged: Integers = group[number].astype(np.int64)
    return merged


def joined(
    points: Floats, triangles: Integers, values: Floats, name: str, digits: float
) -> tuple[Floats, Integers, Floats]:
    """Points, triangles and values (n, k) of a mesh with one node in place of all nodes with the same place and values.

    If values differ, as on the sides of an open crack, nodes stay separate. The same errors as `places`; CaseError if
    the values of separate triangles differ nearly everywhere, so that the solution is not continuous.
    """
    place = places(points, digits)
    if place.max(initial=-1) + 1 == len(points):
        return points, triangles, values
    first = np.arange(len(points))
    left = first
    near = AGREEING * np.abs(values).max(initial=0)
    for _ in range(MOST_VALUES):
        _, at, inverse = np.unique(place[left], return_index=True, return_inverse=True)
        leader = left[at][inverse.ravel()]
        agree = ~(np.abs(values[left] - values[leader]) > near).any(axis=1)
        first[left[agree]] = leader[agree]
        left = left[~agree]
        if not len(left):
            break
    kept, group = np.unique(first, return_inverse=True)
    several = np.bincount(place) > 1
    if are_apart([triangles]) and (np.bincount(place[kept]) > 1)[several].mean() > JUMPS:
        raise CaseError(
            f"{name} jumps from cell to cell, and the estimate takes a continuous solution: write its interpolation by "
            "linear elements"
        )
    return points[kept], group.ravel()[triangles], values[kept]
