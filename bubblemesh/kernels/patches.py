"""Patches of nodes around triangles: the twin of `separate_patches` is in `packing.mending`."""

import numpy as np

from bubblemesh.arrays import Booleans, Integers
from bubblemesh.kernels.library import call, or_numpy


def separate_patches(
    edges: Integers, seeds: Integers, free: Booleans, inner: int, outer: int
) -> tuple[Booleans, Integers, int]:
    """Separate patches of nodes around triangles; of two patches with an edge in between, the later one is dropped.

    Parameters
    ----------
    edges
        Edges (m, 2) between the nodes.
    seeds
        Triangles (k, 3) around which patches are made, the most important one first.
    free
        Mask (n,) of the nodes that may be in a patch.
    inner, outer
        Distances from the seed, in edges.

    Returns
    -------
    tuple
        Mask (n,) of the nodes within the inner distance of their seed; for each node within the outer one the number of
        its patch, else -1 (n,); the number of patches.
    """
    near, patch, count = np.zeros(len(free), bool), np.full(len(free), -1), np.empty(1, np.int64)
    call(
        "separate_patches",
        n=len(free),
        m=len(edges),
        edges=np.ascontiguousarray(edges),
        k=len(seeds),
        seeds=np.ascontiguousarray(seeds),
        free_nodes=free,
        inner=inner,
        outer=outer,
        displaced=near,
        moving=patch,
        count=count,
    )
    return near, patch, int(count[0])


def first_groups(chosen: Booleans, triangles: Integers) -> Integers:
    """For each chosen node (n,) of triangles (t, 3) the number of the first group without a neighbour of it, else -1.

    The twin is `independent_groups_in_numpy` in `packing.newton`.
    """
    groups = np.empty(len(chosen), np.int64)
    call("first_groups", n=len(chosen), t=len(triangles), triangles=triangles, chosen=chosen, groups=groups)
    return groups


def least_around_in_numpy(edges: Integers, values: Integers, rings: int) -> Integers:
    """The same as `least_around`, in NumPy."""
    (i, j), result = edges.T, values
    for _ in range(rings):
        before, result = result, result.copy()
        np.minimum.at(result, i, before[j])
        np.minimum.at(result, j, before[i])
    return result


@or_numpy(least_around_in_numpy)
def least_around(edges: Integers, values: Integers, rings: int) -> Integers:
    """The least of the values (n,) of nodes with edges (m, 2) at most so many edges away from each."""
    result = values.copy()
    call("least_around", n=len(values), m=len(edges), edges=np.ascontiguousarray(edges), rings=rings, values=result)
    return result
