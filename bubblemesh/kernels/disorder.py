"""Where the order of bubbles is broken: the twin is in `packing.annealing`."""

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.kernels.library import Library


def disorder_marked(
    compiled: Library, n: int, edges: Integers, on_boundary: int, inside: float, beside: float
) -> Floats:
    """Values (n,) of bubbles that are, or have a neighbour, without six neighbours by edges (m, 2); zero of all others.

    It is ``beside`` of those next to one of the first ``on_boundary`` bubbles, which have zero, and else ``inside``.
    """
    result = np.empty(n)
    compiled.call("mark_disorder", n, len(edges), np.ascontiguousarray(edges), on_boundary, inside, beside, result)
    return result
