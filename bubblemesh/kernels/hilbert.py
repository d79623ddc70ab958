"""Places in the order in which a Hilbert curve meets them: what is near on it is near in space."""

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.kernels.library import call, or_numpy

HILBERT_BITS = 20  # per coordinate: cells of a millionth of the extent


def along_hilbert_curve(points: Floats) -> Integers:
    """Numbers (n,) of the points (n, 2) in the order in which a Hilbert curve over their bounding box meets them."""
    if len(points) == 0:
        return np.zeros(0, np.int64)
    x, y = np.ascontiguousarray(points.T)  # columns, which NumPy looks through several times faster than rows
    beyond = [column - column.min() for column in (x, y)]
    extent = max(*(float(column.max()) for column in beyond), np.finfo(float).tiny)
    cells = np.column_stack([column / extent * (2**HILBERT_BITS - 1) for column in beyond]).astype(np.int64)
    return np.argsort(hilbert_index(cells, HILBERT_BITS), kind="stable")


def hilbert_index_in_numpy(cells: Integers, bits: int) -> Integers:
    """The same as `hilbert_index`, in NumPy."""
    x, y = np.array(cells.T, np.int64, order="C")
    index = np.zeros(len(cells), np.int64)
    for bit in range(bits - 1, -1, -1):
        right, upper = (x >> bit) & 1, (y >> bit) & 1
        index <<= 2
        index |= (3 * right) ^ upper
        # The lower quarters are transposed, and the one on the right is turned about as well.
        lower = upper - 1  # all bits, or none
        below = (1 << bit) - 1
        turned = lower & -right & below
        x = (x & below) ^ turned
        y = (y & below) ^ turned
        exchanged = (x ^ y) & lower
        x ^= exchanged
        y ^= exchanged
    return index


@or_numpy(hilbert_index_in_numpy)
def hilbert_index(cells: Integers, bits: int) -> Integers:
    """Positions (n,) of the grid cells (n, 2), of 2**bits rows and columns, on the Hilbert curve.

    References
    ----------
    H. S. Warren, "Hacker's Delight", 2nd edition (2012), chapter 16.
    """
    index = np.empty(len(cells), np.int64)
    call("hilbert_index", n=len(cells), cells=np.ascontiguousarray(cells, np.int64), bits=bits, index=index)
    return index
