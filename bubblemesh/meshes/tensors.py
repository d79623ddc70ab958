"""Symmetric tensors in the plane, as rows (m11, m12, m22), and the axes of their ellipses."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import CaseError
from bubblemesh.kernels.tensors import lengths, mean_lengths, roots, seen_from
from bubblemesh.messages import place


class Axes(NamedTuple):
    """Axes of ellipses: the least and the largest spacing (n,), and unit vectors (n, 2) along the largest."""

    across: Floats
    along: Floats
    direction: Floats

    @property
    def tensors(self) -> Floats:
        """Tensors (n, 3) of the ellipses."""
        return of_axes(*self)

    @property
    def aspects(self) -> Floats:
        """Ratios (n,) of the largest to the least spacing."""
        with np.errstate(over="ignore"):
            return self.along / self.across

    @property
    def diameters(self) -> Floats:
        """Diameters (n,) of the circles of the same areas; NaN where there is no ellipse."""
        with np.errstate(invalid="ignore"):
            return np.where(self.across > 0, np.sqrt(self.across * self.along), np.nan)

    def times(self, factor: float | Floats) -> "Axes":
        """Ellipses whose sizes are multiplied by factors (n,), or all by the same factor."""
        return Axes(self.across * factor, self.along * factor, self.direction)

    def within(self, d: float | Floats) -> "Axes":
        """The largest ellipses within these and within circles of diameters d (n,), or all of the same."""
        return Axes(np.minimum(self.across, d), np.minimum(self.along, d), self.direction)

    def wider(self, aspect: float) -> "Axes":
        """Ellipses of the same length, widened where their aspect would be larger than the given one."""
        return Axes(np.maximum(self.across, self.along / aspect), self.along, self.direction)

    def shorter(self, share: Floats) -> "Axes":
        """Ellipses of the same width, with shares (n,) of their length."""
        return Axes(self.across, share * self.along, self.direction)


def edge_lengths(x: Floats, tensors: Floats, edges: Integers) -> Floats:
    """Lengths (m,) of edges (m, 2) between nodes x (n, 2) with tensors (n, 3)."""
    i, j = edges.T
    along = x[j] - x[i]
    return mean_lengths(lengths(tensors[i], along), lengths(tensors[j], along))


def determinants(tensors: Floats) -> Floats:
    """Determinants (n,) of tensors (n, 3)."""
    m11, m12, m22 = tensors.T
    return np.asarray(m11 * m22 - m12 * m12)


def area_sizes(tensors: Floats) -> Floats:
    """Diameters (n,) of the circles of the same area as the ellipses of tensors (n, 3); NaN for one without."""
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(tensors[:, 0] > 0, determinants(tensors), np.nan) ** -0.25


def axes(tensors: Floats) -> Axes:
    """Axes of the ellipses of positive tensors (n, 3); NaN for other tensors."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        strong, _, direction = eigen(tensors)
        weak = determinants(tensors) / strong  # the usual difference for the smaller eigenvalue would cancel
        return Axes(1 / np.sqrt(strong), 1 / np.sqrt(weak), direction)


def eigen(tensors: Floats) -> tuple[Floats, Floats, Floats]:
    """Larger and smaller eigenvalues (n,) of symmetric tensors (n, 3), and unit vectors (n, 2) of the smaller ones."""
    m11, m12, m22 = tensors.T
    half, apart = (m11 + m22) / 2, np.hypot((m11 - m22) / 2, m12)
    angle = np.arctan2(m12, (m11 - m22) / 2) / 2  # of the larger one
    return half + apart, half - apart, np.column_stack([-np.sin(angle), np.cos(angle)])


def of_axes(across: Floats, along: Floats, direction: Floats) -> Floats:
    """Tensors (n, 3) of spacings (n,) across and along unit vectors (n, 2)."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return symmetric(1 / across**2, 1 / along**2, direction)


def symmetric(across: Floats, along: Floats, direction: Floats) -> Floats:
    """Symmetric tensors (n, 3) with eigenvalues (n,) across and along unit vectors (n, 2)."""
    (tx, ty), a, b = direction.T, along, across
    result = np.empty((len(a), 3))  # filled in place, for speed: metrics are evaluated thousands of times
    result[:, 0] = a * tx * tx + b * ty * ty
    result[:, 1] = (a - b) * tx * ty
    result[:, 2] = a * ty * ty + b * tx * tx
    return result


def turned(tensors: Floats, angle: Floats) -> Floats:
    """Tensors (n, 3) whose ellipses are turned by angles (n,), in radians, counter-clockwise."""
    (m11, m12, m22), c, s = tensors.T, np.cos(angle), np.sin(angle)
    return np.column_stack(
        [
            c * c * m11 - 2 * c * s * m12 + s * s * m22,
            c * s * (m11 - m22) + (c * c - s * s) * m12,
            s * s * m11 + 2 * c * s * m12 + c * c * m22,
        ]
    )


def require_positive_definite(d: Floats, where: Callable[[int], Sequence[float]]) -> None:
    """Check that tensors have ellipses, by their `area_sizes` d (n,); CaseError with the place, by ``where``."""
    bad = np.flatnonzero(~(np.isfinite(d) & (d > 0)))
    if len(bad):
        raise CaseError(
            f"is not positive definite and finite at {place(where(int(bad[0])))}: there a size is zero, negative or no "
            "number, or m12 is too large"
        )


def logarithms(tensors: Floats) -> Floats:
    """Entries 11, 12 and 22 (n, 3) of the logarithms of positive tensors (n, 3)."""
    across, along, direction = axes(tensors)
    return symmetric(-2 * np.log(across), -2 * np.log(along), direction)


def of_logarithms(entries: Floats) -> Axes:
    """Axes of the ellipses of tensors whose logarithms have the entries (n, 3)."""
    strong, weak, direction = eigen(entries)
    return Axes(np.exp(-strong / 2), np.exp(-weak / 2), direction)


def size_ratios(some: Floats, others: Floats) -> Floats:
    """Largest ratios (n,), at least 1, of the sizes by both of two tensors (n, 3) in any one direction."""
    n11, n12, n22 = seen_from(roots(some), others)
    half, apart = (n11 + n22) / 2, np.hypot((n11 - n22) / 2, n12)
    small = (n11 * n22 - n12 * n12) / (half + apart)  # a form in which the difference does not cancel
    return np.asarray(np.sqrt(np.maximum(half + apart, 1 / small)))
