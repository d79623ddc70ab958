"""A finer spacing where the boundary itself is finer than what the case asks for."""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.geometry.curves import turning
from bubblemesh.geometry.domain import Domain
from bubblemesh.spacing.spacing import Spacing

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

__all__ = ["GROWTH", "Sources", "coarse_curves", "short_pieces"]

GROWTH = 0.3  # increase of the spacing per length, away from a source
NEIGHBOURS = 8
SHORT = 0.75  # of the spacing: a longer piece fits into the packing as it is
WIDEST_TURN = np.pi / 3  # that one boundary edge may span: six edges on a circle


@dataclass(frozen=True)
class Sources:
    """Places ``points`` (k, 2) where the spacing is at most ``sizes`` (k,), and grows from there."""

    points: Floats
    sizes: Floats

    def __len__(self) -> int:
        return len(self.points)

    @cached_property
    def _tree(self) -> "cKDTree":
        from scipy.spatial import cKDTree  # takes longer to load than to mesh a small case without it

        return cKDTree(self.points)

    def joined(self, other: "Sources") -> "Sources":
        """Both sets together."""
        return Sources(np.vstack([self.points, other.points]), np.concatenate([self.sizes, other.sizes]))

    def limit(self, points: Floats, below: float = np.inf) -> Floats:
        """Largest spacing (n,) that the sources next to the points (n, 2) admit, or infinity if it is not ``below``."""
        if len(points) == 0:
            return np.zeros(0)
        reach = max(below - float(self.sizes.min()), 0) / GROWTH
        near = range(1, min(NEIGHBOURS, len(self)) + 1)
        distance, source = self._tree.query(points, k=near, distance_upper_bound=reach)
        return (np.append(self.sizes, np.inf)[source] + GROWTH * distance).min(axis=1)

    def limited(self, spacing: Spacing) -> Spacing:
        """The spacing, nowhere above the limit."""
        if len(self) == 0:
            return spacing

        def function(x: Floats, y: Floats) -> Floats:
            wanted = np.broadcast_to(np.asarray(spacing.function(x, y), float), np.shape(x))
            below = np.max(wanted, initial=0.0, where=np.isfinite(wanted))
            with np.errstate(invalid="ignore"):
                return np.minimum(wanted, self.limit(np.column_stack([x, y]), float(below)))

        return Spacing(function, min(spacing.floor, float(self.sizes.min()) / 2))


def short_pieces(domain: Domain, spacing: Spacing) -> Sources:
    """Sources at the ends of boundary pieces that are shorter than the spacing."""
    boundary = domain.boundary
    pieces = np.flatnonzero(~boundary.closed)
    ends = boundary.corners[np.column_stack([boundary.start, boundary.end])[pieces]]
    d = np.minimum(spacing(ends[:, 0]), spacing(ends[:, 1])) if len(pieces) else np.zeros(0)
    short = boundary.lengths[pieces] < SHORT * d
    return Sources(ends[short].reshape(-1, 2), np.repeat(boundary.lengths[pieces[short]], 2))


def coarse_curves(domain: Domain, spacing: Spacing) -> Sources:
    """Sources on curves that turn too far over the length of one spacing."""
    boundary = domain.boundary
    piece, s, step = boundary.panels()
    curved = boundary.approximated[piece]
    piece, s, step = piece[curved], s[curved], step[curved]
    before, after = boundary.tangents(piece, s), boundary.tangents(piece, s + step)
    size = WIDEST_TURN * step / np.maximum(np.abs(turning(before, after)), 1e-12)
    points = boundary.points(piece, s)
    coarse = spacing(points) > size
    return Sources(points[coarse], size[coarse])
