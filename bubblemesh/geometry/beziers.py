"""Cubic Bézier curves by arc length; tables are made for all at once, as drawings have very many short curves."""

from functools import cached_property

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, members
from bubblemesh.geometry.curves import (
    CHORDS_PER_TURN,
    LEAST_CHORDS,
    Shares,
    TabulatedCurves,
    turning,
)
from bubblemesh.records import record

PANELS = 128  # of the arc length table of a curve
# Gauss and Legendre's rule of 3 nodes on [-1, 1], as NumPy's `leggauss` gives it.
GAUSS_NODES = np.array([-0.7745966692414834, 0.0, 0.7745966692414834])
GAUSS_WEIGHTS = np.array([0.5555555555555557, 0.8888888888888888, 0.5555555555555557])
SLOWEST = 0.1  # least speed of a regular curve, of its greatest one: a change that the table resolves


@record
class Beziers(TabulatedCurves):
    """Cubic Bézier curves with the control points ``start``, ``first``, ``second`` and ``end`` (n, 2)."""

    start: Floats
    first: Floats
    second: Floats
    end: Floats

    @property
    def regular(self) -> Booleans:
        """Mask (n,) of the curves whose speed is nowhere 0 or nearly so: only these can be followed by arc length."""
        speed = np.hypot(*self._rates(np.linspace(0, 1, PANELS + 1)))
        return np.asarray(speed.min(axis=1) > SLOWEST * speed.max(axis=1))

    @cached_property
    def _powers(self) -> Floats:
        """Coefficients (4, n, 2) of the powers of u, the highest first."""
        bend = self.start - 2 * self.first + self.second
        cubic = self.end - self.start + 3 * (self.first - self.second)
        return np.stack([cubic, 3 * bend, 3 * (self.first - self.start), self.start])

    def _rates(self, u: Floats) -> tuple[Floats, Floats]:
        """Derivatives by u of x and of y (n, k), of all curves at the same u (k,)."""
        a, b, c = self._powers[:3, :, :, None]
        x, y = (((3 * a * u + 2 * b) * u + c)[:, axis] for axis in range(2))
        return x, y

    @cached_property
    def _along(self) -> Floats:
        """Arc lengths (n, PANELS + 1) at the ends of the panels, by Gauss quadrature."""
        places = (np.arange(PANELS)[:, None] + (GAUSS_NODES + 1) / 2) / PANELS
        speed = np.hypot(*self._rates(places.ravel())).reshape(-1, PANELS, len(GAUSS_NODES))
        lengths = (speed * GAUSS_WEIGHTS).sum(axis=2) / (2 * PANELS)
        return np.cumsum(np.pad(lengths, ((0, 0), (1, 0))), axis=1)

    @cached_property
    def _columns(self) -> tuple[Floats, Floats, Floats]:
        u = np.linspace(0, 1, PANELS + 1)
        slope = 1 / np.hypot(*self._rates(u))
        return self._along.ravel(), np.tile(u, len(slope)), slope.ravel()

    @cached_property
    def _shares(self) -> Shares:
        return Shares.of_table(self._along)

    @cached_property
    def lengths(self) -> Floats:
        return self._along[:, -1]

    def stations(self) -> tuple[Integers, Floats]:
        """Curves (c,) and arc lengths (c,) at which chords begin, as in `Family`."""
        # Short chords where the curvature is high, so that every chord turns as far and none is too long.
        x, y = self._rates(np.linspace(0, 1, PANELS + 1))
        before, after = (np.stack([x[:, part], y[:, part]], axis=2).reshape(-1, 2) for part in (np.s_[:-1], np.s_[1:]))
        turns = np.abs(turning(before, after)).reshape(-1, PANELS) / (2 * np.pi)
        weight = np.cumsum(np.pad(CHORDS_PER_TURN * turns + LEAST_CHORDS / PANELS, ((0, 0), (1, 0))), axis=1)
        chords = np.ceil(weight[:, -1]).astype(np.int64)
        curve, rank = members(chords)
        share = rank / chords[curve]
        row = Shares.of_table(weight).before(curve, share)
        along, weight = self._columns[0], (weight / weight[:, -1:]).ravel()
        part = np.clip((share - weight[row]) / (weight[row + 1] - weight[row]), 0, 1)
        return curve, along[row] + part * (along[row + 1] - along[row])

    def _position(self, index: Integers, u: Floats) -> Floats:
        a, b, c, d = (column[index] for column in self._powers)
        t = u[:, None]
        return ((a * t + b) * t + c) * t + d

    def _derivative(self, index: Integers, u: Floats) -> Floats:
        a, b, c = (column[index] for column in self._powers[:3])
        t = u[:, None]
        return (3 * a * t + 2 * b) * t + c
