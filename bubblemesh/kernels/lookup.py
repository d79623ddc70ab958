"""Ranks among ascending numbers, and values at points in the cells of a quadtree that hold them."""

from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers, taken
from bubblemesh.kernels.library import call, or_numpy

# How far the bits of a number are shifted, step by step, to leave every second one free; and where they are then.
SHIFTS = 16, 8, 4, 2, 1
MASKS = 0x0000FFFF0000FFFF, 0x00FF00FF00FF00FF, 0x0F0F0F0F0F0F0F0F, 0x3333333333333333, 0x5555555555555555


class SquareCells(NamedTuple):
    """Square cells (n,) of different sizes that tile a larger square.

    The square has columns and rows, as wide as the smallest cell that is possible. Numbers in Morton's order take the
    bits of column and row in turn.
    """

    low: Floats  # (2,): lower left corner of the square
    size: float  # its side
    columns: int  # how many it has, at most 2**31
    key: Integers  # (n,): numbers of the cells' lower left corners in Morton's order, ascending
    column_row: Integers  # (n, 2): these corners
    sides: Floats  # (n,)

    def keys_of(self, points: Floats) -> Integers:
        """Numbers (m,) in Morton's order of the columns and rows of points (m, 2), at the rim for those outside."""
        at = np.empty(points.shape, np.int64)
        for axis in range(2):
            place = (points[:, axis] - self.low[axis]) * (self.columns / self.size)
            at[:, axis] = np.fmin(np.fmax(place, 0), self.columns - 1)  # what is no number is in the first one, too
        return interleaved(at)

    def points(self, column_row: Integers) -> Floats:
        """Points (..., 2) at columns and rows (..., 2)."""
        points = np.empty(column_row.shape)
        for axis in range(2):  # much faster than both at once
            points[..., axis] = self.low[axis] + column_row[..., axis] * (self.size / self.columns)
        return points

    def bilinear(self, corners: Floats, points: Floats, cells: Integers) -> Floats:
        """Bilinear interpolation (m,) of values (m, 4) at the corners of ``cells`` (m,), at points (m, 2) in these."""
        at = (points - self.points(taken(self.column_row, cells))) / self.sides[cells, None]
        s, t = np.clip(at, 0, 1).T
        a, b, c, d = corners.T
        return (1 - t) * ((1 - s) * a + s * b) + t * ((1 - s) * c + s * d)


def interleaved(column_row: Integers) -> Integers:
    """Numbers (...) of places (..., 2) in Morton's order: the bits of column and row in turn.

    References
    ----------
    G. M. Morton, "A computer oriented geodetic data base and a new technique in file sequencing", IBM (1966).
    """
    bits = np.array(column_row, np.int64)
    for shift, mask in zip(SHIFTS, MASKS, strict=True):
        bits = (bits | bits << shift) & mask
    return bits[..., 0] | bits[..., 1] << 1


def ranks_in_numpy(ascending: Integers, numbers: Integers, with_equal: bool = False) -> Integers:
    """The same as `ranks`, in NumPy."""
    return np.searchsorted(ascending, numbers, side="right" if with_equal else "left")


@or_numpy(ranks_in_numpy)
def ranks(ascending: Integers, numbers: Integers, with_equal: bool = False) -> Integers:
    """How many of ``ascending`` numbers (n,) are below each of ``numbers`` (m,), or not above it ``with_equal``.

    It does what NumPy's ``searchsorted`` does, but each search begins where the last one ended. That is faster for
    numbers whose neighbours are similar, though not in order.
    """
    result = np.empty(len(numbers), np.int64)
    call(
        "ranks",
        n=len(ascending),
        ascending=np.ascontiguousarray(ascending, np.int64),
        m=len(numbers),
        numbers=np.ascontiguousarray(numbers, np.int64),
        with_equal=int(with_equal),
        result=result,
    )
    return result


def interpolated_in_numpy(cells: SquareCells, vertices: Integers, values: Floats, points: Floats) -> Floats:
    """The same as `interpolated`, in NumPy."""
    holding = np.searchsorted(cells.key, cells.keys_of(points), side="right") - 1
    found = np.flatnonzero(vertices[holding, 0] >= 0)
    result = np.full(len(points), np.inf)
    corners = values[vertices[holding[found]]]
    result[found] = cells.bilinear(corners, points[found], holding[found])
    return result


@or_numpy(interpolated_in_numpy)
def interpolated(cells: SquareCells, vertices: Integers, values: Floats, points: Floats) -> Floats:
    """Values (m,) at points (m, 2), by bilinear interpolation in the cells that hold them.

    The values (v,) are those at the ``vertices`` (n, 4), the corners of the cells. In cells whose first vertex is -1
    the result is infinite. A point outside of the square has the value at its rim.
    """
    result = np.empty(len(points))
    x, y = cells.low.tolist()
    call(
        "interpolate",
        m=len(points),
        points=np.ascontiguousarray(points, np.float64),
        x=x,
        y=y,
        scale=cells.columns / cells.size,
        unit=cells.size / cells.columns,
        count=float(cells.columns),
        n=len(cells.key),
        key=np.ascontiguousarray(cells.key),
        corner=np.ascontiguousarray(cells.column_row),
        sides=np.ascontiguousarray(cells.sides),
        vertices=np.ascontiguousarray(vertices),
        values=np.ascontiguousarray(values),
        result=result,
    )
    return result
