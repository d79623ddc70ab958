"""A finer spacing where the boundary itself is finer than what the case asks for."""

from dataclasses import dataclass

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.geometry.curves import turning
from bubblemesh.geometry.domain import Domain
from bubblemesh.spacing.spacing import Spacing

__all__ = ["Sources", "coarse_curves", "short_pieces"]

SHORT = 0.75  # of the spacing: a longer piece fits into the packing as it is
APART = 0.25  # distance of sources on a curve, in terms of their sizes
WIDEST_TURN = np.pi / 3  # that one boundary edge may span: six edges on a circle


@dataclass(frozen=True)
class Sources:
    """Places ``points`` (k, 2) where the spacing is at most ``sizes`` (k,), and grows from there."""

    points: Floats
    sizes: Floats

    def __len__(self) -> int:
        return len(self.points)

    @classmethod
    def none(cls) -> "Sources":
        """No source at all."""
        return cls(np.zeros((0, 2)), np.zeros(0))

    def not_below(self, minimum: float) -> "Sources":
        """The same places with sizes of at least ``minimum``."""
        return Sources(self.points, np.maximum(self.sizes, minimum))

    def joined(self, other: "Sources") -> "Sources":
        """Both sets together."""
        return Sources(np.vstack([self.points, other.points]), np.concatenate([self.sizes, other.sizes]))


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
    boundary = domain.boundary
    piece, s, step = boundary.panels()
    curved = boundary.approximated[piece]
    piece, s, step = piece[curved], s[curved], step[curved]
    before, after = boundary.tangents(piece, s), boundary.tangents(piece, s + step)
    size = widest_turn * step / np.maximum(np.abs(turning(before, after)), 1e-12)
    coarse = spacing(boundary.points(piece, s)) > size
    piece, s, step, size = piece[coarse], s[coarse], step[coarse], size[coarse]
    parts = np.ceil(step / (APART * size)).astype(np.int64)
    chord = np.repeat(np.arange(len(parts)), parts)
    part = np.arange(len(chord)) - np.repeat(np.cumsum(parts) - parts, parts)
    return Sources(boundary.points(piece[chord], s[chord] + part * (step / parts)[chord]), size[chord])
