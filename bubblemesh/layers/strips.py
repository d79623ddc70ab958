"""Strips: the cells between neighbouring columns."""

from functools import cached_property
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import TINY, Booleans, Floats, Integers, members
from bubblemesh.layers.columns import Columns
from bubblemesh.layers.heights import Heights, column_nodes, gradual, reached
from bubblemesh.layers.walls import Walls
from bubblemesh.meshes.quads import corner_angles
from bubblemesh.records import record
from bubblemesh.spacing.rules.sources import Sources

WIDEST_HALVED = np.radians(145)  # largest angle of a triangle that is halved
FLAT_CORNER = np.radians(170)  # largest angle of a quadrilateral that is one in files
LOW_FAN = 0.2  # of the spacing at its foot: shorter edges of a fan's front have the edges of the wall grow from there


class LayerCells(NamedTuple):
    """Cells of layers as triangles: the first 2 q are those of quadrilaterals, row k and row q + k of one."""

    triangles: Integers  # (t, 3): counter-clockwise
    diagonals: Integers  # (q, 2): edges between two triangles that are one quadrilateral
    pair: Integers  # (t,): pair of columns of each triangle; the first q are the quadrilaterals' first halves


@record
class Strips:
    """Cells between all pairs of columns, with the nodes of the walls first and those of the columns after them."""

    columns: Columns
    walls: Walls
    heights: Heights
    x: Floats  # (n, 2): all nodes
    first: Integers  # (c + 1,): number of the lowest node of each column above its foot

    @classmethod
    def of(cls, columns: Columns, walls: Walls, found: Heights) -> "Strips":
        """Strips of columns that are so high."""
        x = column_nodes(columns, walls, found)
        first = np.append(0, np.cumsum(columns.own(found.count)))
        return cls(columns, walls, found, np.vstack([walls.x, x]), first + len(walls.x))

    def node(self, column: Integers, level: Integers) -> Integers:
        """Numbers (k,) of nodes on columns (k,), from level 0 at the foot up."""
        owner = np.where(level < self.columns.joined[column], column, self.columns.owner[column])
        return np.where(level == 0, self.columns.foot[column], self.first[owner] + level - 1)

    @property
    def levels(self) -> Integers:
        """Number (n,) of the layer below each node, 0 for those of walls."""
        return np.append(np.zeros(len(self.walls.x), np.int64), members(self.columns.own(self.heights.count))[1] + 1)

    @property
    def top(self) -> Integers:
        """Number (c,) of the highest node of each column."""
        return self.node(np.arange(len(self.columns)), self.heights.count)

    @property
    def quads(self) -> tuple[Integers, Integers]:
        """Cells (q, 4) with four nodes, counter-clockwise from the wall on, and the pair (q,) that each is between."""
        pair, level, foot = self._levels
        i, j = self.columns.pair[pair[~foot]].T
        k = level[~foot]
        corners = [self.node(i, k), self.node(j, k), self.node(j, k + 1), self.node(i, k + 1)]
        return np.column_stack(corners), pair[~foot]

    @property
    def triangles(self) -> tuple[Integers, Integers]:
        """Cells (t, 3) with three nodes: at fans' feet, below shared nodes, beside last layers of higher columns."""
        pair, level, foot = self._levels
        i, j = self.columns.pair[pair[foot]].T
        k = level[foot]
        at_feet = np.column_stack([self.columns.foot[i], self.node(j, k + 1), self.node(i, k + 1)])
        steps = np.flatnonzero(self.stepped)
        i, j = self.columns.pair[steps].T
        ci, cj = self.heights.count[[i, j]]
        low, higher = np.minimum(ci, cj), np.where(ci > cj, i, j)
        closing = np.column_stack([self.node(i, low), self.node(j, low), self.node(higher, low + 1)])
        joined = self.columns.joined_pairs
        pinched = np.flatnonzero(self.columns.pinch & (self.heights.count[self.columns.pair[:, 0]] >= joined))
        i, j = self.columns.pair[pinched].T
        k = joined[pinched]
        below = np.column_stack([self.node(i, k - 1), self.node(j, k - 1), self.node(i, k)])
        return np.vstack([at_feet, closing, below]), np.concatenate([pair[foot], steps, pinched])

    @property
    def stepped(self) -> Booleans:
        """Mask (p,) of the pairs whose columns differ in height, and are joined by a triangle at their tops."""
        ci, cj = self.heights.count[self.columns.pair].T
        return (ci != cj) & (~self.columns.fan | (np.minimum(ci, cj) > 0))

    @property
    def flat_steps(self) -> Booleans:
        """Mask (p,) of these that are so flat that a node in the middle of the front's edge has an angle near 180."""
        i, j = self.columns.pair.T
        ci, cj = self.heights.count[[i, j]]
        below = self.x[self.node(np.where(ci > cj, i, j), np.minimum(ci, cj))]
        first, last = np.moveaxis(self.x[self.fronts], 1, 0)
        along, down = last - first, below - (first + last) / 2
        cosine = np.abs((along * down).sum(axis=1)) / np.maximum(np.hypot(*along.T) * np.hypot(*down.T), TINY)
        return self.stepped & (cosine > -np.cos(WIDEST_HALVED))

    @property
    def low_fans(self) -> Sources:
        """Feet of fans whose edges on the front are far shorter than those beside, and the lengths of these edges.

        If the wall had no nodes for triangles that grow from there, these would divide the last cells into flat ones.
        """
        fans = np.flatnonzero(self.columns.fan & self.full)
        foot = self.columns.pair[fans, 0]
        length = np.hypot(*np.diff(self.x[self.fronts[fans]], axis=1)[:, 0].T)
        # Layers of a given number that end early for lack of room would have less of it if the wall had more nodes.
        complete = self.columns.are_isotropic | (self.heights.count >= self._due)
        low = complete[foot] & (length < LOW_FAN * self.columns.spacing[foot])
        return Sources(self.columns.start[foot[low]], length[low])

    @property
    def _due(self) -> Integers:
        """Number (c,) of layers that are asked for, or fewer where other layers on the wall beside have few."""
        columns, heights = self.columns, self.heights
        due = np.zeros(len(columns), np.int64)
        for number in range(len(columns.ladders)):
            mine = columns.ladder == number
            due[mine] = gradual(columns, np.where(mine, heights.requested, heights.most.count))[mine]
        return due

    @property
    def _levels(self) -> tuple[Integers, Integers, Booleans]:
        """Pair and level (m,) of all cells up to the lower one of two columns, and whether they are at a fan's foot."""
        both = self.heights.count[self.columns.pair].min(axis=1)
        pair, level = members(np.where(self.columns.pinch, np.minimum(both, self.columns.joined_pairs - 1), both))
        return pair, level, (level == 0) & self.columns.fan[pair]

    @property
    def fronts(self) -> Integers:
        """Edges (p, 2) along the tops, with the rest of the domain on the left; on walls where there are no layers."""
        return self.top[self.columns.pair]

    @property
    def full(self) -> Booleans:
        """Mask (p,) of the pairs with a cell between them at least."""
        count = self.heights.count[self.columns.pair]
        return np.where(self.columns.fan, count.min(axis=1) > 0, count.max(axis=1) > 0)

    @property
    def reached(self) -> Floats:
        """Height (c,) of each column above the wall."""
        return reached(self.columns, self.heights, np.arange(len(self.columns)), self.heights.count)

    @property
    def height(self) -> Floats:
        """Length (c,) of each column."""
        return np.hypot(*(self.x[self.top] - self.columns.start).T)

    @cached_property
    def cells(self) -> "LayerCells":
        """All cells as triangles."""
        corners, pair = self.quads
        first = self._split_from_first(self.x[corners])
        a, b, c, d = np.where(first[:, None], corners, np.roll(corners, -1, axis=1)).T
        three, pair_of_three = self.triangles
        return LayerCells(
            np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d]), three]),
            np.column_stack([a, c]),
            np.concatenate([pair, pair, pair_of_three]),
        )

    @property
    def are_quads(self) -> Booleans:
        """Mask (q,) of the cells with four nodes that stay quadrilaterals in files.

        The map of one with an angle near 180 degrees is nearly singular at that corner, unlike those of its halves.
        """
        corners, pair = self.quads
        stay = np.array([ladder.quads for ladder in self.columns.ladders])[self.walls.ladder[self.columns.side[pair]]]
        stay[stay] = corner_angles(self.x[corners[stay]]).max(axis=1, initial=0.0) <= FLAT_CORNER
        return stay

    @property
    def curved(self) -> tuple[Integers, Floats]:
        """Edges (k, 2) along curved walls above these, and points (k, 2) halfway along the offsets of the curves.

        They bulge as the wall does, in terms of their lengths, and so do the diagonals of cells between them.
        """
        columns, walls = self.columns, self.walls
        ends = self.columns.start[columns.pair]
        bulge = np.where(columns.with_first_cells[:, None], walls.middles[columns.side] - ends.mean(axis=1), 0.0)
        curved = (bulge != 0).any(axis=1)

        pair, level, _ = self._levels
        pair, level = pair[curved[pair]], level[curved[pair]] + 1
        i, j = columns.pair[pair].T
        along = np.column_stack([self.node(i, level), self.node(j, level)])
        cells = self.cells
        of_quad = cells.pair[: len(cells.diagonals)]
        mine = curved[of_quad]
        across, beside = cells.diagonals[mine], of_quad[mine]
        steps = np.flatnonzero(curved & (np.diff(self.heights.count[columns.pair], axis=1)[:, 0] != 0))
        edges = np.concatenate([along, across, self.fronts[steps]])
        owner = np.concatenate([pair, beside, steps])
        span = self.x[edges]
        base = ends[owner, 1] - ends[owner, 0]
        share = ((span[:, 1] - span[:, 0]) * base).sum(axis=1) / (base * base).sum(axis=1)
        return edges, span.mean(axis=1) + np.abs(share)[:, None] * bulge[owner]

    @staticmethod
    def _split_from_first(corner: Floats) -> Booleans:
        """Whether the diagonal (q,) from the first of four corners (q, 4, 2) makes the largest angle least."""
        angle = corner_angles(corner)
        # A diagonal halves the angles at its ends; of the two others the larger one stays.
        first: Booleans = np.maximum(angle[:, 1], angle[:, 3]) <= np.maximum(angle[:, 0], angle[:, 2])
        return first
