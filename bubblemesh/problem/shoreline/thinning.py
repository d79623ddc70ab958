"""Points of one ring that stay, as a spacing can show its detail."""

from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple, Self

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers

DETAIL = 0.1  # spacings
SHORT = 0.5  # spacings: of points nearer to each other one is left out, where the detail is that of a spacing

SpacingAt = Callable[[Floats], Floats]


class ShoreDetail(NamedTuple):
    """Detail of a shore that is left out: a tenth of a spacing aside, and points that are too near to each other."""

    spacing: SpacingAt
    short: float = SHORT  # spacings

    @classmethod
    def of_length(cls, length: float) -> Self:
        """Detail that is a length everywhere, however near to each other points are."""
        return cls(lambda points: np.full(len(points), length / DETAIL), 0.0)


def thinned(ring: Floats, fixed: Booleans, spacing: Floats, short: float) -> Integers:
    """Numbers (k,) of points of a ring (n, 2), so that others are off by a tenth of the spacing (n,) at each at most.

    By Douglas and Peucker, between points that stay: those fixed, and two that are far from each other. Then those are
    left out that are nearer to the last one than ``short`` spacings.
    """
    n, allowed = len(ring), DETAIL * spacing
    far = int(np.argmax(((ring - ring[0]) ** 2).sum(axis=1)))
    stay = np.flatnonzero(fixed) if fixed.sum() > 1 else np.unique([0, far, *np.flatnonzero(fixed).tolist()])
    kept = np.zeros(n, bool)
    kept[stay] = True
    around, tolerance = np.vstack([ring, ring]), np.append(allowed, allowed)
    spans = list(pairwise([*stay.tolist(), int(stay[0]) + n]))
    while spans:
        first, last = spans.pop()
        if last - first < 2:
            continue
        inner = around[first + 1 : last]
        off = _distances(inner, around[first], around[last]) / tolerance[first + 1 : last]
        worst = int(np.argmax(off))
        if off[worst] > 1:
            middle = first + 1 + worst
            kept[middle % n] = True
            spans += [(first, middle), (middle, last)]
    if short:
        kept[stay] = False
        kept[_near(ring, np.flatnonzero(kept), stay, short * spacing)] = False
        kept[stay] = True
    return np.flatnonzero(kept)


def _near(ring: Floats, points: Integers, stay: Integers, least: Floats) -> list[int]:
    """Numbers of those of some points (k,) of a ring (n, 2) that are too near to others that are kept.

    They are nearer than the least distance (n,) to the one kept before, or to the next of those that ``stay``.
    """
    near, last = list[int](), ring[stay[-1]]
    following = ring[stay[np.searchsorted(stay, points) % len(stay)]]
    both = np.sort(np.concatenate([points, stay])).tolist()
    ahead = dict(zip(points.tolist(), following, strict=True))
    for k in both:
        if k in ahead and min(np.hypot(*(ring[k] - last)), np.hypot(*(ring[k] - ahead[k]))) < least[k]:
            near.append(k)
        else:
            last = ring[k]
    return near


def _distances(points: Floats, start: Floats, end: Floats) -> Floats:
    """Distances (n,) of points (n, 2) from a segment."""
    along = end - start
    square = float(along @ along)
    t = np.clip((points - start) @ along / square, 0, 1) if square > 0 else np.zeros(len(points))
    return np.hypot(*(points - start - t[:, None] * along).T)
