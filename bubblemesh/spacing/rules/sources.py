"""Sources of a finer spacing: where the boundary itself is finer than what the case asks for."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers, members
from bubblemesh.errors import LimitError
from bubblemesh.geometry.curves import turning
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.gaps import Walls
from bubblemesh.messages import place
from bubblemesh.spacing.spacing import Spacing

LONGEST = 0.5  # spacings
HALVINGS = 60


def panels(domain: Domain, spacing: Spacing) -> tuple[Integers, Floats, Floats]:
    """Piece, begin and length (k,) of panels that are short beside the spacing at their ends and middles."""
    boundary = domain.boundary
    piece = np.arange(len(boundary.lengths))
    begin, length = np.zeros(len(piece)), np.asarray(boundary.lengths, float)
    done = []
    for _ in range(HALVINGS):
        places = np.concatenate([begin, begin + length / 2, begin + length])
        d = spacing(boundary.points(np.tile(piece, 3), places)).reshape(3, -1).min(axis=0)
        short = length <= LONGEST * d
        done.append((piece[short], begin[short], length[short]))
        piece, begin, length = piece[~short], begin[~short], length[~short] / 2
        piece, begin, length = np.tile(piece, 2), np.append(begin, begin + length), np.tile(length, 2)
        if len(piece) == 0:
            break
    done.append((piece, begin, length))
    piece, begin, length = (np.concatenate(column) for column in zip(*done, strict=True))
    order = np.lexsort((begin, piece))
    return piece[order], begin[order], length[order]


SHORT = 0.75  # of the spacing: a longer piece fits into the packing as it is
APART = 0.25  # distance of sources on a curve, in terms of their sizes
SOURCE_CELL = 0.25  # of the size: largest side of a cell from which a limit starts
WIDEST_TURN = np.pi / 3  # that one boundary edge may span: six edges on a circle
MANY = 0.02  # of the nodes allowed: fewer on curves do not lead to too many beside them


@dataclass(frozen=True)
class Sources:
    """Places ``points`` (k, 2) where the spacing is at most ``sizes`` (k,), and grows from there.

    On a background grid the ``cells`` (k,) that hold them have at most these sides: a quarter of the sizes by default,
    more for sources that are close to each other.
    """

    points: Floats
    sizes: Floats
    given: Floats | None = None

    def __len__(self) -> int:
        return len(self.points)

    @property
    def cells(self) -> Floats:
        """Largest sides (k,)."""
        return SOURCE_CELL * self.sizes if self.given is None else self.given

    @classmethod
    def none(cls) -> "Sources":
        """No source at all."""
        return cls(np.zeros((0, 2)), np.zeros(0))

    @classmethod
    def all_of(cls, some: Sequence["Sources"]) -> "Sources":
        """Several sets together."""
        return cls(
            *(np.concatenate(column) for column in zip(*((s.points, s.sizes, s.cells) for s in some), strict=True))
        )

    def not_below(self, minimum: float) -> "Sources":
        """The same places with sizes of at least ``minimum``."""
        return replace(self, sizes=np.maximum(self.sizes, minimum))

    def joined(self, other: "Sources") -> "Sources":
        """Both sets together."""
        return Sources.all_of([self, other])


def short_pieces(domain: Domain, spacing: Spacing) -> Sources:
    """Sources at the ends of boundary pieces that are shorter than the spacing."""
    boundary = domain.boundary
    pieces = np.flatnonzero(~boundary.closed)
    ends = boundary.corners[np.column_stack([boundary.start, boundary.end])[pieces]]
    d = np.minimum(spacing(ends[:, 0]), spacing(ends[:, 1])) if len(pieces) else np.zeros(0)
    short = boundary.lengths[pieces] < SHORT * d
    return Sources(ends[short].reshape(-1, 2), np.repeat(boundary.lengths[pieces[short]], 2))


def coarse_curves(domain: Domain, spacing: Spacing, widest_turn: float = WIDEST_TURN) -> Sources:
    """Sources on curves that turn by more than ``widest_turn`` over the length of one spacing."""
    return _along(domain, _tight(domain, spacing, widest_turn))


@dataclass(frozen=True)
class Turning:
    """Sources on curves for a number of nodes on a full turn.

    Attributes
    ----------
    per_circle : float
    growth : float
        What the spacing grows by from the sources, per length.
    least : float
        The finest size that is of use.
    max_nodes : float
    """

    per_circle: float
    growth: float
    least: float = 0.0
    max_nodes: float = np.inf

    def __call__(self, domain: Domain, spacing: Spacing) -> Sources:
        """Sources where the spacing is too coarse.

        Raises
        ------
        LimitError
            If they need more than ``max_nodes`` nodes, with the tightest place.
        """
        tight = _tight(domain, spacing, 2 * np.pi / self.per_circle)
        radius = tight.size * self.per_circle / (2 * np.pi)
        tight = tight._replace(size=np.maximum(tight.size, self.least))
        if self._nodes_beside(domain, tight, radius) > self.max_nodes:
            at = tight.size.argmin()
            where = place(domain.boundary.points(tight.piece[at : at + 1], tight.s[at : at + 1])[0])
            raise LimitError(
                f"limits.max_nodes: spacing.per_circle asks for more than the limit of {self.max_nodes} nodes, for a "
                f"spacing of {tight.size[at]:.3g} on the curve at {where}: ask for fewer on a turn, set "
                "spacing.minimum, or raise the limit"
            )
        return _along(domain, tight)

    def _nodes_beside(self, domain: Domain, tight: "TightChords", radius: Floats) -> float:
        """Nodes that the spacing leads to at least, on curves and up to half the way to what is beside them."""
        along = tight.step / tight.size
        if along.sum() < MANY * self.max_nodes:
            return 0.0
        deep = radius / 4  # up to there a curve gets shorter by a quarter, if it does
        room = Walls(domain).facing(tight.piece, tight.s + tight.step / 2, 2 * deep, deep)
        np.minimum.at(deep, room.number, room.widths / 2)
        beside = 0.75 * deep / (tight.size + self.growth * deep)
        return float((along * (1 / 2 + 2 / np.sqrt(3) * beside)).sum())


class TightChords(NamedTuple):
    """Parts of curves that are too tight for the spacing: piece, arc length, step, and the size (k,) that they need."""

    piece: Integers
    s: Floats
    step: Floats
    size: Floats


def _tight(domain: Domain, spacing: Spacing, widest_turn: float) -> TightChords:
    """Chords of curves that turn by more than ``widest_turn`` over the length of one spacing."""
    boundary = domain.boundary
    piece, s, step = boundary.panels()
    curved = boundary.approximated[piece]
    piece, s, step = piece[curved], s[curved], step[curved]
    before, after = boundary.tangents(piece, s), boundary.tangents(piece, s + step)
    size = widest_turn * step / np.maximum(np.abs(turning(before, after)), 1e-12)
    coarse = spacing(boundary.points(piece, s)) > size
    return TightChords(piece[coarse], s[coarse], step[coarse], size[coarse])


def _along(domain: Domain, tight: TightChords) -> Sources:
    parts = np.ceil(tight.step / (APART * tight.size)).astype(np.int64)
    chord, part = members(parts)
    s = tight.s[chord] + part * (tight.step / parts)[chord]
    return Sources(domain.boundary.points(tight.piece[chord], s), tight.size[chord])
