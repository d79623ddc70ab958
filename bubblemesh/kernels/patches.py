"""Patches of nodes around triangles: the twin is in `packing.mending`."""

import numpy as np

from bubblemesh.arrays import Booleans, Integers
from bubblemesh.kernels.library import Library


def separate_patches(
    compiled: Library, edges: Integers, seeds: Integers, free: Booleans, inner: int, outer: int
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
    compiled.call(
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
