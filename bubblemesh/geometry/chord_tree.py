"""Nearest chords of polygonal rings, for many points at a time."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers

__all__ = ["ChordTree", "by_cells"]

FANOUT = 4
PADDING = 16  # chords: a ring fills whole nodes up to this size
MOST_ROOTS = 16
IN_A_CELL = 16  # points that begin the search together
AT_A_TIME = 1 << 14  # points, so that the arrays stay in the processor's caches
ROUNDING = 1e-14  # of the largest coordinate: the centre of a rectangle is rounded


@dataclass(frozen=True)
class ChordTree:
    """A tree over consecutive chords, each node in a rectangle along the way from its first point to its last.

    Along a smooth curve the width of these falls with the square of their length, so that few nodes are in question at
    any depth, however far the points are. Upright boxes around the chords would be much looser.

    Attributes
    ----------
    boxes : (11, k)
        Of each node the centre and axis of its rectangle, half its length and half its width, half the length over
        which it surely has chords (negative if that is not known), and its outermost points to the left and right.
    child : (k,)
        First of its children, -1 for a chord.
    chord : (k,)
        Number of the chord, -1 for other nodes.
    roots : (r,)
    """

    boxes: Floats
    child: Integers
    chord: Integers
    roots: Integers

    @classmethod
    def of(cls, points: Floats, successor: Integers, ring: Integers) -> "ChordTree":
        """Tree of the chords from each of ``points`` (m, 2) to its successor; the rings (m,) are contiguous."""
        parts = np.split(np.arange(len(ring)), np.flatnonzero(np.diff(ring)) + 1)
        leaves = np.concatenate([_padded(chords) for chords in parts])
        first, last, below, size = leaves, leaves, 0, len(leaves)
        boxes, children = [_boxes(points, successor, ring, first, last)], [np.full(size, -1)]
        while size > MOST_ROOTS:
            # The last node may have fewer children than the others: it shares some with the one before.
            begin = np.minimum(np.arange(0, size, FANOUT), max(size - FANOUT, 0))
            first, last = first[begin], last[np.minimum(begin + FANOUT, size) - 1]
            boxes.append(_boxes(points, successor, ring, first, last))
            children.append(below + begin)
            below, size = below + size, len(begin)
        chords = np.full(below + size, -1)
        chords[: len(leaves)] = leaves
        return cls(
            np.ascontiguousarray(np.concatenate(boxes).T),
            np.concatenate(children),
            chords,
            np.arange(below, below + size),
        )

    def nearest(self, points: Floats) -> Integers:
        """Number (m,) of the chord nearest to each of ``points`` (m, 2)."""
        found = np.zeros(len(points), np.int64)
        order = by_cells(points, IN_A_CELL)
        for k in range(0, len(points), AT_A_TIME):
            part = order[k : k + AT_A_TIME]
            found[part] = self._nearest(points[part])
        return found

    @cached_property
    def _rounding(self) -> float:
        return ROUNDING * float(np.abs(self.boxes[:2]).max() + self.boxes[4, self.roots].max())

    def _nearest(self, points: Floats) -> Integers:
        """The same for points that lie near their neighbours in the list."""
        first = np.arange(0, len(points), IN_A_CELL)
        count = np.diff(first, append=len(points))
        cell = np.repeat(np.arange(len(first)), count)
        center = np.add.reduceat(points, first) / count[:, None]
        reach = np.maximum.reduceat(np.hypot(*(points - center[cell]).T), first)
        owner = np.repeat(np.arange(len(first)), len(self.roots))
        owner, node, _ = self._descended(center, reach, owner, np.tile(self.roots, len(first)))
        begin = np.searchsorted(owner, np.arange(len(first)))
        nodes = np.diff(begin, append=len(owner))[cell]
        mine = np.repeat(np.arange(len(points)), nodes)
        rank = np.arange(len(mine)) - np.repeat(np.cumsum(nodes) - nodes, nodes)
        mine, node, distance = self._descended(points, np.zeros(len(points)), mine, node[begin[cell][mine] + rank])
        starts = np.searchsorted(mine, np.arange(len(points)))
        least = np.minimum.reduceat(distance, starts)
        best = np.flatnonzero(distance == least[mine])
        return self.chord[node[best[np.searchsorted(mine[best], np.arange(len(points)))]]]

    def _descended(
        self, points: Floats, reach: Floats, owner: Integers, node: Integers
    ) -> tuple[Integers, Integers, Floats]:
        """Pairs of points (sorted) and nodes that may hold the nearest chord of any place within ``reach`` of them.

        The nodes are chords, or no wider than the reach.
        """
        while True:
            box = self.boxes[:, node].T
            near, far = _bounds(points[owner], box)
            starts = np.searchsorted(owner, np.arange(len(points)))
            best = np.minimum.reduceat(far, starts) + 2 * reach + self._rounding
            kept = near <= best[owner]
            owner, node, near = owner[kept], node[kept], near[kept]
            wide = (self.child[node] >= 0) & (box[kept, 5] >= reach[owner] / 4)
            if not wide.any():
                return owner, node, near
            owner, node = self._opened(owner, node, wide)

    def _opened(self, owner: Integers, node: Integers, wide: Booleans) -> tuple[Integers, Integers]:
        """The pairs with the wide nodes replaced by their children."""
        count = np.where(wide, FANOUT, 1)
        rank = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
        base = np.where(wide, self.child[node], node)
        return np.repeat(owner, count), np.repeat(base, count) + rank


def _padded(chords: Integers) -> Integers:
    """The chords of a ring, the last one repeated up to a full node."""
    missing = -len(chords) % PADDING
    return np.concatenate([chords, np.repeat(chords[-1:], missing)])


def _boxes(points: Floats, successor: Integers, ring: Integers, first: Integers, last: Integers) -> Floats:
    """Rows (k, 11) of the nodes that hold the chords from ``first`` to ``last`` (k,)."""
    start, end = points[first], points[successor[last]]
    axis = end - start
    length = np.hypot(*axis.T)
    flat = length > 0
    axis = np.where(flat[:, None], axis / np.where(flat, length, 1)[:, None], [1.0, 0.0])
    # Both ends of every chord: where a ring closes, they do not follow each other.
    count = 2 * (last - first + 1)
    begin = np.cumsum(count) - count
    node = np.repeat(np.arange(len(first)), count)
    rank = np.arange(len(node)) - begin[node]
    chord = first[node] + rank // 2
    own = points[np.where(rank % 2 == 0, chord, successor[chord])]
    (x, y), (u, v) = (own - start[node]).T, axis[node].T
    along, across = x * u + y * v, u * y - v * x
    low, high = np.minimum.reduceat(along, begin), np.maximum.reduceat(along, begin)
    left, right = np.maximum.reduceat(across, begin), np.minimum.reduceat(across, begin)
    middle, shift = (low + high) / 2, (left + right) / 2
    center = start + middle[:, None] * axis + shift[:, None] * np.column_stack([-axis[:, 1], axis[:, 0]])
    sure = np.where(ring[first] == ring[last], np.minimum(middle, length - middle), -1.0)
    outermost = [own[_first_of(across == most[node], node, len(first))] for most in (left, right)]
    slack = 1 + 1e-12
    measures = np.column_stack([(high - low) / 2 * slack, (left - right) / 2 * slack, sure])
    return np.column_stack([center, axis, measures, *outermost])


def _first_of(marked: Booleans, node: Integers, count: int) -> Integers:
    """Row of the first marked point of each node."""
    rows = np.flatnonzero(marked)
    return rows[np.searchsorted(node[rows], np.arange(count))]


def _bounds(points: Floats, box: Floats) -> tuple[Floats, Floats]:
    """Distances (m,) that the chords of nodes (m, 11) at least have from points (m, 2), and that some do not exceed."""
    (px, py), (cx, cy, ux, uy, length, width, sure, lx, ly, rx, ry) = points.T, box.T
    x, y = px - cx, py - cy
    along, across = np.abs(x * ux + y * uy), y * ux - x * uy
    side, across = across > 0, np.abs(across)
    # Square roots rather than hypot, which takes several times as long; lengths are no less than 1e-70.
    near = np.maximum(along - length, 0) ** 2 + np.maximum(across - width, 0) ** 2
    through = np.where(sure >= 0, np.maximum(along - sure, 0) ** 2 + (across + width) ** 2, np.inf)
    outermost = (np.where(side, lx, rx) - px) ** 2 + (np.where(side, ly, ry) - py) ** 2
    return np.sqrt(near), np.sqrt(np.minimum(through, outermost))


def by_cells(points: Floats, in_a_cell: int) -> Integers:
    """An order (m,) of the points in which neighbours in the list are neighbours in the plane."""
    if len(points) == 0:
        return np.zeros(0, np.int64)
    low, high = points.min(axis=0), points.max(axis=0)
    side = int(np.ceil(np.sqrt(len(points) / in_a_cell)))
    column, row = (
        np.minimum((points - low) / np.maximum(high - low, np.finfo(float).tiny) * side, side - 1).astype(int).T
    )
    # Rows run to and fro, so that the end of one is next to the start of the following one.
    return np.argsort(row * side + np.where(row % 2 == 1, side - 1 - column, column), kind="stable")
