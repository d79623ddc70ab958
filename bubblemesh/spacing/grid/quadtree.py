"""Quadtree grid: a quadtree whose cells change in size by no more than 2 : 1, with values at its vertices."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, contained, different, each_once, taken
from bubblemesh.kernels.lookup import MASKS, SHIFTS, SquareCells, ranks
from bubblemesh.records import record

GRID_LEVELS = 30
CORNERS = np.array([[0, 0], [1, 0], [0, 1], [1, 1]])
CROSS = np.array([[0, -1], [-1, 0], [0, 0], [1, 0], [0, 1]])
COLUMN_BITS, ROW_BITS = 0x1555555555555555, 0x2AAAAAAAAAAAAAAA  # of a number in Morton's order
MARGIN = 1e-9  # of the square's size: so far it reaches beyond what it covers


class Vertices(NamedTuple):
    """Vertices of a background grid."""

    key: Integers  # (v,): numbers of the places in Morton's order, ascending: the same in all grids that stem from one
    points: Floats  # (v, 2)
    corners: Integers  # (n, 4): of the cells: lower left, lower right, upper left, upper right
    # (k, 3): vertices in the middle of a cell's side, and the ends of that side; those of large cells first
    hanging: Integers
    hanging_level: Integers  # (k,): levels of these cells


@record
class Quadtree:
    """Square cells that tile a square."""

    low: Floats  # (2,): lower left corner of the square
    size: float  # side of the square
    level: Integers  # (n,): how often the square was halved for each cell
    column_row: Integers  # (n, 2): lower left corners of the cells, in units of the deepest level
    key: Integers  # (n,): numbers of these corners in Morton's order, ascending

    @classmethod
    def around(cls, bounds: tuple[float, float, float, float]) -> "Quadtree":
        """Tree of one cell around a bounding box (x0, y0, x1, y1)."""
        x0, y0, x1, y1 = bounds
        size = max(x1 - x0, y1 - y0)
        low = np.array([x0, y0]) - MARGIN * size
        zero = np.zeros(1, np.int64)
        return cls(low, size * (1 + 2 * MARGIN), zero, np.zeros((1, 2), np.int64), zero)

    @classmethod
    def merged(cls, parts: Sequence["Quadtree"]) -> tuple["Quadtree", Integers]:
        """The grid of all cells of parts of one, and the number (n,) of each in these, one after the other."""
        level, column_row, key = (
            np.concatenate([getattr(part, name) for part in parts]) for name in ("level", "column_row", "key")
        )
        order = np.argsort(key, kind="stable")
        return cls(parts[0].low, parts[0].size, taken(level, order), taken(column_row, order), taken(key, order)), order

    def select(self, cells: Booleans) -> "Quadtree":
        """Selected cells (n,), which tile no square any more."""
        return replace(self, level=self.level[cells], column_row=taken(self.column_row, cells), key=self.key[cells])

    def __len__(self) -> int:
        return len(self.level)

    @cached_property
    def sides(self) -> Floats:
        """Sides (n,) of the cells."""
        return np.asarray((self.size / 2.0 ** np.arange(GRID_LEVELS + 1))[self.level], float)

    @cached_property
    def divisible(self) -> Booleans:
        """Whether each of the cells (n,) is above the deepest level."""
        return self.level < GRID_LEVELS

    @cached_property
    def centers(self) -> Floats:
        """Centres (n, 2) of the cells."""
        return self._points(self.column_row) + self.sides[:, None] / 2

    @cached_property
    def cells(self) -> SquareCells:
        """The cells as kernels take them."""
        return SquareCells(self.low, self.size, 2**GRID_LEVELS, self.key, self.column_row, self.sides)

    def corners(self, cells: Integers) -> Floats:
        """Corners (k, 4, 2) of some cells, to the last bit the same for all cells that share them."""
        return self._points(self._corners(cells))

    def between_quarters(self) -> Floats:
        """Corners (k, 5, 2) at which the quarters (4 k,) of cells, four of each in turn, meet: in the order of rows."""
        width = 1 << (GRID_LEVELS - self.level[::4])
        column_row = np.repeat(self.column_row[3::4], len(CROSS), axis=0).reshape(-1, len(CROSS), 2)
        for place, (column, row) in enumerate(CROSS.tolist()):
            column_row[:, place, 0] += column * width
            column_row[:, place, 1] += row * width
        return self._points(column_row)

    def _corners(self, cells: Integers) -> Integers:
        """Columns and rows (k, 4, 2) of the corners of some cells."""
        width = 1 << (GRID_LEVELS - self.level[cells])
        return self.column_row[cells][:, None] + CORNERS * width[:, None, None]

    def _points(self, column_row: Integers) -> Floats:
        return self.cells.points(column_row)

    def located(self, points: Floats) -> Integers:
        """Cells (m,) in which the points (m, 2) lie; points beyond the square count as on its rim."""
        return ranks(self.key, self.cells.keys_of(points), with_equal=True) - 1

    @property
    def ends(self) -> Integers:
        """Keys (n,) behind the last one that each cell holds."""
        return self.key + (1 << 2 * (GRID_LEVELS - self.level))

    def covers(self, points: Floats) -> Booleans:
        """Whether each of the points (m, 2) lies in the square."""
        x, y = (points - self.low).T
        return (x >= 0) & (x <= self.size) & (y >= 0) & (y <= self.size)

    def split(self, cells: Booleans) -> tuple["Quadtree", Integers, Booleans]:
        """The grid with some divisible ``cells`` (n,) in four; from which cell each stems, and which are quarters."""
        count = np.where(cells, 4, 1)
        origin = np.repeat(np.arange(len(self)), count)
        fresh = cells[origin]
        quarter = np.arange(len(origin)) - (np.cumsum(count) - count)[origin]
        return self._parts(origin, quarter, fresh), origin, fresh

    def quarters(self) -> "Quadtree":
        """The quarters (4 n,) of all cells, four of each in turn in the order of its corners."""
        number = np.arange(4 * len(self))
        return self._parts(number >> 2, number & 3, np.ones(len(number), bool))

    def _parts(self, origin: Integers, quarter: Integers, finer: Booleans) -> "Quadtree":
        """The cells ``origin`` (k,), or where they are ``finer`` (k,) their quarters (k,), zero for the other ones."""
        level = self.level[origin] + finer
        half = 1 << (GRID_LEVELS - level)
        column_row = taken(self.column_row, origin)
        column_row[:, 0] += (quarter & 1) * half
        column_row[:, 1] += (quarter >> 1) * half
        return Quadtree(self.low, self.size, level, column_row, self.key[origin] + quarter * half * half)

    @property
    def codes(self) -> Integers:
        """Numbers (n,) of the cells, the same in all grids that stem from one."""
        return 1 << 2 * self.level | self.key >> 2 * (GRID_LEVELS - self.level)

    def among(self, codes: Integers) -> Booleans:
        """Whether each of the cells (n,) has one of the codes (k,), which ascend."""
        return contained(self.codes, codes)

    def unbalanced(self) -> Integers:
        """Codes (k,), ascending, of all cells that are split where none is more than twice as large as one beside it.

        Those that the grid has split already are left out. Beside a cell that is split there have to be cells of its
        size, so what holds these is split as well: one pass from the smallest cells to the largest finds them all.
        """
        found = [np.zeros(0, np.int64)]
        split, needed = found[0], found[0]  # cells of one level, by their numbers in Morton's order, ascending
        for level in range(int(self.level.max(initial=0)) - 1, -1, -1):
            quarters = self.key[self.level == level + 1] >> 2 * (GRID_LEVELS - level - 1)
            beside = _beside(np.append(split, needed), level + 1)
            split = each_once(np.append(different(quarters >> 2), split >> 2))
            needed = each_once(np.append(needed, beside) >> 2)
            needed = needed[~contained(needed, split)]
            found.append(1 << 2 * level | needed)
        return np.concatenate(found[::-1])

    @cached_property
    def vertices(self) -> Vertices:
        """The corners of all cells, each once."""
        width = 1 << 2 * (GRID_LEVELS - self.level)  # in columns, as a number in Morton's order
        lower_right, upper_left = _to_the_right(self.key, width), _upwards(self.key, width)
        of_corners = np.stack([self.key, lower_right, upper_left, _upwards(lower_right, width)], axis=1)
        # Most corners are the lower left one of some cell, and so in order already.
        beside = of_corners[:, 1:].ravel()
        others = beside[self.key[ranks(self.key, beside, with_equal=True) - 1] != beside]
        key = np.sort(np.append(self.key, each_once(others)), kind="stable")
        corners = ranks(key, of_corners.ravel()).reshape(-1, 4)
        hanging = []
        for first, last, onwards in ((0, 1, _to_the_right), (2, 3, _to_the_right), (0, 2, _upwards), (1, 3, _upwards)):
            middle = onwards(of_corners[:, first], width >> 2)
            at = np.minimum(ranks(key, middle), len(key) - 1)
            there = np.flatnonzero((key[at] == middle) & (self.level < GRID_LEVELS))
            hanging.append(np.column_stack([self.level[there], at[there], corners[there, first], corners[there, last]]))
        found = np.concatenate(hanging)
        found = found[np.argsort(found[:, 0], kind="stable")]
        return Vertices(key, self._points(_parted(key)), corners, found[:, 1:], found[:, 0])


def _to_the_right(key: Integers, columns: Integers) -> Integers:
    """Numbers (k,) in Morton's order some columns, a number in that order, to the right of others (k,).

    The carry of the sum jumps over the bits of the rows.
    """
    return (key | ROW_BITS) + columns & COLUMN_BITS | key & ROW_BITS


def _upwards(key: Integers, rows: Integers) -> Integers:
    """Cells as many rows above."""
    return (key | COLUMN_BITS) + (rows << 1) & ROW_BITS | key & COLUMN_BITS


def _beside(cells: Integers, level: int) -> Integers:
    """Cells (m,) of a level that share a side with some (k,) of it, but for those in the same larger cell.

    Columns and rows are counted within the number in Morton's order: the carry of a sum jumps over the other's bits.
    """
    column, row = cells & COLUMN_BITS, cells & ROW_BITS
    last = (1 << 2 * level) - 1
    right, upper = (column & 1) > 0, (row & 2) > 0
    there = np.where(right, column < last & COLUMN_BITS, column > 0)
    across = np.where(right, (column | ROW_BITS) + 1, column - 1) & COLUMN_BITS | row
    above = np.where(upper, row < last & ROW_BITS, row > 0)
    along = np.where(upper, (row | COLUMN_BITS) + 1, row - 2) & ROW_BITS | column
    return np.append(across[there], along[above])


def _parted(key: Integers) -> Integers:
    """Columns and rows (k, 2) of places of these keys (k,) in Morton's order."""
    bits = np.stack([key, key >> 1], axis=1) & COLUMN_BITS
    for shift, mask in zip(SHIFTS[::-1], (*MASKS[-2::-1], 2**32 - 1), strict=True):
        bits = (bits | bits >> shift) & mask
    return bits
