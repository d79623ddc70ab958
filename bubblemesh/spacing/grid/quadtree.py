"""Quadtree grid: a quadtree whose cells change in size by no more than 2 : 1, with values at its vertices."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers

GRID_LEVELS = 30
CORNERS = np.array([[0, 0], [1, 0], [0, 1], [1, 1]])
MARGIN = 1e-9  # of the square's size: so far it reaches beyond what it covers
SPREADING = [(16, 0x0000FFFF0000FFFF), (8, 0x00FF00FF00FF00FF), (4, 0x0F0F0F0F0F0F0F0F), (2, 0x3333333333333333)]


class Vertices(NamedTuple):
    """Vertices of a background grid."""

    key: Integers  # (v,): numbers of the places, ascending: the same in all grids that stem from one
    points: Floats  # (v, 2)
    corners: Integers  # (n, 4): of the cells: lower left, lower right, upper left, upper right
    # (k, 3): vertices in the middle of a cell's side, and the ends of that side; those of large cells first
    hanging: Integers


@dataclass(frozen=True)
class Quadtree:
    """Square cells that tile a square."""

    low: Floats  # (2,): lower left corner of the square
    size: float  # side of the square
    level: Integers  # (n,): how often the square was halved for each cell
    column_row: Integers  # (n, 2): lower left corners of the cells, in units of the deepest level

    @classmethod
    def around(cls, bounds: tuple[float, float, float, float]) -> "Quadtree":
        """One cell around a bounding box (x0, y0, x1, y1)."""
        x0, y0, x1, y1 = bounds
        size = max(x1 - x0, y1 - y0)
        low = np.array([x0, y0]) - MARGIN * size
        return cls(low, size * (1 + 2 * MARGIN), np.zeros(1, np.int64), np.zeros((1, 2), np.int64))

    def __len__(self) -> int:
        return len(self.level)

    @cached_property
    def sides(self) -> Floats:
        """Sides (n,) of the cells."""
        return np.asarray(self.size / 2.0**self.level, float)

    @cached_property
    def divisible(self) -> Booleans:
        """Whether each of the cells (n,) is above the deepest level."""
        return self.level < GRID_LEVELS

    @cached_property
    def centers(self) -> Floats:
        """Centres (n, 2) of the cells."""
        return self._points(self.column_row) + self.sides[:, None] / 2

    def corners(self, cells: Integers) -> Floats:
        """Corners (k, 4, 2) of some cells, to the last bit the same for all cells that share them."""
        return self._points(self._corners(cells))

    def _corners(self, cells: Integers | slice) -> Integers:
        """Columns and rows (k, 4, 2) of the corners of some cells."""
        width = 1 << (GRID_LEVELS - self.level[cells])
        return self.column_row[cells][:, None] + CORNERS * width[:, None, None]

    @cached_property
    def _key(self) -> Integers:
        return _interleaved(self.column_row)

    def _points(self, column_row: Integers) -> Floats:
        return self.low + column_row * (self.size / 2**GRID_LEVELS)

    def located(self, points: Floats) -> Integers:
        """Cells (m,) in which the points (m, 2) lie; points beyond the square count as on its rim."""
        at = np.clip((points - self.low) * (2**GRID_LEVELS / self.size), 0, 2**GRID_LEVELS - 1)
        return self._located(at.astype(np.int64))

    def _located(self, column_row: Integers) -> Integers:
        return np.searchsorted(self._key, _interleaved(column_row), side="right") - 1

    def covers(self, points: Floats) -> Booleans:
        """Whether each of the points (m, 2) lies in the square."""
        x, y = (points - self.low).T
        return (x >= 0) & (x <= self.size) & (y >= 0) & (y <= self.size)

    def split(self, cells: Booleans) -> tuple["Quadtree", Integers, Booleans]:
        """The grid with some divisible ``cells`` (n,) in four; from which cell each stems, and which are quarters."""
        old, new = np.flatnonzero(~cells), np.repeat(np.flatnonzero(cells), 4)
        level = np.concatenate([self.level[old], self.level[new] + 1])
        half = 1 << (GRID_LEVELS - self.level[new] - 1)
        quarter = np.tile(CORNERS, (len(new) // 4, 1)) * half[:, None]
        column_row = np.concatenate([self.column_row[old], self.column_row[new] + quarter])
        order = np.argsort(_interleaved(column_row), kind="stable")
        origin, fresh = np.concatenate([old, new])[order], (np.arange(len(level)) >= len(old))[order]
        return Quadtree(self.low, self.size, level[order], column_row[order]), origin, fresh

    def unbalanced(self) -> Booleans:
        """Cells (n,) that are more than twice as large as one beside them."""
        large = np.zeros(len(self), bool)
        width = 1 << (GRID_LEVELS - self.level)
        for across in ([-1, 0], [1, 0], [0, -1], [0, 1]):
            beside = self.column_row + (width // 2)[:, None] + np.array(across) * (width // 2 + 1)[:, None]
            known = ((beside >= 0) & (beside < 2**GRID_LEVELS)).all(axis=1)
            neighbour = self._located(beside[known])
            large[neighbour[self.level[neighbour] < self.level[known] - 1]] = True
        return large

    @cached_property
    def vertices(self) -> Vertices:
        """The corners of all cells, each once."""
        all_corners = self._corners(slice(None))
        key, corners = np.unique(_packed(all_corners.reshape(-1, 2)), return_inverse=True)
        points = self._points(np.column_stack([key >> (GRID_LEVELS + 1), key & (2 ** (GRID_LEVELS + 1) - 1)]))
        corners = corners.reshape(-1, 4)
        hanging = []
        for first, last in ([0, 1], [2, 3], [0, 2], [1, 3]):
            middle = _packed((all_corners[:, first] + all_corners[:, last]) // 2)
            at = np.minimum(np.searchsorted(key, middle), len(key) - 1)
            there = np.flatnonzero((key[at] == middle) & (self.level < GRID_LEVELS))
            hanging.append(np.column_stack([self.level[there], at[there], corners[there, first], corners[there, last]]))
        found = np.concatenate(hanging)
        return Vertices(key, points, corners, found[np.argsort(found[:, 0], kind="stable"), 1:])

    def bilinear(self, corners: Floats, points: Floats, cells: Integers) -> Floats:
        """Bilinear interpolation (m,) of values (m, 4) at the corners of ``cells`` (m,), at points (m, 2) in these."""
        at = (points - self._points(self.column_row[cells])) / self.sides[cells, None]
        s, t = np.clip(at, 0, 1).T
        a, b, c, d = corners.T
        return (1 - t) * ((1 - s) * a + s * b) + t * ((1 - s) * c + s * d)


def _packed(column_row: Integers) -> Integers:
    return column_row[:, 0] << (GRID_LEVELS + 1) | column_row[:, 1]


def _interleaved(column_row: Integers) -> Integers:
    """Keys (n,) of cells in Morton's order: the bits of column and row in turn.

    References
    ----------
    G. M. Morton, "A computer oriented geodetic data base and a new technique in file sequencing", IBM (1966).
    """
    bits = np.array(column_row, np.int64)
    for shift, mask in SPREADING:
        bits = (bits | bits << shift) & mask
    bits = (bits | bits << 1) & 0x5555555555555555
    return bits[:, 0] | bits[:, 1] << 1
