"""Pinches: at bends of edges that are short beside the first layer several columns are one.

They are the counterpart of fans: one column stands on several nodes of the wall, as where chamfers and fillets of a
drawing round a concave corner off. Where these are larger, each node has a column of its own for the first layers, and
these become one before they would meet. So do columns beside each other on a straight wall, where layers become higher
than the edge between them is long.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import NamedTuple, Self

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, components, turned_left
from bubblemesh.layers.columns import Columns
from bubblemesh.layers.small_features import LEAST_TURN, clear_of, middle_way, plain_edges, turn_between
from bubblemesh.layers.walls import Walls

SHORT = 3.0  # edges, in terms of the first layer: on longer ones some layers are no higher than wide
ROUND = 1.3  # first layers: fillets of a smaller radius are as corners
FARTHEST = 5.0  # lengths of a bend to where the walls beside it would meet
LOW_MEETING = 3.0  # first layers: columns that meet below are one
CLEAR = 0.2  # of a layer: least height of its top above the edges of a bend
SLENDER = 0.1  # of the height of a layer: least mean width of its cells below where columns become one


class _Bend(NamedTuple):
    """Columns (k,) on edges ``inside`` (p,) a bend of a wall, between the sides ``before`` and ``after`` it."""

    columns: Integers
    inside: Booleans
    before: int
    after: int


class _One(NamedTuple):
    """The column that those at a bend become: it goes ``up`` (2,) from a place (2,), from a layer with a number on."""

    at: Floats
    up: Floats
    layer: int


def pinched(columns: Columns, walls: Walls, free: Booleans) -> Columns:
    """The columns, of which those that are free (c,) become one before they would meet, or be needles.

    Such a column goes up from where the walls beside the bend would meet, as from a corner there: from the first layer
    on where columns would meet soon and there is room for that, else from a later one. On a straight wall it goes up
    from the middle.
    """
    edges = ShortEdges.of(columns, walls)
    columns = _bends(columns, edges)
    columns = _joined(columns, _meeting_soon(columns, edges, free), partial(_at_corner, columns, walls, later=False))
    meeting = _meeting(columns, edges, free & ~columns.are_pinched)
    columns = _joined(columns, meeting, partial(_at_corner, columns, walls, later=True))
    beside = _on_straight_walls(columns, walls, edges, free & ~columns.are_pinched)
    return _joined(columns, beside, partial(_in_middle, columns, walls))


def _joined(columns: Columns, pairs: Booleans, one_at: Callable[[_Bend], _One | None]) -> Columns:
    """The columns, of which those of ``pairs`` (p,) beside each other become the ``one_at`` their bend, if any."""
    if not pairs.any():
        return columns
    group = components(columns.pair[pairs], len(columns))
    at, foot_up, up = columns.at.copy(), columns.foot_up.copy(), columns.up.copy()
    owner, joined, kept = columns.owner.copy(), columns.joined.copy(), pairs.copy()
    before, after = (np.full(len(columns), -1) for _ in range(2))
    beside = ~pairs & ~columns.fan
    after[columns.pair[beside, 0]] = before[columns.pair[beside, 1]] = columns.side[beside]
    order = np.argsort(group, kind="stable")
    ends = np.searchsorted(group[order], np.arange(len(columns) + 1))
    for number in np.unique(group[columns.pair[pairs]]).tolist():
        mine = order[ends[number] : ends[number + 1]]
        inside = pairs & (group[columns.pair[:, 0]] == number)
        beside_bend = int(before[mine].max()), int(after[mine].max())
        # A ring of nothing but short edges has no sides beside them.
        one = one_at(_Bend(mine, inside, *beside_bend)) if min(beside_bend) >= 0 else None
        if one is None:
            kept[inside] = False
            continue
        at[mine], up[mine] = one.at, one.up
        if one.layer == 1:
            foot_up[mine] = up[mine]
        owner[mine], joined[mine] = mine[0], one.layer
    return replace(
        columns,
        at=at,
        foot_up=foot_up,
        up=up,
        owner=owner,
        joined=joined,
        pinch=columns.pinch | kept,
        twins=np.concatenate([columns.twins, columns.pair[kept]]),
    )


class ShortEdges(NamedTuple):
    """Pairs of columns on short edges of a wall, and on those of small fillets, and how they go up from there."""

    short: Booleans  # (p,)
    on_fillet: Booleans  # (p,): pairs on fillets whose radius is about the height of the first layer, or below
    nearer: Floats  # (p,): how much the columns come nearer for each unit of height
    first: Floats  # (p,): height of the first layer

    @classmethod
    def of(cls, columns: Columns, walls: Walls) -> Self:
        """The short edges among the pairs (p, 2) of columns."""
        (i, j), width = columns.pair.T, columns.bare_widths
        first = columns.first[i]
        on_fillet = walls.fillet_radii[walls.piece[columns.side]] < ROUND * first
        short = ~columns.fan & (columns.ladder[i] == columns.ladder[j]) & ((width < SHORT * first) | on_fillet)
        with np.errstate(divide="ignore", invalid="ignore"):
            nearer = -((columns.up[j] - columns.up[i]) * (columns.at[j] - columns.at[i])).sum(axis=1) / width
        return cls(short, on_fillet, nearer, first)


def _bends(columns: Columns, edges: ShortEdges) -> Columns:
    """The columns, of which those on the same short edges know the first one along the wall."""
    short = columns.pair[edges.short]
    group = components(short, len(columns))
    leader = np.unique(group, return_index=True)[1]
    # Where a ring begins within such edges the first one along the wall, as at a fan there, has no lower number.
    begin = short[~np.isin(short[:, 0], short[:, 1]), 0]
    leader[group[begin]] = begin
    return replace(columns, leader=leader[group])


def parting(columns: Columns, walls: Walls) -> Booleans:
    """Mask (c,) of the columns on such short edges that part, or go up side by side: they are a fan as they are."""
    edges = ShortEdges.of(columns, walls)
    found = np.zeros(len(columns), bool)
    found[columns.pair[edges.short & columns.apart & ~(edges.nearer > 0)]] = True
    return found


def _meeting_soon(columns: Columns, edges: ShortEdges, free: Booleans) -> Booleans:
    """Mask (p,) of the pairs on short edges whose columns meet soon, and on fillets whose columns meet at all."""
    short, on_fillet, nearer, first = edges
    soon = (columns.bare_widths < LOW_MEETING * nearer * first) | on_fillet
    return np.asarray(short & free[columns.pair].all(axis=1) & (nearer > 0) & soon)


def _meeting(columns: Columns, edges: ShortEdges, free: Booleans) -> Booleans:
    """Mask (p,) of the pairs on short edges whose columns meet below the height of their layers."""
    meeting = columns.bare_widths < edges.nearer * columns.thickness[columns.pair].max(axis=1)
    return np.asarray(edges.short & free[columns.pair].all(axis=1) & meeting)


def _on_straight_walls(columns: Columns, walls: Walls, edges: ShortEdges, free: Booleans) -> Booleans:
    """Mask (p,) of the pairs on edges of a wall that is about straight there, and whose layers become as high."""
    side = columns.side
    small = edges.short | (
        columns.bare_widths <= plain_edges(walls.domain.boundary, columns.ladders)[walls.piece[side]]
    )
    return np.asarray(small & columns.apart & ~edges.on_fillet & free[columns.pair].all(axis=1))


def _at_corner(columns: Columns, walls: Walls, bend: _Bend, *, later: bool) -> _One | None:
    """The column from where the sides beside a bend would meet; from the first layer on, or from a ``later`` one."""
    corner = _corner(columns, walls, bend)
    layer = None if corner is None else _joining_layer(columns, bend.inside, *corner, later)
    return None if corner is None or layer is None else _One(*corner, layer)


def _in_middle(columns: Columns, walls: Walls, bend: _Bend) -> _One | None:
    """The column in the middle of edges of a straight wall, from the layer on that is as high as they are long."""
    turn = turn_between(walls, bend.before, bend.after)
    if abs(turn) >= LEAST_TURN:
        return None
    begin, end = walls.x[walls.ends[bend.before, 1]], walls.x[walls.ends[bend.after, 0]]
    pair = columns.pair[bend.inside]
    ladder, scale = columns.ladders[columns.ladder[pair[0, 0]]], columns.scale[pair[0, 0]]
    tops, heights = scale * ladder.tops, scale * ladder.heights
    layer = int(np.searchsorted(heights, np.hypot(*(end - begin))))
    if layer >= ladder.count or heights[layer] > columns.spacing[pair].min():
        return None
    below = columns.at[pair] + tops[layer] * columns.up[pair]
    across = below[:, 1] - below[:, 0]
    width = (across * (columns.at[pair[:, 1]] - columns.at[pair[:, 0]])).sum(axis=1) / columns.bare_widths[bend.inside]
    if layer > 0 and (width.min() <= 0 or width.mean() < SLENDER * heights[layer - 1]):
        return None
    up = middle_way(walls, bend.after, turn)
    at = clear_of(below, (begin + end) / 2 + tops[layer + 1] * up, walls.directions[bend.after], heights[layer])
    return None if at is None else _One(at - tops[layer + 1] * up, up, layer + 1)


def _joining_layer(columns: Columns, inside: Booleans, corner: Floats, up: Floats, later: bool) -> int | None:
    """Number of the layer from which on columns on the edges ``inside`` (p,) a bend may be one; None if there is none.

    That one goes ``up`` (2,) from a corner (2,), to above all edges of the layer below. It is the first layer, or a
    ``later`` one by which columns would meet soon, but are not too near to each other.
    """
    pair = columns.pair[inside]
    ladder, scale = columns.ladders[columns.ladder[pair[0, 0]]], columns.scale[pair[0, 0]]
    start, ways = columns.at[pair], columns.up[pair]
    along = start[:, 1] - start[:, 0]
    along /= np.hypot(*along.T)[:, None]
    nearer = -((ways[:, 1] - ways[:, 0]) * along).sum(axis=1)
    tops, heights = scale * ladder.tops, scale * ladder.heights
    for layer in range(1, ladder.count) if later else (0,):
        begin, end = np.moveaxis(start + tops[layer] * ways, 1, 0)
        width = ((end - begin) * along).sum(axis=1)
        if later and (width.min() <= 0 or width.mean() < SLENDER * heights[layer - 1]):
            return None
        soon = not later or width.mean() < LOW_MEETING * nearer.mean() * heights[layer]
        left = turned_left(end - begin)
        above = ((corner + tops[layer + 1] * up - begin) * left).sum(axis=1) / np.hypot(*left.T)
        if soon and (above >= CLEAR * heights[layer]).all():
            return layer + 1
    return None


def _corner(columns: Columns, walls: Walls, bend: _Bend) -> tuple[Floats, Floats] | None:
    """Place (2,) where the sides beside a bend would meet, and the way up (2,) from there; None if that is no place."""
    turn = turn_between(walls, bend.before, bend.after)
    if turn < LEAST_TURN:
        return None
    first, last = walls.directions[bend.before], walls.directions[bend.after]
    begin, end = walls.x[walls.ends[bend.before, 1]], walls.x[walls.ends[bend.after, 0]]
    way = end - begin
    share = (way[0] * last[1] - way[1] * last[0]) / np.sin(turn)
    length = float(np.hypot(*(walls.x[columns.foot[bend.columns]] - begin).T).max())
    if not 0 <= share <= FARTHEST * length:
        return None
    return begin + share * first, middle_way(walls, bend.after, turn)
