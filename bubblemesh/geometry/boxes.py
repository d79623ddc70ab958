"""Which of many boxes hold a point, by a grid of cells."""

from dataclasses import dataclass

import numpy as np

from bubblemesh.arrays import Floats, Integers, members

FINEST = 256  # cells along each side of the grid
PER_BOX = 2  # cells along each side for each box along it


@dataclass(frozen=True)
class Boxes:
    """Boxes, listed by the cells of a grid that they reach into.

    Attributes
    ----------
    bounds : (b, 4)
        x0, y0, x1, y1 of each box.
    low, step : (2,)
        Corner of the grid and size of its cells.
    cells : int
        Number of them along each side.
    first, box : (cells**2 + 1,), (e,)
        Boxes of cell k are ``box[first[k] : first[k + 1]]``.
    """

    bounds: Floats
    low: Floats
    step: Floats
    cells: int
    first: Integers
    box: Integers

    @classmethod
    def of(cls, bounds: Floats) -> "Boxes":
        """Grid over boxes (b, 4), at least one."""
        low, high = bounds[:, :2].min(axis=0), bounds[:, 2:].max(axis=0)
        cells = min(PER_BOX * int(np.ceil(np.sqrt(len(bounds)))), FINEST)
        step = np.maximum((high - low) / cells, np.finfo(float).tiny)
        begin, end = (np.clip((edge - low) // step, 0, cells - 1).astype(int) for edge in np.split(bounds, 2, axis=1))
        wide, tall = (end - begin + 1).T
        count = wide * tall
        box, number = members(count)
        cell = (begin[box, 0] + number // tall[box]) * cells + begin[box, 1] + number % tall[box]
        order = np.argsort(cell, kind="stable")
        first = np.searchsorted(cell[order], np.arange(cells**2 + 1))
        return cls(bounds, low, step, cells, first, box[order])

    def holding(self, x: Floats, y: Floats) -> tuple[Integers, Integers]:
        """Numbers (m,) of points, in order, and of boxes that hold them; points have coordinates x (n,) and y (n,)."""
        i, j = (np.floor((c - low) / step) for c, low, step in zip((x, y), self.low, self.step, strict=True))
        i, j = (np.where(k == self.cells, self.cells - 1, k) for k in (i, j))  # the grid's own edge
        near = np.flatnonzero((i >= 0) & (i < self.cells) & (j >= 0) & (j < self.cells))
        cell = (i[near] * self.cells + j[near]).astype(int)
        count = self.first[cell + 1] - self.first[cell]
        entry, rank = members(count)
        point, box = near[entry], self.box[self.first[cell[entry]] + rank]
        x0, y0, x1, y1 = self.bounds[box].T
        held = (x[point] >= x0) & (x[point] <= x1) & (y[point] >= y0) & (y[point] <= y1)
        return point[held], box[held]
