"""The smallest of several terms, scaled and kept within limits."""

from collections.abc import Callable
from typing import Any

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import Key
from bubblemesh.records import record
from bubblemesh.spacing.bounds import Bounds, bounds_of, least_of
from bubblemesh.spacing.spacing import Spacing

MINIMUM, MAXIMUM = Key(["spacing", "minimum"]), Key(["spacing", "maximum"])
Term = Callable[[Floats, Floats], Floats]  # values (n,) at x (n,) and y (n,), infinite where it asks for nothing


def nothing(x: Floats, y: Floats) -> Floats:
    """A term that asks for nothing."""
    return np.full(np.shape(x), np.inf)


def costly(term: Term | None) -> bool:
    """Whether a term says that it takes long."""
    return bool(getattr(term, "costly", False))


@record
class Combination:
    """A spacing d(x, y) made of terms."""

    terms: tuple[Spacing, ...]  # the smallest value counts; where one is no number, neither is the result
    scale: float = 1.0  # factor of that value
    minimum: float = 0.0  # of the product
    maximum: float = np.inf

    @property
    def costly(self) -> bool:
        """Whether one of the terms takes long."""
        return any(term.costly for term in self.terms)

    @property
    def is_uniform(self) -> bool:
        """Whether all of the terms are the same everywhere."""
        return all(term.is_uniform for term in self.terms)

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Values (n,) at x (n,) and y (n,)."""
        smallest = np.full(np.shape(x), np.inf)
        for term in self.terms:
            smallest = np.minimum(smallest, term.function(x, y))
        if self._unchanged:
            return smallest
        with np.errstate(invalid="ignore"):
            # Limits must not make a spacing of a value that is not positive.
            limited = np.clip(self.scale * smallest, self.minimum, self.maximum)
        return np.where(smallest > 0, limited, smallest)

    @property
    def _unchanged(self) -> bool:
        """Whether the smallest value is the result as it is."""
        return self.scale == 1 and self.minimum <= 0 and self.maximum == np.inf

    def bounds_within(self, low: Floats, high: Floats) -> Bounds | None:
        """Bounds within boxes between corners low (n, 2) and high (n, 2); None if a term has none."""
        known = [bounds_of(term.function, low, high) for term in self.terms if term.function is not nothing]
        found = [bounds for bounds in known if bounds is not None]
        if len(found) < max(len(known), 1):
            return None
        with np.errstate(all="ignore"):
            smallest = least_of(found)
            limited: Any = np.minimum(np.maximum(np.multiply(self.scale, smallest), self.minimum), self.maximum)
        return limited.only_where(smallest.low > 0)  # limits do not hold for what is no spacing

    def keys(self, points: Floats) -> list[Key]:
        """Keys (n) of what sets the value at points (n, 2): the first term that has it, or a limit."""
        x, y = points.T
        values = np.array([np.broadcast_to(term.function(x, y), len(points)) for term in self.terms])
        first = values.argmin(axis=0)  # the first that is no number, if one is
        d = self.scale * values[first, np.arange(len(points))]
        low, high = (d > 0) & (d < self.minimum), d > self.maximum
        keys = [MINIMUM if below else MAXIMUM for below in low.tolist()]
        for number, term in enumerate(self.terms):
            mine = np.flatnonzero((first == number) & ~low & ~high)
            for k, key in zip(mine.tolist(), term.keys(points[mine]), strict=True):
                keys[k] = key
        return keys
