"""Where columns stand: one at each node of a wall with layers, several around corners, others where layers end."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, turned_left
from bubblemesh.layers.columns import Columns
from bubblemesh.layers.directions import HIGHEST_STRETCH, blended, fan, on_curves
from bubblemesh.layers.ladder import Ladder
from bubblemesh.layers.pinches import SHORT, parting, pinched
from bubblemesh.layers.small_features import small_steps
from bubblemesh.layers.walls import Walls, rotated

ROUGH = np.radians(20)  # between edges on a curve: columns go by these where they are that coarse
END_ROUNDING = 1e-6  # angles that are drawn as just these are among them
STEEPEST_END = np.radians(45) - END_ROUNDING  # between a wall with layers and one that its last column follows
FLATTEST_END = np.radians(135) + END_ROUNDING


class _Row(NamedTuple):
    """A column, with the names and kinds of the columns of `Columns`."""

    foot: int
    up: Floats
    ladder: int
    follows: int = -1
    from_start: bool = False
    ends: bool = False


class _ColumnTable(NamedTuple):
    """Rows of columns as arrays, with the names and kinds of those of `Columns`."""

    foot: Integers
    up: Floats
    ladder: Integers
    follows: Integers
    from_start: Booleans
    ends: Booleans


class _ColumnBuilder:
    """Columns as they are found, at one end of a side after the other."""

    def __init__(self, walls: Walls, ladders: Sequence[Ladder]) -> None:
        self.walls = walls
        self.ladders = ladders
        self.along = walls.directions
        self.layered, self.pieces_with_layers = walls.layered, walls.pieces_with_layers
        self.normals = turned_left(self.along)
        self.middles = list(_middles(walls, self.along))
        self.lower = _lower(walls, ladders).tolist()
        self.feet = walls.ends[:, 1].tolist()
        self.steps = small_steps(walls, ladders)
        self.rows = list[_Row]()
        # Column at the beginning and at the end of each side, and those of each fan, with the side before it.
        self.first, self.last = (np.full(len(walls.piece), -1) for _ in range(2))
        self.fans = list[tuple[int, list[int]]]()
        self.followed = dict[tuple[int, bool], int]()

    def add(self, foot: int, up: Floats, ladder: int, ends: bool = False) -> int:
        """Number of a new column, which goes ``up`` (2,) by so much for each unit of height."""
        self.rows.append(_Row(foot, up, ladder, ends=ends))
        return len(self.rows) - 1

    def between_layers(self, side: int, after: int) -> None:
        """Find the columns between a side with layers and the one ``after`` it, which has some too.

        Of two kinds of layers they have those with the lower first height, which would be too high beside the others.
        """
        angle, foot, ladder = float(self.walls.angle[side]), self.feet[side], self.lower[side]
        is_corner, d = bool(self.walls.node_piece[foot] < 0), float(self.walls.d[foot])
        plain = side in self.steps
        ways = None if plain else fan(self.ladders[ladder], self.normals[side], angle, d, is_corner=is_corner)
        around = [self.add(foot, up, ladder) for up in ([self.middles[side]] if ways is None else ways)]
        self.last[side], self.first[after] = around[0], around[-1]
        if len(around) > 1:
            self.fans.append((side, around))

    def at_end(self, side: int, after: int) -> None:
        """Find the column between a side and the one ``after`` it, of which only one has layers."""
        walls, layers_first = self.walls, bool(self.layered[side])
        mine, bare = (side, after) if layers_first else (after, side)
        angle = float(walls.angle[side])
        foot = int(walls.ends[side, 1])
        ladder = int(walls.ladder[mine])
        taken = bool(self.pieces_with_layers[walls.piece[bare]])  # by nodes for layers on its other side
        if self.ladders[ladder].follow and STEEPEST_END <= angle <= FLATTEST_END and not taken:
            up = (self.along[bare] if layers_first else -self.along[bare]) / np.sin(angle)
            column = self._following(bare, bool(walls.forward[bare]) == layers_first, foot, up, ladder)
        else:
            column = self.add(foot, self.normals[mine], ladder, ends=True)
        (self.last if layers_first else self.first)[mine] = column

    def _following(self, side: int, from_start: bool, foot: int, up: Floats, ladder: int) -> int:
        """Number of the column along a wall without layers, which the other side of that wall may have found before.

        Of two kinds of layers it has those with the lower first height. Above walls that meet that piece at two angles
        it goes by the lower one of both heights.
        """
        piece = int(self.walls.piece[side])
        known = self.followed.setdefault((piece, from_start), len(self.rows))
        if known == len(self.rows):
            self.rows.append(_Row(foot, up, ladder, piece, from_start))
        else:
            before = self.rows[known]
            lower = min(before.ladder, ladder, key=lambda number: self.ladders[number].first)
            shorter = min(before.up, up, key=lambda way: float(np.hypot(*way)))
            self.rows[known] = before._replace(up=shorter, ladder=lower)
        return known

    def join_fans(self) -> None:
        """Let columns part evenly where there are fans at both ends of edges that are short beside the first layer.

        As of small chamfers and fillets: the columns above such an edge would go up side by side, however high.
        """
        fans, following = dict(self.fans), self.walls.following
        first = {side: self.ladders[self.rows[around[-1]].ladder].first for side, around in fans.items()}
        length = np.hypot(*(self.walls.x[self.walls.ends[:, 1]] - self.walls.x[self.walls.ends[:, 0]]).T)
        joined = {int(following[side]) for side in fans if length[following[side]] < SHORT * first[side]}
        joined &= fans.keys()
        for side in fans.keys() - joined:
            chain = [side]
            while (after := int(following[chain[-1]])) in joined:
                chain.append(after)
            columns = [column for one in chain for column in fans[one]]
            share = np.arange(len(columns)) / (len(columns) - 1)
            turn = (self.walls.angle[chain] - np.pi).sum()
            for column, up in zip(columns, rotated(self.normals[side][None], -turn * share), strict=True):
                self.rows[column] = self.rows[column]._replace(up=up)

    def pairs(self) -> tuple[Integers, Integers]:
        """Pairs (p, 2) of columns with cells between, first those on sides, then those in fans, and the sides (p,)."""
        sides = np.flatnonzero(self.layered)
        beside = [(side, *pair) for side, around in self.fans for pair in pairwise(around)]
        of_fan, one, other = np.array(beside, np.int64).reshape(-1, 3).T
        on_sides = np.column_stack([self.first[sides], self.last[sides]])
        return np.concatenate([on_sides, np.column_stack([one, other])]), np.append(sides, of_fan)

    def table(self) -> _ColumnTable:
        """All rows so far."""
        return _ColumnTable(*(np.array(column) for column in zip(*self.rows, strict=True)))

    def turns(self) -> Floats:
        """Largest angle (c,) by which the wall turns at the feet of columns."""
        turn = np.zeros(len(self.walls.x))
        np.maximum.at(turn, self.walls.ends[:, 1], np.abs(self.walls.angle - np.pi))
        return turn[[row.foot for row in self.rows]]

    def twins(self) -> Integers:
        """Columns (k, 2) that match across the domain; one without a counterpart gets no layers."""
        found = list[tuple[int, int]]()
        for a, b in self.walls.domain.periodic.tolist():
            for from_start in (True, False):
                one, other = self.followed.get((a, from_start)), self.followed.get((b, not from_start))
                if one is not None and other is not None:
                    self._alike(one, other)
                    found.append((one, other))
                    continue
                for lonely in (one, other):
                    if lonely is not None:
                        self.rows[lonely] = self.rows[lonely]._replace(ends=True)
        return np.array(found, np.int64).reshape(-1, 2)

    def _alike(self, one: int, other: int) -> None:
        """Let two columns go up by the same, whatever the walls beside them."""
        rows = self.rows[one], self.rows[other]
        ways = [float(np.hypot(*row.up)) for row in rows]
        for number, row, way in zip((one, other), rows, ways, strict=True):
            self.rows[number] = row._replace(up=row.up * (min(ways) / way), ladder=rows[0].ladder)


def _middles(walls: Walls, along: Floats) -> Floats:
    """Ways (m, 2) up in the middle between each side and the following one, for each unit of height above both.

    Sides go ``along`` unit vectors (m, 2).
    """
    half = walls.angle / 2
    middle = rotated(along[walls.following], half)
    return middle * np.minimum(1 / np.sin(half), HIGHEST_STRETCH)[:, None]


def _lower(walls: Walls, ladders: Sequence[Ladder]) -> Integers:
    """Layers (m,) of the lower first height on each side and the following one."""
    first, here = np.array([ladder.first for ladder in ladders]), walls.ladder
    there = here[walls.following]
    return np.where(first[there] < first[here], there, here)


def columns_on(walls: Walls, ladders: Sequence[Ladder]) -> Columns:
    """Columns on all walls with layers: one at each node, several around convex corners."""
    made, layered = _ColumnBuilder(walls, ladders), walls.layered
    for side in np.flatnonzero(layered | layered[walls.following]).tolist():
        after = int(walls.following[side])
        if layered[side] and layered[after]:
            made.between_layers(side, after)
        else:
            made.at_end(side, after)
    made.join_fans()
    pair, side_of_pair = made.pairs()
    twins = made.twins()
    table = made.table()
    foot, itself = table.foot, np.arange(len(table.foot))
    columns = Columns(
        tuple(ladders),
        foot=foot,
        start=walls.x[foot],
        at=walls.x[foot],
        foot_up=table.up,
        up=table.up,
        bend=np.ones(len(foot)),
        ladder=table.ladder,
        follows=table.follows,
        from_start=table.from_start,
        ends=table.ends,
        spacing=walls.d[foot],
        pair=pair,
        side=side_of_pair,
        fan=np.arange(len(pair)) >= layered.sum(),
        twins=twins,
        owner=itself,
        joined=np.zeros(len(foot), np.int64),
        leader=itself,
        pinch=np.zeros(len(pair), bool),
    )
    free = (columns.follows < 0) & ~columns.ends
    free[[column for _, around in made.fans for column in around]] = False
    columns = pinched(columns, walls, free)
    free &= ~(columns.are_pinched | parting(columns, walls))
    on_curve = free & (walls.node_piece[foot] >= 0) & (made.turns() < ROUGH)
    columns, smooth = on_curves(columns, walls, on_curve, made.turns())
    return blended(columns, free, smooth, made.normals)
