"""Checks of spacings that are given as values at places."""

from collections.abc import Callable

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import CaseError

__all__ = ["require_positive"]


def require_positive(values: Floats, where: Callable[[int], str]) -> None:
    """Refuse values (n,) that are no spacings; ``where`` tells the place of one by its number.

    Raises
    ------
    CaseError
        With the first such value and its place.
    """
    bad = np.flatnonzero(~(np.isfinite(values) & (values > 0)))
    if len(bad):
        more = len(bad) - 1
        several = f", and {more} more {'value is' if more == 1 else 'values are'} as bad" if more else ""
        raise CaseError(f"is {values[bad[0]]:g} {where(int(bad[0]))}{several}: a spacing has to be positive and finite")
