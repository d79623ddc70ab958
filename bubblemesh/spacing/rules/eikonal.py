"""Largest function below given values that nowhere grows faster than a limit: the Eikonal equation on a quadtree."""

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.spacing.grid.quadtree import Quadtree

SWEEPS = 100_000
TOLERANCE = 1e-6  # relative change of a value that is worth passing on
BESIDE = np.array([[1, 2], [0, 3], [3, 0], [2, 1]])  # corners of a cell beside each of its corners
OPPOSITE = np.array([3, 2, 1, 0])


def limited_values(grid: Quadtree, values: Floats, growth: float, medium: Booleans) -> Floats:
    """Values (v,) at the vertices of a grid, lowered until they grow by at most ``growth`` per length.

    They spread through the cells of the ``medium`` (n,) first, and from there, without a way back, through the others.
    Values may be infinite where nothing is known.

    References
    ----------
    P.-O. Persson, "Mesh size functions for implicit geometries and PDE-based gradient limiting", Engineering with
    Computers 22 (2006), for the equation; W.-K. Jeong, R. T. Whitaker, "A fast iterative method for Eikonal equations",
    SIAM J. Sci. Comput. 30 (2008), for the order of the updates; J. N. Tsitsiklis, "Efficient algorithms for globally
    optimal trajectories", IEEE Trans. Automatic Control 40 (1995), for a single one.
    """
    inner = _spread(grid, values, growth, np.flatnonzero(medium))
    outer = _spread(grid, inner, growth, np.flatnonzero(~medium))
    known = np.zeros(len(values), bool)
    known[grid.vertices.corners[medium]] = True
    result = np.where(known, inner, outer)
    for middle, first, last in _by_level(grid):
        result[middle] = (result[first] + result[last]) / 2
    return result


def _by_level(grid: Quadtree) -> list[tuple[Integers, Integers, Integers]]:
    """Hanging vertices with the ends of their sides, in groups none of which depends on itself."""
    hanging = grid.vertices.hanging
    lengths = np.abs(grid.vertices.points[hanging[:, 1]] - grid.vertices.points[hanging[:, 2]]).max(axis=1)
    level = np.rint(np.log2(grid.size / lengths)).astype(int)
    starts = np.flatnonzero(np.diff(level, prepend=-1))
    return [tuple(group.T) for group in np.split(hanging, starts[1:])] if len(hanging) else []


def _spread(grid: Quadtree, values: Floats, growth: float, cells: Integers) -> Floats:
    """Values (v,) after they have spread through some ``cells``."""
    corners, rise = grid.vertices.corners[cells], growth * grid.sides[cells]
    around = _cells_around(corners, len(values))
    result = values.copy()
    active = np.arange(len(cells))
    for _ in range(SWEEPS):
        mine = corners[active]
        before = result[mine]
        after = _updated(before, rise[active, None])
        lower = after < before * (1 - TOLERANCE)
        if not lower.any():
            break
        np.minimum.at(result, mine[lower], after[lower])
        near = np.zeros(len(cells) + 1, bool)  # the last stands for none
        near[around[mine[lower]]] = True
        active = np.flatnonzero(near[:-1])
    return result


def _cells_around(corners: Integers, count: int) -> Integers:
    """Cells (count, 4) that have each of so many vertices among their ``corners`` (n, 4); -1 stands for none."""
    around = np.full((count, 4), -1)
    for place in range(4):  # no two cells have a vertex at the same corner
        around[corners[:, place], place] = np.arange(len(corners))
    return around


def _updated(values: Floats, rise: Floats) -> Floats:
    """Values (k, 4) that the other corners of a square cell admit at each; ``rise`` (k, 1) is the growth along a side.

    Each corner is reached across the two triangles between it, a corner beside it, and the opposite one.
    """
    with np.errstate(invalid="ignore"):
        beside, opposite = values[:, BESIDE], values[:, OPPOSITE][:, :, None]
        slant = np.clip(np.nan_to_num((beside - opposite) / rise[:, :, None], nan=0.0), 0, np.sqrt(0.5))
        # The way starts at the share t of the opposite side, where slant = t / sqrt(1 + t^2).
        crossing = beside + rise[:, :, None] * np.sqrt(1 - slant**2)
        straight = opposite + rise[:, :, None] * np.sqrt(2)
    return np.where(slant >= np.sqrt(0.5), straight, np.minimum(crossing, straight)).min(axis=2)
