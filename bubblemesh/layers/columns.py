"""Columns: where they stand, and in which directions they go up from the wall."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.layers.ladder import Ladder
from bubblemesh.layers.walls import Walls, left_of, turned
from bubblemesh.records import record

FAN = np.radians(40)  # beyond a straight angle: sharper convex corners have a fan
TIP = np.radians(120)  # the same: around tips and trailing edges one column would leave cells flat
WIDEST = np.radians(30)  # between neighbours in a fan
NARROWEST = np.radians(10)  # the same where the fan is so high that it would become coarse
ROUGH = np.radians(20)  # between edges on a curve: columns go by these where they are that coarse
STRAY = np.radians(2)  # more than half of that angle, from what is between the edges to a curve's normal that is told
STEEPEST_END = np.radians(45)  # between a wall with layers and one that its last column follows
FLATTEST_END = np.radians(135)
HIGHEST_STRETCH = 4.0
BLENDINGS = 20  # passes
BEND = 0.5  # of the shorter edge beside a column: the height within which it bends
SEEN = 0.4  # least cosine between a blended column and the normals beside it


@record
class Columns:
    """Columns of layers, before their heights are known, and the pairs of them that have cells between.

    A column goes up in a straight line, but for a bend at its foot, or along a piece of the boundary without layers.
    """

    ladders: tuple[Ladder, ...]
    foot: Integers  # (c,): node of the wall
    at: Floats  # (c, 2): its place
    foot_up: Floats  # (c, 2): way at the foot over height above the wall
    up: Floats  # (c, 2): the same above the bend
    bend: Floats  # (c,): height above the first layer within which it bends
    ladder: Integers  # (c,)
    follows: Integers  # (c,): piece that the column follows, -1 for none
    from_start: Booleans  # (c,): whether it follows the piece from its start, rather than from its end
    ends: Booleans  # (c,): whether there is no layer at the foot, since the wall beside it has none
    spacing: Floats  # (c,): at the foot
    pair: Integers  # (p, 2): columns with cells between, the wall being on the right of the way from one to the other
    side: Integers  # (p,): of the wall between their feet, or before a fan
    fan: Booleans  # (p,): whether both stand on one node
    twins: Integers  # (k, 2): columns on periodic sides that match

    def __len__(self) -> int:
        return len(self.foot)

    def places(self, which: Integers, height: Floats) -> Floats:
        """Places (k, 2) on columns (k,) at heights (k,) above the wall, if they follow no piece."""
        first = np.array([ladder.first for ladder in self.ladders])[self.ladder[which]]
        bent = np.clip((height - first) / self.bend[which], 0, 1)[:, None]
        return self.at[which] + height[:, None] * ((1 - bent) * self.foot_up[which] + bent * self.up[which])

    @property
    def thickness(self) -> Floats:
        """Height (c,) of all layers that are asked for, and no higher than the spacing at the foot."""
        return np.array([ladder.thickness_below(self.spacing) for ladder in self.ladders])[
            self.ladder, np.arange(len(self))
        ]

    @property
    def wanted(self) -> Integers:
        """Number (c,) of layers that are asked for."""
        return np.array([ladder.count for ladder in self.ladders])[self.ladder]

    def tops(self, which: Integers, count: Integers) -> Floats:
        """Height (k,) of so many layers (k,) on columns (k,), as they are asked for."""
        return self._tops[self.ladder[which], count]

    @cached_property
    def _tops(self) -> Floats:
        table = np.zeros((len(self.ladders), 1 + max(ladder.count for ladder in self.ladders)))
        for number, ladder in enumerate(self.ladders):
            table[number, : ladder.count + 1] = ladder.tops
        return table

    @property
    def bare_widths(self) -> Floats:
        """Distances (p,) between the feet of pairs."""
        return np.hypot(*(self.at[self.pair[:, 1]] - self.at[self.pair[:, 0]]).T)

    def least_of_pairs(self, values: Floats) -> Floats:
        """Least (c,) of the values (p,) of the pairs that each column belongs to; infinite for one in none."""
        least = np.full(len(self), np.inf)
        for end in self.pair.T:
            np.minimum.at(least, end, values)
        return least


class _Row(NamedTuple):
    """A column, with the names and kinds of the columns of `Columns`."""

    foot: int
    up: Floats
    ladder: int
    follows: int = -1
    from_start: bool = False
    ends: bool = False


class _Builder:
    """Columns as they are found, at one end of a side after the other."""

    def __init__(self, walls: Walls, ladders: Sequence[Ladder]) -> None:
        self.walls, self.ladders, self.along = walls, ladders, walls.directions
        self.normals = left_of(self.along)
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
        angle, foot = float(self.walls.angle[side]), int(self.walls.ends[side, 1])
        ladder = min(map(int, self.walls.ladder[[side, after]]), key=lambda number: self.ladders[number].first)
        asked, is_corner = self.ladders[ladder], bool(self.walls.node_piece[foot] < 0)
        fan = _fan(asked, self.normals[side], angle, float(self.walls.d[foot]), is_corner=is_corner)
        if fan is None:
            middle = turned(self.along[after : after + 1], np.array([angle / 2]))[0]
            fan = middle[None] * min(1 / np.sin(angle / 2), HIGHEST_STRETCH)
        around = [self.add(foot, up, ladder) for up in fan]
        self.last[side], self.first[after] = around[0], around[-1]
        if len(around) > 1:
            self.fans.append((side, around))

    def at_end(self, side: int, after: int) -> None:
        """Find the column between a side and the one ``after`` it, of which only one has layers."""
        walls, layers_first = self.walls, bool(self.walls.layered[side])
        mine, bare = (side, after) if layers_first else (after, side)
        angle, foot, ladder = float(walls.angle[side]), int(walls.ends[side, 1]), int(walls.ladder[mine])
        if self.ladders[ladder].follow and STEEPEST_END <= angle <= FLATTEST_END:
            up = (self.along[bare] if layers_first else -self.along[bare]) / np.sin(angle)
            column = self._following(bare, bool(walls.forward[bare]) == layers_first, foot, up, ladder)
        else:
            column = self.add(foot, self.normals[mine], ladder, ends=True)
        (self.last if layers_first else self.first)[mine] = column

    def _following(self, side: int, from_start: bool, foot: int, up: Floats, ladder: int) -> int:
        """Number of the column along a wall without layers, which the other side of that wall may have found before."""
        piece = int(self.walls.piece[side])
        known = self.followed.setdefault((piece, from_start), len(self.rows))
        if known == len(self.rows):
            self.rows.append(_Row(foot, up, ladder, piece, from_start))
        else:
            self.rows[known] = self.rows[known]._replace(up=(self.rows[known].up + up) / 2)
        return known

    def pairs(self) -> tuple[Integers, Integers]:
        """Pairs (p, 2) of columns with cells between, first those on sides, then those in fans, and the sides (p,)."""
        sides = np.flatnonzero(self.walls.layered)
        beside = [(side, *pair) for side, around in self.fans for pair in pairwise(around)]
        of_fan, one, other = np.array(beside, np.int64).reshape(-1, 3).T
        on_sides = np.column_stack([self.first[sides], self.last[sides]])
        return np.concatenate([on_sides, np.column_stack([one, other])]), np.append(sides, of_fan)

    def arrays(self) -> tuple[Any, ...]:
        """The columns of the table."""
        return tuple(np.array(column) for column in zip(*self.rows, strict=True))

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
            self.rows[number] = row._replace(up=row.up * (sum(ways) / (2 * way)), ladder=rows[0].ladder)


def columns_on(walls: Walls, ladders: Sequence[Ladder]) -> Columns:
    """Columns on all walls with layers: one at each node, several around convex corners."""
    made, layered = _Builder(walls, ladders), walls.layered
    for side in np.flatnonzero(layered | layered[walls.following]).tolist():
        after = int(walls.following[side])
        if layered[side] and layered[after]:
            made.between_layers(side, after)
        else:
            made.at_end(side, after)
    pair, side_of_pair = made.pairs()
    twins = made.twins()
    foot, up, asked, follows, from_start, ends = made.arrays()
    columns = Columns(
        tuple(ladders),
        foot,
        walls.x[foot],
        up,
        up,
        np.ones(len(foot)),
        asked,
        follows,
        from_start,
        ends,
        walls.d[foot],
        pair,
        side_of_pair,
        np.arange(len(pair)) >= layered.sum(),
        twins,
    )
    free = (columns.follows < 0) & ~columns.ends
    free[[column for _, around in made.fans for column in around]] = False
    on_curve = free & (walls.node_piece[foot] >= 0) & (made.turns() < ROUGH)
    columns, smooth = _on_curves(columns, walls, on_curve, made.turns())
    return _blended(columns, free, smooth, made.normals)


def _fan(ladder: Ladder, normal: Floats, angle: float, spacing: float, *, is_corner: bool) -> Floats | None:
    """Directions (k, 2) of the columns around a convex bend, from the wall before it on; None if it has no fan.

    A curve, which is bent since its nodes are far apart, has none where it is no tip.
    """
    turn = angle - np.pi
    if turn <= FAN or not ((ladder.fans and is_corner) or turn > TIP):
        return None
    wanted = turn * float(ladder.thickness_below(np.array(spacing))) / spacing
    steps = int(np.clip(np.ceil(wanted), np.ceil(turn / WIDEST), np.ceil(turn / NARROWEST)))
    return turned(np.tile(normal, (steps + 1, 1)), -turn * np.arange(steps + 1) / steps)


def _on_curves(columns: Columns, walls: Walls, on_curve: Booleans, turns: Floats) -> tuple[Columns, Booleans]:
    """The columns with the normals of the true curves as the directions of those that stand on smooth walls.

    Of those ``on_curve`` (c,), where edges turn by some angle (c,), these are the ones (c,) with a normal about halfway
    between the edges: along a wall that is rough between its nodes the normal at a node says nothing.
    """
    mine = np.flatnonzero(on_curve)
    node, before = columns.foot[mine], _unit(columns.up[mine])
    normal = left_of(walls.domain.boundary.tangents(walls.node_piece[node], walls.node_s[node]))
    cosine = (normal * before).sum(axis=1)
    told = np.abs(cosine) >= np.cos(turns[mine] / 2 + STRAY)
    mine, normal = mine[told], np.sign(cosine[told])[:, None] * normal[told]
    up, smooth = columns.up.copy(), np.zeros(len(columns), bool)
    up[mine], smooth[mine] = normal, True
    return replace(columns, foot_up=up, up=up), smooth


def _blended(columns: Columns, free: Booleans, smooth: Booleans, normals: Floats) -> Columns:
    """The columns with directions that change gradually along the wall, where layers are thick beside its edges.

    They turn from the direction at the foot above the first layer, so that its height is the wanted one. Heights are
    those above the edges beside a column, or the curve that it stands on, if that is ``smooth``.
    """
    (i, j), normal = columns.pair[~columns.fan].T, normals[columns.side[~columns.fan]]
    width = columns.bare_widths[~columns.fan]
    edge = columns.least_of_pairs(np.where(columns.fan, np.inf, columns.bare_widths))
    rate = np.where(free, 0.5 * np.clip(columns.thickness / edge - 0.25, 0, 1), 0.0)[:, None]
    if not (rate > 0).any():
        return columns
    start = direction = _unit(columns.up)
    for _ in range(BLENDINGS):
        total = np.zeros_like(direction)
        np.add.at(total, i, direction[j] / width[:, None])
        np.add.at(total, j, direction[i] / width[:, None])
        direction = _unit(direction + rate * (_unit(total) - direction))
    least, total, walls = np.ones(len(columns)), np.zeros(len(columns)), np.zeros(len(columns))
    for end in (i, j):
        cosine = (normal * direction[end]).sum(axis=1)
        np.minimum.at(least, end, cosine)
        np.add.at(total, end, cosine)
        np.add.at(walls, end, 1)
    mean = np.where(smooth, (direction * start).sum(axis=1), total / np.maximum(walls, 1))
    turned_away = free & (least >= SEEN)
    up = direction / np.clip(mean, 1 / HIGHEST_STRETCH, 1.0)[:, None]
    return replace(columns, up=np.where(turned_away[:, None], up, columns.up), bend=BEND * edge)


def _unit(vectors: Floats) -> Floats:
    """Vectors (n, 2) of length 1, but for those of length 0."""
    return np.asarray(vectors / np.maximum(np.hypot(*vectors.T), 1e-300)[:, None])
