"""Obstacles: what columns must not meet, and which of them do, or would spoil the cells between them."""

from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray

from bubblemesh.arrays import (
    Booleans,
    Floats,
    Integers,
    any_of_rows,
    complement,
    cross,
    each_once,
    largest_of_rows,
    least_of_rows,
)
from bubblemesh.layers.strips import Strips
from bubblemesh.layers.walls import Walls
from bubblemesh.records import record

Shapes = NDArray[np.object_]  # polygons or lines

FLAT_CELL = 0.02  # least sine of an angle of a cell between a wall and a column
APART = 0.25  # least distance of strips of different walls, in terms of the lower one's height
BESIDE_FOOT = 0.5  # of a strip's lower height: so near to its foot is a wall without layers that goes on from its own
NEAR = 2.0  # heights between the feet of strips: farther away they are of different walls
OPEN = 0.3  # least distance of fronts around a bend, in terms of the shorter one's edges
CLOSED = 0.5  # of the way between their feet: fronts farther apart than that do not close around a bend
SHRUNK = 1 - 1e-6  # strips that have a side in common do not meet without their rims


@record
class Obstacles:
    """Walls as straight lines, and points of the domain, as seen from an origin.

    Far from that of the coordinates, rounding would count for more than what layers are shrunk by.
    """

    origin: Floats  # (2,)
    start: Floats  # (k, 2)
    end: Floats  # (k, 2): the start of a point
    layered: Booleans  # (k,): whether there are layers on it
    piece: Integers  # (k,): piece of the boundary, -1 for one with layers and for points

    @classmethod
    def of(cls, walls: Walls) -> "Obstacles":
        """Edges of walls with layers, chords of all other pieces, and embedded points."""
        boundary, layered = walls.domain.boundary, walls.pieces_with_layers
        chords = boundary.chords()
        bare = ~layered[chords.piece]
        edges = walls.ends[layered[walls.piece] & walls.forward]
        points = walls.x[complement(len(boundary.corners), walls.ends)]
        counts = len(edges), int(bare.sum()), len(points)
        origin = walls.x[walls.ends].mean(axis=(0, 1))
        return cls(
            origin,
            np.concatenate([walls.x[edges[:, 0]], chords.start[bare], points]) - origin,
            np.concatenate([walls.x[edges[:, 1]], chords.end[bare], points]) - origin,
            np.repeat([True, False, False], counts),
            np.concatenate([np.full(counts[0], -1), chords.piece[bare], np.full(counts[2], -1)]),
        )

    @cached_property
    def lines(self) -> Shapes:
        """Lines (k,) between starts and ends."""
        lines: Shapes = shapely.linestrings(np.stack([self.start, self.end], axis=1))
        points = (self.start == self.end).all(axis=1)
        lines[points] = shapely.points(self.start[points])  # a line of no length is near to nothing
        return lines

    @cached_property
    def tree(self) -> shapely.STRtree:
        """Tree of the lines."""
        return shapely.STRtree(self.lines)

    def seen(self, x: Floats) -> Floats:
        """Places x (..., 2) from the origin."""
        return x - self.origin

    def in_the_way(self, strips: Strips) -> Booleans:
        """Mask (c,) of the columns that have to be lower for all cells to be valid, and none to meet another."""
        columns = strips.columns
        wrong, full = badly_shaped(strips), np.flatnonzero(strips.full)
        i, j = columns.pair[full].T
        corner = self.seen(strips.x[np.column_stack([columns.foot[i], columns.foot[j], strips.top[j], strips.top[i]])])
        shapes = shapely.polygons(corner)
        valid = shapely.is_valid(shapes)
        wrong[full[~valid]] = True
        found = _StripOutlines.of(strips, full[valid], corner[valid], shapes[valid])
        wrong[found.pair[self._overlapping(found)]] = True
        wrong[found.pair[self._met_by(found)]] = True
        lower = np.zeros(len(columns), bool)
        lower[columns.pair[wrong]] = True
        return lower & (strips.heights.count > 0)

    def _met_by(self, found: "_StripOutlines") -> Integers:
        """Strips (m,) that meet an obstacle, or come too near to one."""
        near, by = self.tree.query(found.around)
        apart = self._is_apart(found, near, by)
        near, by = near[apart], by[apart]
        meeting = shapely.intersects(found.inner[near], self.lines[by])
        ends = np.stack([self.start, self.end], axis=1)
        joined = (found.feet[near][:, :, None] == ends[by][:, None, :]).all(axis=-1).any(axis=(1, 2))
        point = (self.start == self.end).all(axis=1)[by]
        one, near, by, point = near[meeting], *(column[point | ~joined] for column in (near, by, point))
        # What lies beside the foot of a strip is its own wall, or one that goes on from that.
        beside = np.where(self.layered[by], found.high[near], BESIDE_FOOT * found.low[near])
        away = shapely.distance(shapely.linestrings(found.feet)[near], self.lines[by]) > beside
        near, by = near[point | away], by[point | away]
        too_near = shapely.dwithin(found.shapes[near], self.lines[by], APART * found.high[near])
        return each_once(np.append(one, near[too_near]))

    def _is_apart(self, found: "_StripOutlines", one: Integers, line: Integers) -> Booleans:
        """Mask (m,) of strips ``one`` (m,) with no column that follows the piece of the line (m,) beside it."""
        columns = found.strips.columns
        follows = columns.follows[columns.pair[found.pair]][one]
        apart: Booleans = ~((follows == self.piece[line][:, None]) & (follows >= 0)).any(axis=1)
        return apart

    def _overlapping(self, found: "_StripOutlines") -> Integers:
        """Strips (m,) that overlap others, or come too near to them where no wall is between."""
        near, by = shapely.STRtree(found.shapes).query(found.around)
        columns = found.strips.columns
        middle = columns.at[columns.pair[found.pair]].mean(axis=1)
        way = np.hypot(*(middle[near] - middle[by]).T)
        away = way > NEAR * np.maximum(found.high[near], found.high[by])
        one, other = np.append(
            _too_near(found, near[away], by[away]), _closing(found, near[~away], by[~away], way[~away]), axis=1
        )
        facing = self._face_each_other(found.tops.mean(axis=1), one, other)
        return each_once(np.append(_crossing(found, near, by), one[facing]))

    def _face_each_other(self, tops: Floats, one: Integers, other: Integers) -> Booleans:
        """Mask (m,) of pairs of strips, by their tops' middles (f, 2), that have no wall between them."""
        ways = shapely.linestrings(np.stack([tops[one], tops[other]], axis=1))
        facing = np.ones(len(ways), bool)
        facing[self.tree.query(ways, predicate="crosses")[0]] = False
        return facing


