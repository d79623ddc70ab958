"""Patches of nodes around triangles: the twin is in `packing.mending`."""

import numpy as np

from bubblemesh.arrays import Booleans, Integers
from bubblemesh.kernels.library import Library


def separate_patches(
    compiled: Library, edges: Integers, seeds: Integers, free: Booleans, inner: int, outer: int
) -> tuple[Booleans, Integers, int]:
    """Patches of free nodes (n,) around some ``seeds``, which are triangles (k, 3), and how many these are.

    Nodes at most ``inner`` of the edges (m, 2) away are in a mask (n,), those at most ``outer`` away have the number of
    their patch in (n,), others -1. Of two patches that have an edge in between there is the one whose seed comes first.
    """
    near, patch, count = np.zeros(len(free), bool), np.full(len(free), -1), np.empty(1, np.int64)
    sizes = len(free), len(edges), np.ascontiguousarray(edges), len(seeds), np.ascontiguousarray(seeds)
    compiled.call("separate_patches", *sizes, free, inner, outer, near, patch, count)
    return near, patch, int(count[0])
