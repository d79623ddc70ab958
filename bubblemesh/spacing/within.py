"""Spacings that count within a region."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bubblemesh.arrays import Booleans, Floats
from bubblemesh.spacing.combination import Term, costly

__all__ = ["Inside", "Within"]

Inside = Callable[[Floats, Floats], Booleans]  # which points, given as x (n,) and y (n,), lie in some set


@dataclass(frozen=True)
class Within:
    """A term that asks for nothing outside a region.

    Attributes
    ----------
    term : callable
        Values (n,) at x (n,) and y (n,).
    reaches : tuple of callable or None
        Which points lie within each ring of the region or on it; without rings, all do.
    others : tuple of callable
        Which points lie in other regions, off their rims, that count before this one.
    """

    term: Term
    reaches: tuple[Inside, ...] | None
    others: tuple[Inside, ...] = ()

    @property
    def costly(self) -> bool:
        """Whether the term takes long."""
        return costly(self.term)

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Values (n,) at x (n,) and y (n,), infinite outside the region and off its rim."""
        mine = np.arange(len(x))
        if self.reaches is not None:
            mine = np.flatnonzero(np.any([reach(x, y) for reach in self.reaches], axis=0))
        for other in self.others:
            mine = mine[~other(x[mine], y[mine])]
        values = np.full(len(x), np.inf)
        values[mine] = self.term(x[mine], y[mine])
        return values
