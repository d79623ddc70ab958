"""Curves along their chords as cubics, from which distances are taken without asking the curves."""

from typing import NamedTuple, Self

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, select

STEPS = 3
BEYOND = 0.6  # of a chord's length: beside a corner of the chords the foot may be half-way along the next one
FLATTEST = 0.05  # least slope in a projection: towards the centre of curvature it vanishes


class Bulges(NamedTuple):
    """Cubics above chords, with the directions of the curves at both ends (Hermite): off by the fourth power of these.

    A chord has its start, a direction and a length; heights are to its left.
    """

    start: Floats  # (c, 2)
    direction: Floats  # (c, 2), unit vectors
    length: Floats  # (c,)
    first: Floats  # (c,): slope at the start
    last: Floats  # (c,): slope at the end
    low: Floats  # (c,): least place along the chord of a foot
    high: Floats  # (c,): largest one

    @classmethod
    def of(cls, start: Floats, end: Floats, before: Floats, after: Floats, begins: Booleans, ends: Booleans) -> Self:
        """Bulges of curves between points (c, 2), with tangents there; some begin a piece with ends, some end it."""
        length = np.hypot(*(end - start).T)
        direction = (end - start) / length[:, None]

        def slope(tangent: Floats) -> Floats:
            (dx, dy), (tx, ty) = direction.T, tangent.T
            return np.asarray((dx * ty - dy * tx) / (dx * tx + dy * ty), float)

        low, high = np.where(begins, 0, -BEYOND * length), np.where(ends, length, (1 + BEYOND) * length)
        return cls(start, direction, length, slope(before), slope(after), low, high)

    def distances(self, points: Floats, of: Integers) -> Floats:
        """Distances (k,) of points (k, 2) from some of the curves (k,), which they are nearest to.

        Newton's method for the foot, where the way to the point is square to the cubic.
        """
        start, (dx, dy), length, first, last, low, high = (column.T for column in select(self, of))
        x, y = points.T - start
        along, above = x * dx + y * dy, dx * y - dy * x
        # The cubic is u (1 - u) (first (1 - u) - last u) at u lengths along.
        linear, square, cubic = first, -(2 * first + last) / length, (first + last) / length**2
        at = np.clip(along, 0, length)
        for _ in range(STEPS):
            height = at * (linear + at * (square + at * cubic)) - above
            slope = linear + at * (2 * square + 3 * cubic * at)
            steepness = 1 + slope * slope + height * (2 * square + 6 * cubic * at)
            at = np.clip(at - (at - along + height * slope) / np.maximum(steepness, FLATTEST), low, high)
        height = at * (linear + at * (square + at * cubic)) - above
        return np.sqrt((at - along) ** 2 + height * height)
