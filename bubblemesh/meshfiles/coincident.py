"""Nodes that a file has several times, once for each cell, made one again."""

from collections.abc import Sequence

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import CaseError, FileError

ROUNDING = 64  # last digits of a coordinate by which copies of a node may differ
AGREEING = 1e-6  # of the largest value: copies of a node whose values differ by less have the same value
MOST_COPIES = 1000  # of a node, on average
MOST_VALUES = 16  # different ones of the copies of a node that are told apart
JUMPS = 0.5  # part of the nodes with several values from which on a solution is none that is continuous


def are_apart(cells: Sequence[Integers]) -> bool:
    """Whether each of some cells, blocks (m, k) of nodes, has nodes of its own, as if all had been cut apart."""
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
    """Points, triangles and values (n, k) of a mesh with one node for all in a place whose values agree.

    Where values differ, as on the sides of a crack that opens, nodes stay apart. Errors as of `places`; CaseError if
    values of a mesh whose triangles were cut apart differ nearly everywhere: the solution is not continuous.
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
