"""Spacing that is fine near something and grows with the distance from it."""

from typing import Any

import numpy as np

from bubblemesh.arrays import ROUNDING, Floats, side_by_side
from bubblemesh.geometry.distance.distances import Distance
from bubblemesh.kernels.hilbert import along_hilbert_curve
from bubblemesh.records import record
from bubblemesh.spacing.bounds import Bounds, least_of

NEAR_GROWTH = 0.2  # of the spacing per length, where the case gives none
TOGETHER = 32  # points that are asked together which terms are in question


@record
class Proximity:
    """A term ``size + growth * distance``."""

    distance: Distance
    size: float  # spacing at distance 0
    growth: float = NEAR_GROWTH  # of the spacing per length
    until: float = 0.0  # up to this distance the spacing stays at its size

    @property
    def costly(self) -> bool:
        """Whether the distance takes long."""
        return self.distance.costly

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Values (n,) at x (n,) and y (n,)."""
        return self.at(side_by_side(x, y))

    def at(self, points: Floats) -> Floats:
        """Values (m,) at points (m, 2)."""
        values: Floats = self._of(self.distance(points))
        return values

    def bounds_within(self, low: Floats, high: Floats) -> Bounds:
        """Bounds within boxes between corners low (n, 2) and high (n, 2)."""
        bounds: Bounds = self._of(Bounds.of_distance(self.distance, *Bounds.of_coordinates(low, high)))
        return bounds

    def _of(self, distance: Any) -> Any:
        """Values at distances, or their bounds."""
        return np.add(self.size, np.multiply(self.growth, np.maximum(np.subtract(distance, self.until), 0)))


@record
class Proximities:
    """The smallest of several such terms, few of whose distances are computed.

    A term cannot change from a place to another one by more than its growth times their distance.
    """

    terms: tuple[Proximity, ...]

    costly = True

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Values (n,) at x (n,) and y (n,)."""
        points = side_by_side(x, y)
        order = along_hilbert_curve(points)
        first = np.arange(0, len(points), TOGETHER)
        values = np.full(len(points), np.inf)
        if len(points) == 0:
            return values
        count = np.diff(first, append=len(points))
        center = np.add.reduceat(points[order], first) / count[:, None]
        away = np.hypot(*(points[order] - np.repeat(center, count, axis=0)).T)
        there = np.array([term.at(center) for term in self.terms])
        change = np.array([[term.growth] for term in self.terms]) * np.maximum.reduceat(away, first)
        in_question = there - change <= (there + change).min(axis=0) * (1 + ROUNDING)
        for term, blocks in zip(self.terms, in_question, strict=True):
            mine = order[np.repeat(blocks, count)]
            values[mine] = np.minimum(values[mine], term.at(points[mine]))
        return values

    def bounds_within(self, low: Floats, high: Floats) -> Bounds:
        """Bounds within boxes between corners low (n, 2) and high (n, 2)."""
        return least_of([term.bounds_within(low, high) for term in self.terms])
