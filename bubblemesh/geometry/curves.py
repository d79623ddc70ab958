"""Smooth curves by arc length, evaluated many at a time.

A family holds n curves of one kind as arrays. Its methods take the index of a curve within the family and an
arc length for each of m points, so that one call serves the bubbles of every curve.
"""

from collections.abc import Sequence
from dataclasses import fields
from functools import cached_property
from typing import Any, NamedTuple, Protocol, cast

import numpy as np

from bubblemesh.arrays import TINY, Floats, Integers, members, side_by_side, taken
from bubblemesh.geometry.cubic_splines import CubicSpline
from bubblemesh.records import record

CHORDS_PER_TURN = 256
FEWEST_CHORDS = 8  # of an arc, or a part of another curve
LEAST_CHORDS = 64  # of any other curve
KNOT_PANELS = 64  # of the arc length table between two knots of a spline
LARGEST_ASPECT = 256  # of an ellipse, up to which its table resolves the ends
# Gauss and Legendre's rule of 5 nodes on [-1, 1], as NumPy's `leggauss` gives it.
GAUSS_NODES = np.array([-0.906179845938664, -0.5384693101056831, 0.0, 0.5384693101056831, 0.906179845938664])
GAUSS_WEIGHTS = np.array(
    [0.23692688505618928, 0.4786286704993663, 0.5688888888888887, 0.4786286704993663, 0.23692688505618928]
)


class Family(Protocol):
    """Curves of one kind, as a boundary uses them."""

    @property
    def lengths(self) -> Floats:
        """Lengths (n,) of the curves, same unit as the domain."""

    @property
    def exact(self) -> bool:
        """Whether chords between the stations are the curves themselves."""

    def stations(self) -> tuple[Integers, Floats]:
        """Curves (c,) and arc lengths (c,) at which chords begin that follow them to about 1e-4 of their radius."""

    def points(self, index: Integers, s: Floats) -> Floats:
        """Points (m, 2) at arc length ``s`` (m,) of the curves ``index`` (m,)."""

    def tangents(self, index: Integers, s: Floats) -> Floats:
        """Unit tangents (m, 2) in the direction of growing arc length."""

    def places(self, index: Integers, s: Floats) -> tuple[Floats, Floats]:
        """Points and unit tangents, both (m, 2), as of the two above."""


class _InClosedForm:
    """Curves whose points and tangents have nothing in common that takes long."""

    def places(self: Family, index: Integers, s: Floats) -> tuple[Floats, Floats]:
        return self.points(index, s), self.tangents(index, s)


@record
class Lines(_InClosedForm):
    """Straight lines from ``start`` (n, 2) to ``end`` (n, 2)."""

    start: Floats
    end: Floats

    exact = True

    @cached_property
    def lengths(self) -> Floats:
        return np.hypot(*(self.end - self.start).T)

    def stations(self) -> tuple[Integers, Floats]:
        return np.arange(len(self.start)), np.zeros(len(self.start))

    def points(self, index: Integers, s: Floats) -> Floats:
        start, end = taken(self.start, index), taken(self.end, index)
        return start + (s / self.lengths[index])[:, None] * (end - start)

    def tangents(self, index: Integers, s: Floats) -> Floats:
        return (taken(self.end, index) - taken(self.start, index)) / self.lengths[index][:, None]


@record
class Arcs(_InClosedForm):
    """Circular arcs: ``center`` (n, 2), ``radius`` (n,), first ``angle`` (n,) and signed ``sweep`` (n,) in radians."""

    center: Floats
    radius: Floats
    angle: Floats
    sweep: Floats

    exact = False

    @property
    def lengths(self) -> Floats:
        return np.abs(self.sweep) * self.radius

    def stations(self) -> tuple[Integers, Floats]:
        turns = np.abs(self.sweep) / (2 * np.pi)
        chords = np.maximum(np.ceil(turns * CHORDS_PER_TURN), FEWEST_CHORDS).astype(int)
        curve, rank = members(chords)
        return curve, rank * (self.lengths / chords)[curve]

    def _angles(self, index: Integers, s: Floats) -> Floats:
        return self.angle[index] + np.sign(self.sweep[index]) * s / self.radius[index]

    def points(self, index: Integers, s: Floats) -> Floats:
        a = self._angles(index, s)
        return self.center[index] + self.radius[index, None] * side_by_side(np.cos(a), np.sin(a))

    def tangents(self, index: Integers, s: Floats) -> Floats:
        a = self._angles(index, s)
        return np.sign(self.sweep[index])[:, None] * side_by_side(-np.sin(a), np.cos(a))


