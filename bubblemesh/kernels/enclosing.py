"""Triangles that closed rings enclose: the twin is pythoncdt, which takes several times as long."""

import numpy as np
from numpy.typing import NDArray

from bubblemesh.arrays import Integers
from bubblemesh.kernels.library import call, or_none


@or_none
def enclosed(cells: NDArray[np.uint32], rings: Integers, n: int) -> Integers | None:
    """Triangles (k, 3), among ``cells`` (t, 6), that an odd number of rings encloses, in the order of the cells.

    The cells are three nodes and the neighbours behind the sides from each node to the next; they cover ``n`` nodes and
    three more, which are counted first, around them. The rings are sides (m, 2) between nodes. None if a side of a ring
    is not one of a cell, since it passes through a node, or without compiled kernels.
    """
    triangles, counts = np.empty((len(cells), 3), np.int64), np.empty(2, np.int64)
    walls = np.ascontiguousarray(rings, np.int64)
    call("enclose", n=n, t=len(cells), cells=cells, m=len(walls), walls=walls, triangles=triangles, counts=counts)
    count, in_pieces = counts.tolist()
    return None if in_pieces else triangles[:count]
