"""Sources of a finer spacing: where the boundary itself is finer than what the case asks for."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, members
from bubblemesh.errors import NODE_LIMIT, NodeLimitError
from bubblemesh.geometry.curves import turning
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.narrow_parts import FacingWalls
from bubblemesh.messages import place
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing

LONGEST = 0.5  # spacings: length of an interval
HALVINGS = 60
SHORT = 0.75  # of the spacing: a longer piece fits into the packing as it is
APART_ON_CURVE = 0.25  # distance of sources on a curve, in terms of their sizes
SOURCE_CELL = 0.25  # of the size: largest side of a cell from which a limit starts
RIM_CELL = 1.0  # of the size: the same for sources along the boundary, from which the spacing rises to one side only
WIDEST_TURN = np.pi / 3  # that one boundary edge may span: six edges on a circle
SAME_TURN = 1e-3  # edges: an excess of a curve over so many of them that is due to its polygonal copy
SURELY = 0.95  # of a number of edges by the spacing at points: so many are left on a grid that interpolates it
MANY = 0.02  # of the nodes allowed: fewer on curves do not lead to too many beside them


@record
class Sources:
    """Places ``points`` (k, 2) where the spacing is at most ``sizes`` (k,), and grows from there.

    Those ``on_rim`` (k,), by default none, follow each other along the boundary, outside of which the spacing has no
    meaning. On a background grid the ``cells`` (k,) that hold sources have at most these sides: by default a quarter of
    the size, or all of it on the rim.
    """

    points: Floats
    sizes: Floats
    largest_cells: Floats | None = None
    rim: Booleans | None = None

    def __len__(self) -> int:
        return len(self.points)

    @property
    def on_rim(self) -> Booleans:
        """Whether each (k,) of the sources is one of those along the boundary."""
        return np.zeros(len(self), bool) if self.rim is None else self.rim

    @property
    def cells(self) -> Floats:
        """Largest sides (k,)."""
        return (
            np.where(self.on_rim, RIM_CELL, SOURCE_CELL) * self.sizes
            if self.largest_cells is None
            else self.largest_cells
        )

    @classmethod
    def none(cls) -> "Sources":
        """No source at all."""
        return cls(np.zeros((0, 2)), np.zeros(0))

    @classmethod
    def all_of(cls, some: Sequence["Sources"]) -> "Sources":
        """Sources of several sets."""
        columns = zip(*((s.points, s.sizes, s.cells, s.on_rim) for s in some), strict=True)
        return cls(*(np.concatenate(column) for column in columns))

    def select(self, which: Integers | Booleans) -> "Sources":
        """Selected sources, by a mask or by numbers."""
        return Sources(self.points[which], self.sizes[which], self.cells[which], self.on_rim[which])

    def not_below(self, minimum: float) -> "Sources":
        """Sources at the same places, with sizes of at least ``minimum``."""
        return replace(self, sizes=np.maximum(self.sizes, minimum))

    def joined(self, other: "Sources") -> "Sources":
        """Sources of both sets."""
        return Sources.all_of([self, other])


def short_intervals(domain: Domain, spacing: Spacing) -> tuple[Integers, Floats, Floats]:
    """Piece, begin and length (k,) of boundary intervals, short beside the spacing at their ends and middles."""
    boundary = domain.boundary
    piece = np.arange(len(boundary.lengths))
    begin, length = np.zeros(len(piece)), np.asarray(boundary.lengths, float)
    places = np.concatenate([begin, begin + length / 2, begin + length])
    first, middle, last = spacing.along(boundary, np.tile(piece, 3), places).reshape(3, -1)
    done = []
    for _ in range(HALVINGS):
        short = length <= LONGEST * np.minimum(np.minimum(first, middle), last)
        done.append((piece[short], begin[short], length[short]))
        piece, begin, length = halved(piece[~short], begin[~short], length[~short])
        if len(piece) == 0:
            break
        # A half ends where the other one begins, but for rounding it would be known where the last one ends as well.
        first, last = np.concatenate([first[~short], middle[~short]]), middle[~short]
        count, second = len(piece), slice(len(piece) // 2, None)
        places = np.concatenate([begin + length / 2, begin[second] + length[second]])
        values = spacing.along(boundary, np.concatenate([piece, piece[second]]), places)
        middle, last = values[:count], np.concatenate([last, values[count:]])
    piece, begin, length = (np.concatenate(column) for column in zip(*done, (piece, begin, length), strict=True))
    order = np.lexsort((begin, piece))
    return piece[order], begin[order], length[order]


def halved(piece: Integers, begin: Floats, length: Floats) -> tuple[Integers, Floats, Floats]:
    """Halves (2 k,) of boundary intervals (k,), all first halves first."""
    half = length / 2
    return np.concatenate([piece, piece]), np.concatenate([begin, begin + half]), np.concatenate([half, half])


def short_pieces(domain: Domain, spacing: Spacing, hidden: Floats | None = None) -> Sources:
    """Sources at the ends of boundary pieces that are shorter than the spacing.

    Of each piece those not longer than a length (p,) are ``hidden``, and none.
    """
    boundary = domain.boundary
    pieces = np.flatnonzero(~boundary.closed)
    ends = boundary.corners[np.column_stack([boundary.start, boundary.end])[pieces]]
    # The chord of a loop, which ends where it begins, has no direction: its ends have those of their own.
    chord, loop = ends[:, 1] - ends[:, 0], (boundary.start == boundary.end)[pieces, None]
    begin, end = np.zeros(len(pieces)), boundary.lengths[pieces]
    first, last = (np.where(loop, boundary.tangents(pieces, s), chord) for s in (begin, end))
    d = np.minimum(spacing.towards(ends[:, 0], first), spacing.towards(ends[:, 1], last))
    short = boundary.lengths[pieces] < SHORT * d
    if hidden is not None:
        short &= boundary.lengths[pieces] > hidden[pieces]
    sizes, rim = np.repeat([boundary.lengths[pieces[short]], ~boundary.inner[pieces[short]]], 2, axis=1)
    return Sources(ends[short].reshape(-1, 2), sizes, rim=rim.astype(bool))


def coarse_curves(domain: Domain, spacing: Spacing, hidden: Floats | None = None) -> Sources:
    """Sources on curves that turn by more than `WIDEST_TURN` over the length of one spacing, or over an edge there.

    Edges are a whole number: a quarter of a circle gets two, not one and a half to the nearest. Curves that are
    ``hidden``, as in `short_pieces`, get none.
    """
    return _along(domain, _tight(domain, spacing, WIDEST_TURN, hidden, whole=True))


def curvature_sources(
    domain: Domain,
    spacing: Spacing,
    per_circle: float,
    growth: float,
    least: float,
    max_nodes: float,
    hidden: Floats | None,
) -> Sources:
    """Sources on curves where the spacing is too coarse for ``per_circle`` nodes on a full turn.

    The spacing grows by ``growth`` per length from the sources, and sizes below ``least`` are of no use. Curves that
    are ``hidden``, as of `short_pieces`, have none. LimitError if they need more than ``max_nodes`` nodes, with the
    tightest place.
    """
    tight = _tight(domain, spacing, 2 * np.pi / per_circle, hidden)
    radius = tight.size * per_circle / (2 * np.pi)
    tight = tight._replace(size=np.maximum(tight.size, least))
    if _nodes_beside(domain, tight, radius, growth, max_nodes) > max_nodes:
        at = tight.size.argmin()
        where = place(domain.boundary.points(tight.piece[at : at + 1], tight.s[at : at + 1])[0])
        raise NodeLimitError(
            f"{NODE_LIMIT}: spacing.per_circle asks for more than the limit of {max_nodes} nodes, for a "
            f"spacing of {tight.size[at]:.3g} on the curve at {where}: ask for fewer on a turn, set "
            "spacing.minimum, or raise the limit"
        )
    return _along(domain, tight)


class TightChords(NamedTuple):
    """Parts of curves that are too tight for the spacing: piece, arc length, step, and the size (k,) that they need."""

    piece: Integers
    s: Floats
    step: Floats
    size: Floats

    def select(self, which: Booleans) -> "TightChords":
        """Selected chords, by a mask (k,)."""
        return TightChords(self.piece[which], self.s[which], self.step[which], self.size[which])


def _tight(
    domain: Domain, spacing: Spacing, widest_turn: float, hidden: Floats | None, whole: bool = False
) -> TightChords:
    """Chords of curves, but for ``hidden`` ones, that turn by more than ``widest_turn`` over one spacing.

    On request their sizes are such that no piece turns by more over one of a ``whole`` number of edges.
    """
    boundary = domain.boundary
    piece, s, step = boundary.stations()
    curved = boundary.approximated[piece]
    if hidden is not None:
        curved &= boundary.lengths[piece] > hidden[piece]
    piece, s, step = piece[curved], s[curved], step[curved]
    before, after = boundary.tangents(piece, s), boundary.tangents(piece, s + step)
    size = widest_turn * step / np.maximum(np.abs(turning(before, after)), 1e-12)
    d = spacing(boundary.points(piece, s))
    if whole:
        size *= _of_whole_edges(piece, step, size, d)
    return TightChords(piece, s, step, size).select(d > size)


def _of_whole_edges(piece: Integers, step: Floats, size: Floats, d: Floats) -> Floats:
    """Factors (k,) of the sizes that chords need, with which pieces get as many edges as that, rounded up.

    They get the nearest whole number, at least one, by the size or the spacing ``d`` (k,), whichever is finer.
    """
    needed, found = np.bincount(piece, step / size), np.bincount(piece, step / np.minimum(size, d))
    least = np.maximum(np.ceil(needed - SAME_TURN), 1.0)
    few = (least > 1) & (SURELY * found < least - 0.5)
    return np.asarray(np.where(few, needed / least, 1.0)[piece])


def _along(domain: Domain, tight: TightChords) -> Sources:
    parts = np.ceil(tight.step / (APART_ON_CURVE * tight.size)).astype(np.int64)
    chord, part = members(parts)
    s = tight.s[chord] + part * (tight.step / parts)[chord]
    return Sources(domain.boundary.points(tight.piece[chord], s), tight.size[chord])


def _nodes_beside(domain: Domain, tight: TightChords, radius: Floats, growth: float, max_nodes: float) -> float:
    """Nodes that the spacing leads to at least, on curves and up to half the way to what is beside them."""
    along = tight.step / tight.size
    if along.sum() < MANY * max_nodes:
        return 0.0
    deep = radius / 4  # up to there a curve gets shorter by a quarter, if it does
    room = FacingWalls(domain).facing(tight.piece, tight.s + tight.step / 2, 2 * deep, deep)
    np.minimum.at(deep, room.number, room.widths / 2)
    beside = 0.75 * deep / (tight.size + growth * deep)
    return float((along * (1 / 2 + 2 / np.sqrt(3) * beside)).sum())
