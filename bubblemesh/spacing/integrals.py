"""Integrals that count nodes: a spacing that is linear over each of many parts, divided where it is not."""

from dataclasses import replace
from typing import Protocol, Self

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, taken
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.meshes.edges import numbered_edges
from bubblemesh.meshes.quality import doubled_areas
from bubblemesh.records import record
from bubblemesh.spacing.cover import Cover
from bubblemesh.spacing.spacing import Spacing

ALIKE = 1e-6  # relative difference of spacings that are one: the error is that of its square


class IntegralParts(Protocol):
    """Parts of a domain or of its boundary, with the spacing at their ends."""

    def nodes(self) -> Floats:
        """Nodes (k,) that a perfect packing has on each part, if the spacing is linear over it."""

    def divided(self) -> Self:
        """The parts of half their size: all first ones, then all second ones, and so on."""

    def select(self, which: Booleans) -> Self:
        """Selected parts (k,)."""


@record
class Triangles:
    """Triangles with the spacing at their corners."""

    spacing: Spacing
    points: Floats  # (n, 2)
    d: Floats  # (n,): at the points
    corners: Integers  # (t, 3)

    @classmethod
    def of(cls, cover: Cover, spacing: Spacing) -> "Triangles":
        """Triangles of a cover."""
        return cls(spacing, cover.points, spacing(cover.points), cover.triangles)

    def nodes(self) -> Floats:
        """Nodes (t,) in each triangle: the integral of 2 / (sqrt(3) d^2)."""
        areas = np.abs(doubled_areas(taken(self.points, self.corners))) / 2
        return 2 / np.sqrt(3) * areas * mean_inverse_square(self.d[self.corners])

    def divided(self) -> "Triangles":
        """Quarters between the corners and the middles of the edges."""
        edges, number = numbered_edges(self.corners)
        middles = (taken(self.points, edges[:, 0]) + taken(self.points, edges[:, 1])) / 2
        (a, b, c), (ab, bc, ca) = self.corners.T, (number + len(self.points)).T
        quarters = [a, ab, ca, ab], [ab, b, bc, bc], [ca, bc, c, ca]  # columns of their corners
        return Triangles(
            self.spacing,
            np.vstack([self.points, middles]),
            np.append(self.d, self.spacing(middles)),
            np.stack([np.concatenate(column) for column in quarters], axis=1),
        )

    def select(self, which: Booleans) -> "Triangles":
        """Selected triangles (t,)."""
        return replace(self, corners=taken(self.corners, which))


@record
class Intervals:
    """Intervals of the boundary with the spacing at their ends."""

    spacing: Spacing
    boundary: Boundary
    piece: Integers  # (k,)
    begin: Floats  # (k,): arc lengths
    end: Floats  # (k,)
    first: Floats  # (k,): spacing at the begin
    last: Floats  # (k,): at the end

    @classmethod
    def of(cls, cover: Cover, spacing: Spacing, boundary: Boundary) -> "Intervals":
        """Intervals of a cover."""
        piece, begin, end = cover.intervals.T
        piece = piece.astype(np.int64)
        first, last = (spacing.along(boundary, piece, s) for s in (begin, end))
        return cls(spacing, boundary, piece, begin, end, first, last)

    def nodes(self) -> Floats:
        """Nodes (k,) of each interval beside those of the area: the integral of 1 / (2 d)."""
        return (self.end - self.begin) * mean_inverse(self.first, self.last) / 2

    def divided(self) -> "Intervals":
        """Halves."""
        middle = (self.begin + self.end) / 2
        d = self.spacing.along(self.boundary, self.piece, middle)
        return replace(
            self,
            piece=np.concatenate([self.piece, self.piece]),
            begin=np.concatenate([self.begin, middle]),
            end=np.concatenate([middle, self.end]),
            first=np.concatenate([self.first, d]),
            last=np.concatenate([d, self.last]),
        )

    def select(self, which: Booleans) -> "Intervals":
        """Selected intervals (k,)."""
        return replace(
            self,
            piece=self.piece[which],
            begin=self.begin[which],
            end=self.end[which],
            first=self.first[which],
            last=self.last[which],
        )


def mean_inverse(a: Floats, b: Floats) -> Floats:
    """Mean (k,) of 1 / d where d changes linearly from a (k,) to b (k,): ln(b / a) / (b - a)."""
    rise = (b - a) / a
    same, lost = rise == 0, np.flatnonzero(rise == -1)  # where b is as nothing beside a
    change = rise.copy()
    change[lost] = 0.0
    np.log1p(change, out=change)
    change[lost] = np.log(b[lost]) - np.log(a[lost])
    return np.where(same, 1.0, change) / np.where(same, a, rise * a)


def mean_inverse_square(d: Floats) -> Floats:
    """Mean (t,) of 1 / d^2 over triangles in which d is linear between its values d (t, 3) at the corners.

    It is twice the divided difference of -ln d at these, by the formula of Hermite and Genocchi (C. de Boor, "Divided
    differences", Surveys in Approximation Theory 1, 2005).
    """
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):  # no nodes, or more than any limit
        low, middle, high = _ascending(*d.T)
        alike = high - low <= ALIKE * low
        differences = mean_inverse(low, middle) - mean_inverse(middle, high)
        return np.where(alike, 1 / middle**2, 2 * differences / np.where(alike, 1.0, high - low))


def _ascending(a: Floats, b: Floats, c: Floats) -> tuple[Floats, Floats, Floats]:
    """The least, middle and largest (t,) of three values each; six times as fast as sorting rows of three."""
    low, high = np.minimum(a, b), np.maximum(a, b)
    return np.minimum(low, c), np.maximum(low, np.minimum(high, c)), np.maximum(high, c)
