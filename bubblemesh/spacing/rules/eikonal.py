"""Largest function below given values that nowhere grows faster than a limit: the Eikonal equation on a quadtree."""

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, taken
from bubblemesh.kernels.spreading import spread
from bubblemesh.spacing.grid.quadtree import Quadtree

LEAST_CHANGE = 1e-6  # relative change of a value that is worth passing on


def limited_values(grid: Quadtree, values: Floats, growth: float, medium: Booleans) -> Floats:
    """Values (v,) at the vertices of a grid, lowered until they grow by at most ``growth`` per length.

    They spread through the cells of the ``medium`` (n,) first, and from there, without a way back, through the others.
    Values may be infinite where nothing is known.

    References
    ----------
    P.-O. Persson, "Mesh size functions for implicit geometries and PDE-based gradient limiting", Engineering with
    Computers 22 (2006).
    """
    corners, rise = grid.vertices.corners, growth * grid.sides
    inner = spread(taken(corners, medium), rise[medium], values, LEAST_CHANGE)
    outer = spread(taken(corners, ~medium), rise[~medium], inner, LEAST_CHANGE)
    known = np.zeros(len(values), bool)
    known[taken(corners, medium)] = True
    result = np.where(known, inner, outer)
    for middle, first, last in _by_level(grid):
        result[middle] = (result[first] + result[last]) / 2
    return result


def _by_level(grid: Quadtree) -> list[tuple[Integers, Integers, Integers]]:
    """Hanging vertices with the ends of their sides, in groups none of which depends on itself."""
    hanging = grid.vertices.hanging
    starts = np.flatnonzero(np.diff(grid.vertices.hanging_level, prepend=-1))
    return [tuple(group.T) for group in np.split(hanging, starts[1:])] if len(hanging) else []