class Shares(NamedTuple):
    """Increasing shares of [0, 1] of n curves, one curve after the other, for one search over all of them."""

    first: Integers  # (n + 1,), row of each curve's first share
    keys: Floats  # number of the curve plus the share

    @classmethod
    def of(cls, shares: Sequence[Floats]) -> "Shares":
        return cls(np.cumsum([0, *map(len, shares)]), np.concatenate([k + share for k, share in enumerate(shares)]))

    @classmethod
    def of_table(cls, rising: Floats) -> "Shares":
        """Shares of the last one of each row (n, k) of rising numbers, which begin with 0."""
        count, most = rising.shape
        keys = rising / rising[:, -1:] + np.arange(count)[:, None]
        return cls(np.arange(count + 1) * most, keys.ravel())

    def before(self, index: Integers, share: Floats) -> Integers:
        """Row (m,) from which on the curve ``index`` (m,) holds ``share`` (m,); it is never the curve's last one."""
        row = np.searchsorted(self.keys, index + share, side="right") - 1
        return np.minimum(np.maximum(row, self.first[index]), self.first[index + 1] - 2)


@record
class TabulatedCurves:
    """Curves with a parameter u in [0, 1] whose arc length has no closed form: s and du/ds are tabulated over u."""

    exact = False

    @property
    def _columns(self) -> tuple[Floats, Floats, Floats]:
        """Arc length, u and du/ds at the ends of the panels of all curves, one curve after the other."""
        raise NotImplementedError

    @property
    def _shares(self) -> Shares:
        """Arc lengths in the columns as shares of the curves' lengths."""
        raise NotImplementedError

    @property
    def lengths(self) -> Floats:
        raise NotImplementedError

    def _position(self, index: Integers, u: Floats) -> Floats:
        raise NotImplementedError

    def _derivative(self, index: Integers, u: Floats) -> Floats:
        raise NotImplementedError

    def _parameter(self, index: Integers, s: Floats) -> Floats:
        """u (m,) at arc length s (m,): cubic Hermite interpolation of the table."""
        j = self._shares.before(index, s / self.lengths[index])
        along, parameter, slope = self._columns
        h = along[j + 1] - along[j]
        t = (s - along[j]) / h
        u0, u1 = parameter[j], parameter[j + 1]
        m0, m1 = h * slope[j], h * slope[j + 1]
        return u0 + t * (m0 + t * (3 * (u1 - u0) - 2 * m0 - m1 + t * (2 * (u0 - u1) + m0 + m1)))

    def points(self, index: Integers, s: Floats) -> Floats:
        return self._position(index, self._parameter(index, s))

    def tangents(self, index: Integers, s: Floats) -> Floats:
        return self._tangents(index, self._parameter(index, s))

    def places(self, index: Integers, s: Floats) -> tuple[Floats, Floats]:
        u = self._parameter(index, s)
        return self._position(index, u), self._tangents(index, u)

    def _tangents(self, index: Integers, u: Floats) -> Floats:
        derivative = self._derivative(index, u)
        return derivative / np.hypot(*derivative.T)[:, None]


