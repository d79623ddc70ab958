"""Spacings that count within a region."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats
from bubblemesh.geometry.boxes import Boxes
from bubblemesh.spacing.combination import Term, costly

__all__ = ["Inside", "Shapes", "Within"]

Inside = Callable[[Floats, Floats], Booleans]  # which points, given as x (n,) and y (n,), lie in some set


@dataclass(frozen=True)
class Shapes:
    """The places inside any of some shapes, of which there may be hundreds."""

    shapes: tuple[shapely.Geometry, ...]

    @cached_property
    def _boxes(self) -> Boxes:
        return Boxes.of(shapely.bounds(np.array(self.shapes, dtype=object)))

    def __call__(self, x: Floats, y: Floats) -> Booleans:
        """Which points with coordinates x (n,) and y (n,) are there."""
        inside = np.zeros(len(x), bool)
        if self.shapes:
            point, shape = self._boxes.holding(x, y)
            held = shapely.contains_xy(np.array(self.shapes, dtype=object)[shape], x[point], y[point])
            inside[point[held]] = True
        return inside


@dataclass(frozen=True)
class Within:
    """A term that asks for nothing outside a region.

    Attributes
    ----------
    term : callable
        Values (n,) at x (n,) and y (n,).
    reach : callable or None
        Which points lie in the region or on its rim; all do if there is none.
    others : callable or None
        Which of them lie in other regions, off their rims, that count before this one.
    """

    term: Term
    reach: Inside | None
    others: Inside | None = None

    @property
    def costly(self) -> bool:
        """Whether the term takes long."""
        return costly(self.term)

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Values (n,) at x (n,) and y (n,), infinite outside the region and off its rim."""
        mine = np.arange(len(x)) if self.reach is None else np.flatnonzero(self.reach(x, y))
        if self.others is not None:
            mine = mine[~self.others(x[mine], y[mine])]
        values = np.full(len(x), np.inf)
        values[mine] = self.term(x[mine], y[mine])
        return values
