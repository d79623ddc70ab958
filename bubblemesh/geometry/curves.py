"""Smooth curves by arc length, evaluated many at a time.

A family holds n curves of one kind as arrays. Its methods take the index of a curve within the family and an
arc length for each of m points, so that one call serves the bubbles of every curve.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from scipy.interpolate import CubicHermiteSpline, CubicSpline

from bubblemesh.arrays import Floats, Integers

__all__ = ["Arcs", "Ellipses", "Family", "Lines", "Splines"]

TABLE_PANELS = 512  # arc length of a tabulated curve is then good to about 1e-10 of its length
GAUSS_NODES, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(5)


class Family(Protocol):
    """What a boundary asks of the curves of one kind."""

    @property
    def lengths(self) -> Floats:
        """Lengths (n,) of the curves, same unit as the domain."""

    @property
    def pieces(self) -> Integers:
        """Numbers (n,) of chords that follow each curve to about 1e-4 of its radius of curvature."""

    def points(self, index: Integers, s: Floats) -> Floats:
        """Points (m, 2) at arc length ``s`` (m,) of the curves ``index`` (m,)."""

    def tangents(self, index: Integers, s: Floats) -> Floats:
        """Unit tangents (m, 2) in the direction of growing arc length."""


@dataclass(frozen=True)
class Lines:
    """Straight lines from ``start`` (n, 2) to ``end`` (n, 2)."""

    start: Floats
    end: Floats

    @property
    def lengths(self) -> Floats:
        return np.hypot(*(self.end - self.start).T)

    @property
    def pieces(self) -> Integers:
        return np.ones(len(self.start), int)

    def points(self, index: Integers, s: Floats) -> Floats:
        start, end = self.start[index], self.end[index]
        return start + (s / self.lengths[index])[:, None] * (end - start)

    def tangents(self, index: Integers, s: Floats) -> Floats:
        return ((self.end - self.start) / self.lengths[:, None])[index]


@dataclass(frozen=True)
class Arcs:
    """Circular arcs: ``center`` (n, 2), ``radius`` (n,), first ``angle`` (n,) and signed ``sweep`` (n,) in radians."""

    center: Floats
    radius: Floats
    angle: Floats
    sweep: Floats

    @property
    def lengths(self) -> Floats:
        return np.abs(self.sweep) * self.radius

    @property
    def pieces(self) -> Integers:
        return np.ceil(np.abs(self.sweep) / (2 * np.pi) * 256).astype(int)

    def _angles(self, index: Integers, s: Floats) -> Floats:
        return self.angle[index] + np.sign(self.sweep[index]) * s / self.radius[index]

    def points(self, index: Integers, s: Floats) -> Floats:
        a = self._angles(index, s)
        return self.center[index] + self.radius[index, None] * np.column_stack([np.cos(a), np.sin(a)])

    def tangents(self, index: Integers, s: Floats) -> Floats:
        a = self._angles(index, s)
        return np.sign(self.sweep[index])[:, None] * np.column_stack([-np.sin(a), np.cos(a)])


@dataclass(frozen=True)
class _Tabulated:
    """Curves with a parameter u in [0, 1] whose arc length has no closed form: u is tabulated over arc length."""

    lengths: Floats = field(init=False)
    _u: Floats = field(init=False, repr=False)
    _slope: Floats = field(init=False, repr=False)

    def __post_init__(self) -> None:
        tables = [self._table(k) for k in range(len(self))]
        for name, column in zip(("lengths", "_u", "_slope"), zip(*tables, strict=True), strict=True):
            object.__setattr__(self, name, np.array(column))

    def __len__(self) -> int:
        raise NotImplementedError

    def _position(self, index: Integers, u: Floats) -> Floats:
        raise NotImplementedError

    def _derivative(self, index: Integers, u: Floats) -> Floats:
        raise NotImplementedError

    def _table(self, k: int) -> tuple[float, Floats, Floats]:
        """Length of curve k, u at equidistant arc lengths, and du/ds there (Gauss quadrature, Hermite inversion)."""
        edges = np.linspace(0, 1, TABLE_PANELS + 1)
        inner = edges[:-1, None] + (GAUSS_NODES + 1) / (2 * TABLE_PANELS)
        speed = self._speed(k, inner.ravel()).reshape(inner.shape)
        s = np.concatenate([[0], np.cumsum(speed @ GAUSS_WEIGHTS) / (2 * TABLE_PANELS)])
        u = CubicHermiteSpline(s, edges, 1 / self._speed(k, edges))(np.linspace(0, s[-1], TABLE_PANELS + 1))
        u[0], u[-1] = 0, 1
        return float(s[-1]), u, 1 / self._speed(k, u)

    def _speed(self, k: int, u: Floats) -> Floats:
        return np.hypot(*self._derivative(np.full(len(u), k), u).T)

    def _parameter(self, index: Integers, s: Floats) -> Floats:
        """u (m,) at arc length s (m,): cubic Hermite interpolation of the table."""
        h = self.lengths[index] / TABLE_PANELS
        j = np.clip((s / h).astype(int), 0, TABLE_PANELS - 1)
        t = s / h - j
        u0, u1 = self._u[index, j], self._u[index, j + 1]
        m0, m1 = h * self._slope[index, j], h * self._slope[index, j + 1]
        return u0 + t * (m0 + t * (3 * (u1 - u0) - 2 * m0 - m1 + t * (2 * (u0 - u1) + m0 + m1)))

    def points(self, index: Integers, s: Floats) -> Floats:
        return self._position(index, self._parameter(index, s))

    def tangents(self, index: Integers, s: Floats) -> Floats:
        derivative = self._derivative(index, self._parameter(index, s))
        return derivative / np.hypot(*derivative.T)[:, None]


@dataclass(frozen=True)
class Ellipses(_Tabulated):
    """Whole ellipses: ``center``, ``radii`` (n, 2), ``angle`` (n,) of the first axis and ``turn`` (n,), +1 or -1."""

    center: Floats
    radii: Floats
    angle: Floats
    turn: Floats

    def __len__(self) -> int:
        return len(self.center)

    @property
    def pieces(self) -> Integers:
        # Chords are equal in length, but curvature peaks at the ends of the long axis.
        aspect = self.radii.max(axis=1) / self.radii.min(axis=1)
        return np.ceil(256 * np.minimum(aspect, 64)).astype(int)

    def _rotated(self, index: Integers, along: Floats, across: Floats) -> Floats:
        c, s = np.cos(self.angle[index]), np.sin(self.angle[index])
        along, across = self.radii[index, 0] * along, self.radii[index, 1] * across
        return np.column_stack([c * along - s * across, s * along + c * across])

    def _position(self, index: Integers, u: Floats) -> Floats:
        a = 2 * np.pi * self.turn[index] * u
        return self.center[index] + self._rotated(index, np.cos(a), np.sin(a))

    def _derivative(self, index: Integers, u: Floats) -> Floats:
        rate = 2 * np.pi * self.turn[index]
        return rate[:, None] * self._rotated(index, -np.sin(rate * u), np.cos(rate * u))


@dataclass(frozen=True)
class Splines(_Tabulated):
    """Cubic splines through ``knots``, one array (k, 2) each, parametrised by chord length.

    The ends are "not-a-knot"; a spline whose last point is its first is periodic.
    """

    knots: Sequence[Floats]
    _breaks: Floats = field(init=False, repr=False)
    _offset: Integers = field(init=False, repr=False)
    _coefficients: Floats = field(init=False, repr=False)

    def __post_init__(self) -> None:
        splines = [_interpolated(points) for points in self.knots]
        sizes = [len(spline.x) - 1 for spline in splines]
        object.__setattr__(self, "_breaks", np.concatenate([k + spline.x[:-1] for k, spline in enumerate(splines)]))
        object.__setattr__(self, "_offset", np.concatenate([[0], np.cumsum(sizes)]))
        object.__setattr__(self, "_coefficients", np.concatenate([spline.c for spline in splines], axis=1))
        super().__post_init__()

    def __len__(self) -> int:
        return len(self.knots)

    @property
    def pieces(self) -> Integers:
        return 48 * np.diff(self._offset)

    def _local(self, index: Integers, u: Floats) -> tuple[Floats, Floats]:
        """Coefficients (4, m, 2) of the cubic piece that holds u, and u - its first break (m, 1)."""
        piece = np.searchsorted(self._breaks, index + np.clip(u, 0, 1), side="right") - 1
        piece = np.clip(piece, self._offset[index], self._offset[index + 1] - 1)
        return self._coefficients[:, piece], (u - (self._breaks[piece] - index))[:, None]

    def _position(self, index: Integers, u: Floats) -> Floats:
        c, t = self._local(index, u)
        return ((c[0] * t + c[1]) * t + c[2]) * t + c[3]

    def _derivative(self, index: Integers, u: Floats) -> Floats:
        c, t = self._local(index, u)
        return (3 * c[0] * t + 2 * c[1]) * t + c[2]


def _interpolated(points: Floats) -> CubicSpline:
    """Spline through ``points`` (k, 2) over [0, 1] by chord length."""
    u = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    periodic = len(points) > 3 and bool(np.all(points[0] == points[-1]))
    return CubicSpline(u / u[-1], points, bc_type="periodic" if periodic else "not-a-knot")