@record
class _TabulatedEach(TabulatedCurves):
    """Curves that each have a table of its own length."""

    @cached_property
    def _tables(self) -> list[tuple[Floats, Floats, Floats]]:
        """Arc length (Gauss quadrature), u and du/ds at the ends of the panels of each curve."""
        ends = [self._panels(k) for k in range(len(self))]
        counts = np.array([len(u) for u in ends])
        numbers = np.arange(len(ends))
        starts = np.concatenate([u[:-1] for u in ends])
        widths = np.concatenate([np.diff(u) for u in ends])
        inner = starts[:, None] + widths[:, None] * (GAUSS_NODES + 1) / 2
        speed = self._speed_within(np.repeat(numbers, counts - 1), inner)
        slope = 1 / self._speed(np.repeat(numbers, counts), np.concatenate(ends))
        cuts = np.cumsum(counts)[:-1]
        parts = (np.split(column, cuts - numbers[1:]) for column in (speed, widths))
        along = (np.append(0, np.cumsum(v @ GAUSS_WEIGHTS * w / 2)) for v, w in zip(*parts, strict=True))
        return list(zip(along, ends, np.split(slope, cuts), strict=True))

    @cached_property
    def _columns(self) -> tuple[Floats, Floats, Floats]:
        """The tables of all curves, one after the other."""
        s, u, slope = (np.concatenate(parts) for parts in zip(*self._tables, strict=True))
        return s, u, slope

    @cached_property
    def _shares(self) -> Shares:
        """Arc lengths in the tables as shares of the curves' lengths."""
        return Shares.of([s / s[-1] for s, _, _ in self._tables])

    @cached_property
    def lengths(self) -> Floats:
        return np.array([s[-1] for s, _, _ in self._tables])

    def lengths_at(self, k: int) -> Floats:
        """Arc lengths of curve k at the ends of its panels."""
        return self._tables[k][0]

    def __len__(self) -> int:
        raise NotImplementedError

    def _panels(self, k: int) -> Floats:
        """Increasing values of u from 0 to 1 between which the speed of curve k is nearly a polynomial."""
        raise NotImplementedError

    def _least_chords(self, k: int) -> int:
        """Number of chords that curve k would have if it were straight."""
        return LEAST_CHORDS

    def stations(self) -> tuple[Integers, Floats]:
        return self._all_stations

    @cached_property
    def _all_stations(self) -> tuple[Integers, Floats]:
        # Short chords where the curvature is high, so that every chord turns as far and none is too long.
        parts = [self._stations(k, turns) for k, turns in enumerate(self._turns())]
        curve = np.repeat(np.arange(len(parts)), [len(part) for part in parts])
        return curve, np.concatenate(parts)

    def _turns(self) -> list[Floats]:
        """By how much each curve turns within each of its panels, as parts of a full turn."""
        _, ends, _ = self._columns
        counts = np.array([len(u) for _, u, _ in self._tables])
        tangents = self._derivative(np.repeat(np.arange(len(counts)), counts), ends)
        within = np.abs(turning(tangents[:-1], tangents[1:]))
        return [
            turns[: count - 1] for turns, count in zip(np.split(within, np.cumsum(counts)[:-1]), counts, strict=True)
        ]

    def _stations(self, k: int, turns: Floats) -> Floats:
        s, _, _ = self._tables[k]
        turned = np.cumsum(np.append(0, turns)) / (2 * np.pi)
        weight = CHORDS_PER_TURN * turned + self._least_chords(k) * np.linspace(0, 1, len(s))
        chords = int(np.ceil(weight[-1]))
        return np.interp(np.arange(chords) / chords * weight[-1], weight, s)

    def _speed(self, index: Integers, u: Floats) -> Floats:
        return np.hypot(*self._derivative(index, u).T)

    def _speed_within(self, index: Integers, u: Floats) -> Floats:
        """Speeds (p, 5) of curves ``index`` (p,) at parameters u (p, 5) within their panels, which come in order."""
        return self._speed(np.repeat(index, u.shape[1]), u.ravel()).reshape(u.shape)


@record
class Ellipses(_TabulatedEach):
    """Whole ellipses: ``center``, ``radii`` (n, 2), ``angle`` (n,) of the first axis and ``turn`` (n,), +1 or -1."""

    center: Floats
    radii: Floats
    angle: Floats
    turn: Floats

    def __len__(self) -> int:
        return len(self.center)

    def _panels(self, k: int) -> Floats:
        aspect = self.radii[k].max() / self.radii[k].min()
        return np.linspace(0, 1, int(256 * np.ceil(min(aspect, LARGEST_ASPECT))) + 1)

    def _rotated(self, index: Integers, along: Floats, across: Floats) -> Floats:
        c, s = np.cos(self.angle[index]), np.sin(self.angle[index])
        along, across = self.radii[index, 0] * along, self.radii[index, 1] * across
        return side_by_side(c * along - s * across, s * along + c * across)

    def _position(self, index: Integers, u: Floats) -> Floats:
        a = 2 * np.pi * self.turn[index] * u
        return self.center[index] + self._rotated(index, np.cos(a), np.sin(a))

    def _derivative(self, index: Integers, u: Floats) -> Floats:
        rate = 2 * np.pi * self.turn[index]
        return rate[:, None] * self._rotated(index, -np.sin(rate * u), np.cos(rate * u))


