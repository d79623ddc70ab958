"""A spacing given by values on a rectangular grid."""

from dataclasses import replace
from typing import Self

import numpy as np

from bubblemesh.arrays import LARGEST_NUMBER, Booleans, Floats, Integers
from bubblemesh.errors import CaseError
from bubblemesh.meshes.checks import real_numbers
from bubblemesh.messages import place
from bubblemesh.records import record
from bubblemesh.spacing.spacing import finest, is_spot, require_positive

BAND = 1_000_000  # pixels that are looked at together: of all of them there may be many


@record
class Raster:
    """Bilinear interpolation between the centres of pixels; beyond the outermost ones, the value at the nearest place.

    Made by `of` and `within`.
    """

    x: Floats  # (c,): centres of the columns, ascending
    y: Floats  # (r,): centres of the rows, ascending
    values: Floats  # (r, c): positive and finite

    @classmethod
    def of(cls, x: Floats, y: Floats, values: Floats, *, signed: bool = False) -> Self:
        """Raster of ``values`` (r, c) with columns at ``x`` (c,) and rows at ``y`` (r,), in either direction each.

        Values may be negative if they are ``signed``, and are no spacings then. CaseError if the shapes do not fit,
        coordinates do not go one way, or a value is not positive and finite; the text names its row and column, from 0,
        and its place.
        """
        values = _grid(values)
        x, y = real_numbers(x, "x", values.shape[1:]), real_numbers(y, "y", values.shape[:1])
        for name, coordinates, what in (("x", x, "column"), ("y", y, "row")):
            steps = np.diff(coordinates)
            if not (np.abs(coordinates) <= LARGEST_NUMBER).all() or not ((steps > 0).all() or (steps < 0).all()):
                raise CaseError(f"{name} has to be finite, and ascending or descending from each {what} to the next")

        def where(k: int) -> str:
            row, column = np.unravel_index(k, values.shape)
            return f"in row {row}, column {column} (from 0), {place((x[column], y[row]))}"

        if not signed:
            require_positive(values.ravel(), where)
        across, along = (slice(None, None, -1 if len(c) > 1 and c[1] < c[0] else 1) for c in (x, y))
        return cls(x[across], y[along], values[along, across])

    @classmethod
    def within(
        cls, bounds: tuple[float, float, float, float], values: Floats, upper: bool = False, *, signed: bool = False
    ) -> Self:
        """Raster of ``values`` (r, c) whose pixels fill the rectangle ``bounds`` (x0, y0, x1, y1).

        The first row is the lowest one, or the highest with ``upper``. CaseError as `of`.
        """
        values = _grid(values)
        x0, y0, x1, y1 = real_numbers(bounds, "bounds", (4,)).tolist()
        if not (x0 < x1 and y0 < y1):
            raise CaseError(
                f"bounds: must be x0, y0, x1, y1 with x0 < x1 and y0 < y1 (found {x0:g}, {y0:g}, {x1:g}, {y1:g})"
            )
        rows, columns = values.shape
        x = x0 + (np.arange(columns) + 0.5) * ((x1 - x0) / columns)
        y = y0 + (np.arange(rows) + 0.5) * ((y1 - y0) / rows)
        return cls.of(x, y[::-1] if upper else y, values, signed=signed)

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Box (x0, y0, x1, y1) of the pixels; without an end where there is only one, whose size is unknown."""
        (x0, x1), (y0, y1) = _reach(self.x), _reach(self.y)
        return x0, y0, x1, y1

    def holds(self, places: Floats) -> Booleans:
        """Whether places (m, 2) lie in pixels."""
        x0, y0, x1, y1 = self.bounds
        return np.asarray(((places >= (x0, y0)) & (places <= (x1, y1))).all(axis=1))

    @property
    def spots(self) -> Floats:
        """Centres (k, 2) of pixels at which it is fine over a short distance."""
        rows, columns = self.values.shape
        step = max(BAND // columns, 1)
        bands = [self._spots_in(first, min(first + step, rows)) for first in range(0, rows, step)]
        row, column = np.divmod(finest(np.concatenate(bands), self.values.ravel()), columns)
        return np.column_stack([self.x[column], self.y[row]])

    def _spots_in(self, first: int, end: int) -> Integers:
        """Numbers (k,) of the pixels, among all, that are spots in the rows from ``first`` to before ``end``."""
        below = max(first - 1, 0)
        values = self.values[below : end + 1]
        along = np.diff(values, axis=1) / np.diff(self.x)
        up = np.diff(values, axis=0) / np.diff(self.y[below : end + 1])[:, None]
        least, steepest = np.full(values.shape, np.inf), np.full(values.shape, -np.inf)
        sides = (np.s_[:, :-1], along), (np.s_[:, 1:], -along), (np.s_[:-1], up), (np.s_[1:], -up)
        for pixels, rise in sides:
            np.minimum(least[pixels], rise, out=least[pixels])
            np.maximum(steepest[pixels], rise, out=steepest[pixels])
        inner = slice(first - below, end - below)
        return np.flatnonzero(is_spot(least[inner], steepest[inner])) + first * values.shape[1]

    def scaled(self, factor: float) -> Self:
        """The raster with all values multiplied."""
        return replace(self, values=factor * self.values)

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Values (m,) at x (m,) and y (m,)."""
        (left, right, s), (below, above, t) = _between(self.x, x), _between(self.y, y)
        low = (1 - s) * self.values[below, left] + s * self.values[below, right]
        high = (1 - s) * self.values[above, left] + s * self.values[above, right]
        return (1 - t) * low + t * high


def _grid(values: Floats) -> Floats:
    values = real_numbers(values, "values", ("r", "c"))
    if values.size == 0:
        raise CaseError(f"has the shape {values.shape}: a raster has at least one row and one column")
    return values


def _reach(centers: Floats) -> tuple[float, float]:
    """Ends of pixels with these centres (k,)."""
    if len(centers) == 1:
        return -np.inf, np.inf
    return float(1.5 * centers[0] - centers[1] / 2), float(1.5 * centers[-1] - centers[-2] / 2)


def _between(centers: Floats, at: Floats) -> tuple[Integers, Integers, Floats]:
    """Centres (m,) before and after some coordinates (m,), and the share of the way between them."""
    before = np.clip(np.searchsorted(centers, at, side="right") - 1, 0, max(len(centers) - 2, 0))
    after = np.minimum(before + 1, len(centers) - 1)
    width = np.where(after > before, centers[after] - centers[before], 1.0)
    return before, after, np.clip((at - centers[before]) / width, 0, 1)
