"""Cubics that follow curves along their chords, from which distances are computed without evaluating the curves."""

from typing import NamedTuple, Self

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, select

STEPS = 3
FOOT_BEYOND = 0.6  # of a chord's length: beside a corner of the chords the foot may be half-way along the next one
LEAST_SLOPE = 0.05  # in Newton's method: towards the centre of curvature the slope vanishes


class Bulges(NamedTuple):
    """Hermite cubics above chords, with the directions of the curves at both ends; errors are of fourth order.

    A chord has a start, a direction and a length; heights are to its left.
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

        low, high = np.where(begins, 0, -FOOT_BEYOND * length), np.where(ends, length, (1 + FOOT_BEYOND) * length)
        return cls(start, direction, length, slope(before), slope(after), low, high)

    @property
    def rows(self) -> Floats:
        """The columns side by side (c, 9)."""
        return np.column_stack(self)

    def distances(self, points: Floats, of: Integers) -> Floats:
        """Distances (k,) of points (k, 2) from some of the curves (k,), which they are nearest to, made in NumPy."""
        mine = select(self, of)
        along, above = mine._seen(points)
        at = mine._feet(along, above)
        return np.sqrt((at - along) ** 2 + (mine._heights(at) - above) ** 2)

    def feet(self, points: Floats, of: Integers) -> tuple[Floats, Floats]:
        """Nearest points (k, 2) to points (k, 2) on some of the curves (k,), and unit tangents (k, 2) there."""
        mine = select(self, of)
        at = mine._feet(*mine._seen(points))
        dx, dy = mine.direction.T
        height = mine._heights(at)
        slope = mine._slopes(at)
        foot = mine.start + np.column_stack([at * dx - height * dy, at * dy + height * dx])
        tangent = np.column_stack([dx - slope * dy, dy + slope * dx])
        return foot, tangent / np.sqrt(1 + slope * slope)[:, None]

    def _seen(self, points: Floats) -> tuple[Floats, Floats]:
        """Where points (c, 2) are along the chords, and how far to their left."""
        (x, y), (dx, dy) = (points - self.start).T, self.direction.T
        return x * dx + y * dy, dx * y - dy * x

    @property
    def _powers(self) -> tuple[Floats, Floats, Floats]:
        """Factors of the cubic u (1 - u) (first (1 - u) - last u), at u lengths along, in powers of the length."""
        first, last, length = self.first, self.last, self.length
        return first, -(2 * first + last) / length, (first + last) / length**2

    def _heights(self, at: Floats) -> Floats:
        linear, square, cubic = self._powers
        return at * (linear + at * (square + at * cubic))

    def _slopes(self, at: Floats) -> Floats:
        linear, square, cubic = self._powers
        return linear + at * (2 * square + 3 * cubic * at)

    def _feet(self, along: Floats, above: Floats) -> Floats:
        """Places (c,) along the chords where the way to points seen there is square to the cubic: Newton's method."""
        linear, square, cubic = self._powers
        at = np.clip(along, 0, self.length)
        for _ in range(STEPS):
            height = at * (linear + at * (square + at * cubic)) - above
            slope = linear + at * (2 * square + 3 * cubic * at)
            steepness = 1 + slope * slope + height * (2 * square + 6 * cubic * at)
            at = np.clip(at - (at - along + height * slope) / np.maximum(steepness, LEAST_SLOPE), self.low, self.high)
        return at
