"""Values at the corners of a quadtree's cells, lowered until they grow nowhere faster than a given rate."""

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.kernels.library import call, or_numpy

SWEEPS = 100_000
BESIDE = np.array([[1, 2], [0, 3], [3, 0], [2, 1]])  # corners of a cell beside each of its corners
OPPOSITE = np.array([3, 2, 1, 0])


def spread_in_numpy(corners: Integers, rise: Floats, values: Floats, tolerance: float) -> Floats:
    """The same as `spread`, in NumPy."""
    around = _cells_around(corners, len(values))
    result = values.copy()
    active = np.arange(len(corners))
    for _ in range(SWEEPS):
        mine = corners[active]
        before = result[mine]
        after = _updated(before, rise[active, None])
        lower = after < before * (1 - tolerance)
        if not lower.any():
            break
        np.minimum.at(result, mine[lower], after[lower])
        near = np.zeros(len(corners) + 1, bool)  # the last one takes the numbers -1
        near[around[mine[lower]]] = True
        active = np.flatnonzero(near[:-1])
    return result


@or_numpy(spread_in_numpy)
def spread(corners: Integers, rise: Floats, values: Floats, tolerance: float) -> Floats:
    """Values (v,) after they have spread through cells with vertices ``corners`` (n, 4).

    Along a side of a cell they rise by ``rise`` (n,) at most. A value may be infinite; it is passed on if it was
    lowered by more than the relative ``tolerance``. Every sweep updates the cells around the values that the last one
    lowered.

    References
    ----------
    W.-K. Jeong, R. T. Whitaker, "A fast iterative method for Eikonal equations", SIAM J. Sci. Comput. 30 (2008), for
    the order of the updates; J. N. Tsitsiklis, "Efficient algorithms for globally optimal trajectories", IEEE Trans.
    Automatic Control 40 (1995), for a single one.
    """
    result = values.copy()
    call(
        "spread",
        cells=len(corners),
        corners=corners,
        rise=rise,
        vertices=len(values),
        values=result,
        kept=1 - tolerance,
        sweeps=SWEEPS,
    )
    return result


def _cells_around(corners: Integers, count: int) -> Integers:
    """Cells (count, 4) around each vertex, by the ``corners`` (n, 4) of all cells; -1 where there is no cell."""
    around = np.full((count, 4), -1)
    for place in range(4):  # no two cells have a vertex at the same corner
        around[corners[:, place], place] = np.arange(len(corners))
    return around


def _updated(values: Floats, rise: Floats) -> Floats:
    """Largest values (k, 4) at each corner of square cells that its other corners admit.

    The ``rise`` (k, 1) is the growth along a side. Each corner is reached across two triangles, each of which has it,
    one corner beside it, and the opposite one.
    """
    with np.errstate(invalid="ignore"):
        beside, opposite = values[:, BESIDE], values[:, OPPOSITE][:, :, None]
        slant = np.clip(np.nan_to_num((beside - opposite) / rise[:, :, None], nan=0.0), 0, np.sqrt(0.5))
        # The way starts at the share t of the opposite side, where slant = t / sqrt(1 + t^2).
        crossing = beside + rise[:, :, None] * np.sqrt(1 - slant**2)
        straight = opposite + rise[:, :, None] * np.sqrt(2)
    return np.where(slant >= np.sqrt(0.5), straight, np.minimum(crossing, straight)).min(axis=2)
