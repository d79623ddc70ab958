"""The node spacing d(x, y), checked wherever it is used."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from bubblemesh.arrays import Booleans, Floats
from bubblemesh.errors import CaseError, Key, at_key
from bubblemesh.messages import place


def _whole(point: Floats) -> Key:
    return Key(["spacing"])


@dataclass(frozen=True)
class Spacing:
    """Desired distance between neighbouring nodes, in the domain's unit of length.

    Attributes
    ----------
    function : callable
        Values (n,) at the coordinates x (n,) and y (n,).
    floor : float
        Value that stands for d outside the domain where the function has no positive one.
    key : callable
        The key of the case that the spacing at a point (2,) comes from: a region may have its own.
    costly : bool
        Whether the function takes so long that a table of it is worth having.
    spots : (k, 2)
        Places where it may be fine over so short a distance that samples would pass them by.
    """

    function: Callable[[Floats, Floats], Floats]
    floor: float = 0.0
    key: Callable[[Floats], Key] = _whole
    costly: bool = False
    spots: Floats = field(default_factory=lambda: np.zeros((0, 2)), compare=False)

    def __call__(self, points: Floats) -> Floats:
        """Spacing (n,) at points (n, 2) of the domain.

        Raises
        ------
        CaseError
            Where it is zero, negative, infinite or no number; the text names the point.
        """
        d = self._values(points)
        bad = np.flatnonzero(~_usable(d))
        if len(bad):
            k = bad[0]
            with at_key(*self.key(points[k])):
                raise CaseError(
                    f"is {d[k]:g} at {place(points[k])}: it has to be positive and finite in the whole domain"
                )
        return d

    def extended(self, points: Floats) -> Floats:
        """Spacing (n,) at points (n, 2) anywhere: not below the floor, nor undefined."""
        d = self._values(points)
        return np.where(_usable(d), np.maximum(d, self.floor), self.floor)

    def between(self, corners: Floats) -> Floats:
        """Spacing (m,) at the centroids of points (m, k, 2); where undefined there, the mean of the points'.

        The midpoint of two nodes on the rim of a hole lies inside the hole, where the function need not exist.
        """
        d = self._values(corners.mean(axis=1))
        bad = np.flatnonzero(~_usable(d))
        if len(bad):
            d = d.copy()
            d[bad] = self(corners[bad].reshape(-1, 2)).reshape(len(bad), -1).mean(axis=1)
        return d

    def floored(self, floor: float) -> "Spacing":
        """The spacing with a floor outside the domain."""
        return replace(self, floor=floor)

    def _values(self, points: Floats) -> Floats:
        return np.asarray(self.function(points[:, 0], points[:, 1]), float)


def _usable(d: Floats) -> Booleans:
    return np.isfinite(d) & (d > 0)