@record
class Splines(_TabulatedEach):
    """Cubic splines, parametrised by chord length."""

    splines: Sequence[CubicSpline]
    panels: int = KNOT_PANELS  # of the arc length table between two knots

    @cached_property
    def _breaks(self) -> Shares:
        """Parameters at the knots, between which the splines are cubic."""
        return Shares.of([spline.breaks for spline in self.splines])

    @cached_property
    def _coefficients(self) -> Floats:
        return np.concatenate([spline.coefficients for spline in self.splines], axis=1)

    def __len__(self) -> int:
        return len(self.splines)

    def _least_chords(self, k: int) -> int:
        return max(LEAST_CHORDS, len(self.splines[k].breaks) - 1)

    def _panels(self, k: int) -> Floats:
        breaks = self._breaks.keys[self._breaks.first[k] : self._breaks.first[k + 1]] - k
        ends = np.arange(self.panels * (len(breaks) - 1) + 1) / self.panels
        return np.interp(ends, np.arange(len(breaks)), breaks)

    def _local(self, index: Integers, u: Floats) -> tuple[Integers, Floats]:
        """Rows (m,) of the coefficients of the cubic pieces that hold u, and u - their first breaks (m, 1)."""
        row = self._breaks.before(index, np.clip(u, 0, 1))
        return row - index, (u - (self._breaks.keys[row] - index))[:, None]

    def _position(self, index: Integers, u: Floats) -> Floats:
        row, t = self._local(index, u)
        c = self._coefficients.take(row, axis=1)
        return ((c[0] * t + c[1]) * t + c[2]) * t + c[3]

    def _derivative(self, index: Integers, u: Floats) -> Floats:
        row, t = self._local(index, u)
        c = self._coefficients[:3].take(row, axis=1)
        return (3 * c[0] * t + 2 * c[1]) * t + c[2]

    def _speed_within(self, index: Integers, u: Floats) -> Floats:
        # The pieces that hold the panels are known: no search, and one row of coefficients for many parameters.
        first = np.delete(np.arange(len(self._breaks.keys)), self._breaks.first[1:] - 1)
        begins = self._breaks.keys[first] - index[:: self.panels]
        t = u.reshape(len(begins), -1) - begins[:, None]
        columns = (self._coefficients[:3, :, None, k] for k in range(2))
        return np.hypot(*((3 * c[0] * t + 2 * c[1]) * t + c[2] for c in columns)).reshape(u.shape)


@record
class Polylines(_InClosedForm):
    """Polylines through ``vertices``, one array (k, 2) each, whose tangents jump at them."""

    vertices: Sequence[Floats]

    exact = True

    @cached_property
    def _points(self) -> Floats:
        return np.concatenate(list(self.vertices))

    @cached_property
    def _along(self) -> list[Floats]:
        """Arc length at each vertex of each polyline."""
        return [np.cumsum(np.append(0, np.hypot(*np.diff(v, axis=0).T))) for v in self.vertices]

    @cached_property
    def _s(self) -> Floats:
        return np.concatenate(self._along)

    @cached_property
    def _shares(self) -> Shares:
        """Arc lengths at the vertices as shares of the polylines' lengths."""
        return Shares.of([s / s[-1] for s in self._along])

    @cached_property
    def lengths(self) -> Floats:
        return np.array([s[-1] for s in self._along])

    def stations(self) -> tuple[Integers, Floats]:
        curve, rank = members(np.diff(self._shares.first) - 1)
        return curve, self._s[self._shares.first[curve] + rank]

    def points(self, index: Integers, s: Floats) -> Floats:
        j = self._shares.before(index, s / self.lengths[index])
        share = (s - self._s[j]) / (self._s[j + 1] - self._s[j])
        return self._points[j] + share[:, None] * (self._points[j + 1] - self._points[j])

    def tangents(self, index: Integers, s: Floats) -> Floats:
        j = self._shares.before(index, s / self.lengths[index])
        return (self._points[j + 1] - self._points[j]) / (self._s[j + 1] - self._s[j])[:, None]


def selected(family: Family, which: Integers) -> Family:
    """The curves ``which`` (k,) of a family, as a family of their own."""

    def kept(column: Any) -> Any:
        if isinstance(column, int):  # it is for all curves
            return column
        return column[which] if isinstance(column, np.ndarray) else [column[k] for k in which.tolist()]

    columns = {field.name: kept(getattr(family, field.name)) for field in fields(cast(Any, family))}
    return type(family)(**columns)


def turning(before: Floats, after: Floats) -> Floats:
    """Signed angles (m,) in radians from the directions ``before`` (m, 2) to ``after`` (m, 2), positive to the left."""
    (ax, ay), (bx, by) = before.T, after.T
    return np.arctan2(ax * by - ay * bx, ax * bx + ay * by)


def shares_before(points: Floats, start: Floats, end: Floats) -> Floats:
    """Shares (...) of straight lines (..., 2) before the places on them that are nearest to points (..., 2)."""
    along, ahead = end - start, points - start
    x, y = along[..., 0], along[..., 1]
    share = (ahead[..., 0] * x + ahead[..., 1] * y) / np.maximum(x * x + y * y, TINY)
    return np.minimum(np.maximum(share, 0.0), 1.0)
