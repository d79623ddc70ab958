"""Spacings that are given as values at places: checks, and where they are fine."""

from collections.abc import Callable

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import CaseError

STEEP = 0.1  # growth per length: around spots from which it is slower, samples see it
MOST = 2000  # more are noise


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


def spots(points: Floats, first: Integers, last: Integers, values: Floats) -> Floats:
    """Points (k, 2), among points (n, 2), from which the ``values`` (n,) rise steeply, and fall nowhere.

    Neighbours are the points ``first`` (e,) and ``last`` (e,). Of more than can be spots the finest are given.
    """
    rise = (values[last] - values[first]) / np.hypot(*(points[last] - points[first]).T)
    least, steepest = np.full(len(points), np.inf), np.full(len(points), -np.inf)
    for node, change in ((first, rise), (last, -rise)):
        np.minimum.at(least, node, change)
        np.maximum.at(steepest, node, change)
    found = np.flatnonzero((least >= 0) & (steepest > STEEP))
    return points[found[np.argsort(values[found], kind="stable")[:MOST]]]
