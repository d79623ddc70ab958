"""Spacings at a scale, and limits that do not go with it."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.case.spacing import SpacingTerms
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.terms.combination import Combination

UNLIMITED = (0.0, np.inf)
# At a scale, before the rules; or at its own scale if None is given.
SpacingAtScale = Callable[[float | None], Spacing]


def bounded(terms: SpacingTerms, found: tuple[Spacing, ...], spots: Floats, own_scale: float = 1.0) -> SpacingAtScale:
    """The smallest of some spacings at a scale, or else their own, within the terms' limits; fine near spots (k, 2)."""
    limits = terms.minimum or 0.0, np.inf if terms.maximum is None else terms.maximum

    def at(scale: float | None) -> Spacing:
        factor = own_scale if scale is None else scale
        if len(found) == 1 and (factor, limits) == (1.0, UNLIMITED):  # as it is, since it is evaluated very often
            return replace(found[0], spots=spots)
        combination = Combination(found, factor, *limits)
        return Spacing(combination, keys=combination.keys, costly=combination.costly, spots=spots)

    return at


def below_limits(at: SpacingAtScale, limits: Sequence[Spacing]) -> SpacingAtScale:
    """A spacing, at a scale, below limits that do not go with it."""

    def limited(scale: float | None) -> Spacing:
        given = at(scale)
        both = Combination((given, *limits))
        return Spacing(both, keys=both.keys, costly=both.costly, spots=given.spots)

    return limited