@record
class _StripOutlines:
    """Outlines of strips, as seen from the origin of obstacles."""

    strips: Strips
    pair: Integers  # (f,): of columns beside each
    feet: Floats  # (f, 2, 2): of both columns
    tops: Floats  # (f, 2, 2): that of the second column, then that of the first one
    shapes: Shapes  # (f,)
    inner: Shapes  # (f,): the shapes without their rims
    around: Shapes  # (f,): boxes that hold all that may be too near to them
    high: Floats  # (f,): height of the higher column
    low: Floats  # (f,): of the lower one

    @classmethod
    def of(cls, strips: Strips, pair: Integers, corners: Floats, shapes: Shapes) -> "_StripOutlines":
        """Outlines of the strips of pairs (f,), with corners (f, 4, 2) and shapes (f,)."""
        middle = corners.mean(axis=1, keepdims=True)
        inner = shapely.polygons(middle + SHRUNK * (corners - middle))
        beside = strips.height[strips.columns.pair[pair]]
        high, low = largest_of_rows(beside), least_of_rows(beside)
        reach = (APART * high)[:, None]
        around = shapely.box(*(corners.min(axis=1) - reach).T, *(corners.max(axis=1) + reach).T)
        return cls(strips, pair, corners[:, :2], corners[:, 2:], shapes, inner, around, high, low)


def _crossing(found: _StripOutlines, one: Integers, other: Integers) -> Integers:
    """Those of strips (m,) that overlap the ``other`` ones (m,): all pairs are there in both directions."""
    once = one < other
    one, other = one[once], other[once]
    crossing = shapely.intersects(found.inner[one], found.inner[other])
    return np.append(one[crossing], other[crossing])


def _too_near(found: _StripOutlines, near: Integers, by: Integers) -> Integers:
    """Pairs (2, k), of strips ``near`` (m,) and others ``by`` (m,) them, whose feet are far apart but not they."""
    columns = found.strips.columns
    nodes = columns.foot[columns.owner[columns.pair[found.pair]]]
    apart = ~_have_in_common(nodes[near], nodes[by])
    near, by = near[apart], by[apart]
    least = APART * np.minimum(found.high[near], found.high[by])
    return np.stack([near, by])[:, shapely.distance(found.shapes[near], found.shapes[by]) < least]


def _closing(found: _StripOutlines, near: Integers, by: Integers, way: Floats) -> Integers:
    """Pairs (2, k), of strips ``near`` (m,) and others ``by`` (m,) them, around a bend that their fronts close.

    Fronts that come nearer to each other must leave room for triangles: nearer than on the ``way`` (m,) between where
    the columns start. On both sides of a short edge of a straight wall they are near to each other, but no more than
    the wall is there.
    """
    over, nodes = found.tops.mean(axis=1), found.strips.fronts[found.pair]
    nearer = (np.hypot(*(over[near] - over[by]).T) < way) & ~_have_in_common(nodes[near], nodes[by])
    near, by = near[nearer], by[nearer]
    edges, fronts = shapely.linestrings(found.feet), shapely.linestrings(found.tops)
    length = shapely.length(fronts)
    below, between = (shapely.distance(lines[near], lines[by]) for lines in (edges, fronts))
    closing = (between < OPEN * np.minimum(length[near], length[by])) & (between < CLOSED * below)
    near, by = near[closing], by[closing]
    return np.stack([near, by])[:, shapely.dwithin(found.shapes[near], found.shapes[by], APART * found.high[near])]


def _have_in_common(some: Integers, others: Integers) -> Booleans:
    """Mask (m,) of rows (m, 2) of numbers of which one is in the other row (m, 2)."""
    return any_of_rows((some[:, :, None] == others[:, None, :]).reshape(-1, 4))


def badly_shaped(strips: Strips) -> Booleans:
    """Mask (p,) of the pairs with a cell that is turned over, or nearly flat."""
    wrong = np.zeros(len(strips.columns.pair), bool)
    for cells, pair in (strips.quads, strips.triangles):
        corner = strips.x[cells]
        ahead = np.roll(corner, -1, axis=1) - corner
        before = np.roll(ahead, 1, axis=1)
        area = cross(before, ahead)
        if cells.shape[1] == 4:
            length = np.hypot(ahead[..., 0], ahead[..., 1])
            area -= FLAT_CELL * length * np.roll(length, 1, axis=1)
        wrong[pair[any_of_rows(area <= 0)]] = True
    return wrong
