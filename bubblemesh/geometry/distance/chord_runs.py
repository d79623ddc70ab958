"""Runs of consecutive chords, each in a rectangle along the line from its first point to its last."""

from functools import cached_property

import numpy as np

from bubblemesh.arrays import Floats, Integers, members, taken
from bubblemesh.geometry.curves import shares_before
from bubblemesh.kernels.hilbert import along_hilbert_curve
from bubblemesh.kernels.nearest import RunTree
from bubblemesh.records import record

LENGTH = 16  # chords of a run
RUNS_AT_A_TIME = 1 << 11  # runs, so that their points stay in the processor's caches
COORDINATE_ROUNDING = 1e-14  # of the largest coordinate


@record
class ChordRuns:
    """Straight lines, the end of one being the start of the next within a run.

    Where the curve is smooth, the width of a run's rectangle falls with the square of its length, so that distances
    from it are good bounds. Boxes along the axes would be much looser.
    """

    start: Floats  # (m, 2), of each chord
    end: Floats  # (m, 2), the same for a mere point
    first: Integers  # (r,), first chord of each run
    count: Integers  # (r,), number of its chords
    x: Floats  # (LENGTH + 1, r), of the points of each run, the last one repeated in shorter runs
    y: Floats  # likewise
    boxes: Floats  # (6, r), centre and axis of each run's rectangle, half its length and half its width
    margin: float  # bound for the displacement of a point by rounding

    @classmethod
    def of(cls, start: Floats, end: Floats) -> "ChordRuns":
        """Runs of the chords from ``start`` (m, 2) to ``end`` (m, 2), of which there is at least one."""
        connected = (start[1:] == end[:-1]).all(axis=1)
        begin = np.flatnonzero(np.append(True, ~connected))
        size = np.diff(begin, append=len(start))
        runs = -(-size // LENGTH)
        path, earlier = members(runs)
        first = begin[path] + LENGTH * earlier
        count = np.minimum((begin + size)[path] - first, LENGTH)
        last = first + count - 1
        rank = np.arange(LENGTH + 1)[:, None]
        chord = np.minimum(first + rank, last)
        points = np.where((rank < count)[..., None], start[chord], end[last])
        x, y = np.ascontiguousarray(np.moveaxis(points, 2, 0))
        margin = COORDINATE_ROUNDING * float(max(np.abs(start).max(), np.abs(end).max()))
        return cls(start, end, first, count, x, y, _boxes(x, y, margin), margin)

    @cached_property
    def tree(self) -> RunTree:
        """The runs in a tree, for compiled kernels."""
        centers = np.ascontiguousarray(self.boxes[:2].T)
        order = along_hilbert_curve(centers)
        points = np.stack([self.x.T, self.y.T], axis=2)[order]
        return RunTree.of(points, self.boxes.T[order], self.first[order], self.count[order], self.margin)

    def at_least(self, x: Floats, y: Floats, run: Integers) -> Floats:
        """Squared distances (g, p) of points at x, y (g, p) from the rectangles of runs (p,)."""
        cx, cy, ux, uy, length, width = self.boxes.take(run, axis=1)
        dx, dy = x - cx, y - cy
        beyond, beside = dx * ux, dy * ux
        beyond += dy * uy
        beside -= dx * uy
        for way, half in ((beyond, length), (beside, width)):
            np.abs(way, out=way)
            way -= half
            np.maximum(way, 0, out=way)
            way *= way
        beyond += beside
        return beyond

    def at_most(self, x: Floats, y: Floats, run: Integers) -> Floats:
        """Upper bounds (g, p) of the distances from points at x, y (g, p) to everything in the runs (p,)."""
        cx, cy, _, _, length, width = self.boxes.take(run, axis=1)
        return np.sqrt((x - cx) ** 2 + (y - cy) ** 2) + np.hypot(length, width)

    def nearest(self, x: Floats, y: Floats, run: Integers) -> tuple[Floats, Integers]:
        """Squared distances (k,) of points at x, y (k,) from runs (k,), and the first of the nearest chords (k,)."""
        squared, chord = np.empty(len(run)), np.empty(len(run), np.int64)
        for begin in range(0, len(run), RUNS_AT_A_TIME):
            part = slice(begin, begin + RUNS_AT_A_TIME)
            squared[part], chord[part] = self._nearest(x[part], y[part], run[part])
        return squared, chord

    def _nearest(self, px: Floats, py: Floats, run: Integers) -> tuple[Floats, Integers]:
        """The same as `nearest`, for all points at once."""
        x, y = self.x.take(run, axis=1), self.y.take(run, axis=1)
        ux, uy = x[1:] - x[:-1], y[1:] - y[:-1]
        x -= px
        y -= py
        across = ux * y[:-1]
        across -= uy * x[:-1]
        length = ux * ux
        length += uy * uy
        away = x * x
        away += y * y
        from_start, from_end = away[:-1], away[1:]
        beside = np.abs(from_start - from_end) < length
        squared = np.minimum(from_start, from_end)
        np.divide(across, length, out=length, where=beside)
        np.multiply(across, length, out=squared, where=beside)
        rank = squared.argmin(axis=0)
        return squared[rank, np.arange(len(rank))], self.first[run] + np.minimum(rank, self.count[run] - 1)

    def feet(self, points: Floats, chord: Integers) -> tuple[Floats, Floats]:
        """Share (m,) of chords (m,) that lies before the place nearest to points (m, 2), and that place (m, 2)."""
        start, end = taken(self.start, chord), taken(self.end, chord)
        share = shares_before(points, start, end)
        return share, start + share[:, None] * (end - start)


def _boxes(x: Floats, y: Floats, margin: float) -> Floats:
    """Rectangles (6, r) around the points (k, r), wider and longer by the margin."""
    dx, dy = x - x[0], y - y[0]
    length = np.hypot(dx[-1], dy[-1])
    closed = length == 0
    ux, uy = np.where(closed, 1, dx[-1] / np.where(closed, 1, length)), dy[-1] / np.where(closed, 1, length)
    along, across = dx * ux + dy * uy, dy * ux - dx * uy
    (begin, end), (right, left) = ((v.min(axis=0), v.max(axis=0)) for v in (along, across))
    middle, shift = (begin + end) / 2, (left + right) / 2
    center = x[0] + middle * ux - shift * uy, y[0] + middle * uy + shift * ux
    return np.array([*center, ux, uy, (end - begin) / 2 + margin, (left - right) / 2 + margin])
