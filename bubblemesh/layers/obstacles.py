"""Obstacles: what columns must not meet, and which of them do, or would spoil the cells between them."""

from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray

from bubblemesh.arrays import Booleans, Floats, Integers, complement, cross, each_once
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
        full, shapes, corner = full[valid], shapes[valid], corner[valid]
        middle = corner.mean(axis=1, keepdims=True)
        inner = shapely.polygons(middle + SHRUNK * (corner - middle))
        wrong[full[self._overlapping(strips, full, shapes, inner)]] = True
        wrong[full[self._met_by(strips, full, shapes, inner)]] = True
        found = np.zeros(len(columns), bool)
        found[columns.pair[wrong]] = True
        return found & (strips.heights.count > 0)

    def _met_by(self, strips: Strips, full: Integers, shapes: Shapes, inner: Shapes) -> Integers:
        """Strips (m,), among those of the pairs ``full`` (f,), that meet an obstacle, or come too near to one."""
        columns = strips.columns
        high, low = (function(strips.height[columns.pair[full]], axis=1) for function in (np.max, np.min))
        meeting = self.tree.query(inner, predicate="intersects")
        one = meeting[0, self._is_apart(strips, full, *meeting)]
        near, by = self.tree.query(shapes, predicate="dwithin", distance=APART * high)
        feet = self.seen(strips.x[columns.foot[columns.pair[full]]])
        ends = np.stack([self.start, self.end], axis=1)
        joined = (feet[near][:, :, None] == ends[by][:, None, :]).all(axis=-1).any(axis=(1, 2))
        # What lies beside the foot of a strip is its own wall, or one that goes on from that.
        beside = np.where(self.layered[by], high[near], BESIDE_FOOT * low[near])
        away = shapely.distance(shapely.linestrings(feet)[near], self.lines[by]) > beside
        point = (self.start == self.end).all(axis=1)[by]
        too_near = (point | away & ~joined) & self._is_apart(strips, full, near, by)
        return each_once(np.append(one, near[too_near]))

    def _is_apart(self, strips: Strips, full: Integers, one: Integers, line: Integers) -> Booleans:
        """Mask (m,) of strips ``one`` (m,) with no column that follows the piece of the line (m,) beside it."""
        follows = strips.columns.follows[strips.columns.pair[full]][one]
        apart: Booleans = ~((follows == self.piece[line][:, None]) & (follows >= 0)).any(axis=1)
        return apart

    def _overlapping(self, strips: Strips, full: Integers, shapes: Shapes, inner: Shapes) -> Integers:
        """Strips (m,), among those of the pairs ``full`` (f,), that overlap others, or come too near to them."""
        columns, tops = strips.columns, strips.fronts[full]
        ends = self.seen(strips.x[tops])
        one, other = shapely.STRtree(inner).query(inner, predicate="intersects")
        high = strips.height[columns.pair[full]].max(axis=1)
        middle = columns.at[columns.pair[full]].mean(axis=1)
        feet = columns.foot[columns.owner[columns.pair[full]]]
        edges = shapely.linestrings(self.seen(strips.x[columns.foot[columns.pair[full]]]))
        near, by = shapely.STRtree(shapes).query(shapes, predicate="dwithin", distance=APART * high)
        over = ends.mean(axis=1)
        facing = self._face_each_other(over, near, by)
        near, by = near[facing], by[facing]
        away = np.hypot(*(middle[near] - middle[by]).T) > NEAR * np.maximum(high[near], high[by])
        apart = ~(feet[near][:, :, None] == feet[by][:, None, :]).any(axis=(1, 2))
        far, beyond = near[away & apart], by[away & apart]
        too_near = shapely.distance(shapes[far], shapes[beyond]) < APART * np.minimum(high[far], high[beyond])
        # Around a bend of one wall fronts that come nearer to each other must leave room for triangles. On both sides
        # of a short edge of a straight wall they are near to each other, but no more than the wall is there.
        fronts = shapely.linestrings(ends)
        length = shapely.length(fronts)
        near, by = near[~away], by[~away]
        apart = ~(tops[near][:, :, None] == tops[by][:, None, :]).any(axis=(1, 2))
        nearer = np.hypot(*(over[near] - over[by]).T) < np.hypot(*(middle[near] - middle[by]).T)
        near, by = near[apart & nearer], by[apart & nearer]
        between, below = (shapely.distance(lines[near], lines[by]) for lines in (fronts, edges))
        closing = (between < OPEN * np.minimum(length[near], length[by])) & (between < CLOSED * below)
        return each_once(np.concatenate([one[one != other], far[too_near], near[closing]]))

    def _face_each_other(self, tops: Floats, one: Integers, other: Integers) -> Booleans:
        """Mask (m,) of pairs of different strips, by their tops' middles (f, 2), that have no wall between them."""
        facing = one != other
        ways = shapely.linestrings(np.stack([tops[one[facing]], tops[other[facing]]], axis=1))
        crossing = np.zeros(len(ways), bool)
        crossing[self.tree.query(ways, predicate="crosses")[0]] = True
        facing[facing] = ~crossing
        return facing


def badly_shaped(strips: Strips) -> Booleans:
    """Mask (p,) of the pairs with a cell that is turned over, or nearly flat."""
    wrong = np.zeros(len(strips.columns.pair), bool)
    for cells, pair in (strips.quads, strips.triangles):
        corner = strips.x[cells]
        ahead, back = np.roll(corner, -1, axis=1) - corner, np.roll(corner, 1, axis=1) - corner
        area = cross(ahead, back)
        if cells.shape[1] == 4:
            area = area - FLAT_CELL * np.hypot(*np.moveaxis(ahead, -1, 0)) * np.hypot(*np.moveaxis(back, -1, 0))
        wrong[pair[(area <= 0).any(axis=1)]] = True
    return wrong
