"""Spacing that is costly to compute, from a table: bilinear in the cells of a background grid."""

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, side_by_side
from bubblemesh.geometry.domain import Domain
from bubblemesh.kernels.lookup import interpolated
from bubblemesh.records import record
from bubblemesh.spacing.grid.cells import LARGEST_IN_DOMAIN, LARGEST_IN_SPACINGS, Samples
from bubblemesh.spacing.grid.quadtree import Quadtree
from bubblemesh.spacing.spacing import Function, Spacing

TOLERANCE = 4e-3  # relative error of what is interpolated
SMALLEST_IN_SPACINGS = 0.5  # spacings: side of a cell that is not split any more
ROUGH = 0.03  # the same at sharp bends, in the smallest cells
PLACES = np.array([[x, y] for y in (-0.5, 0.0, 0.5) for x in (-0.5, 0.0, 0.5)])  # of samples, from a cell's centre
CORNERS = np.array([0, 2, 6, 8])  # those of the samples that are corners
OTHERS = np.array([1, 3, 4, 5, 7])
BETWEEN = np.array([[1, 1, 0, 0], [1, 0, 1, 0], [0.5, 0.5, 0.5, 0.5], [0, 1, 0, 1], [0, 0, 1, 1]]) / 2  # the corners
QUARTERS = np.array([[0, 1, 3, 4], [1, 2, 4, 5], [3, 4, 6, 7], [4, 5, 7, 8]])  # samples that are corners of quarters


@record
class Table:
    """A function that is interpolated where that is good enough."""

    function: Function
    grid: Quadtree
    corners: Integers  # (n, 4): which values are those at the corners of each cell, -1 where these are not enough
    values: Floats  # (v,)

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Values (n,) at x (n,) and y (n,)."""
        points = side_by_side(x, y)
        values = interpolated(self.grid.cells, self.corners, self.values, points)
        rest = np.flatnonzero(np.isinf(values) | ~self.grid.covers(points))
        if len(rest):
            values[rest] = self.function(x[rest], y[rest])
        return values


def tabulated(domain: Domain, spacing: Spacing) -> Spacing:
    """The spacing from a table if it is costly, else itself.

    Cells are split until the values at the middles of their sides and at their centres are those that their corners
    lead to. Where even small cells have quite other ones, at jumps, the spacing itself is asked.
    """
    if not spacing.costly:
        return spacing
    function, grid = spacing.function, Quadtree.around(domain.bounds)

    def values(grid: Quadtree, whole: Floats) -> Floats:
        d = np.empty((len(grid), len(PLACES)))
        d[:, CORNERS] = whole.take(QUARTERS, axis=1).reshape(-1, len(CORNERS))
        d[:, OTHERS] = _values(function, grid, PLACES[OTHERS])
        return d

    start = Samples(grid, np.ones(1, bool), _values(function, grid, PLACES))
    longest = LARGEST_IN_DOMAIN * domain.size
    samples = start.refined(domain, lambda samples: _coarse(samples, longest), values)
    corners = np.arange(len(samples.d) * len(CORNERS)).reshape(-1, len(CORNERS))
    corners[~(samples.inside & (_error(samples.d) <= ROUGH))] = -1
    return Spacing(Table(function, samples.grid, corners, samples.d[:, CORNERS].ravel()), spacing.floor)


def _coarse(samples: Samples, longest: float) -> Booleans:
    """Whether each of the cells (n,) has to be split."""
    sides, d = samples.grid.sides, samples.d
    finest = np.where(d > 0, d, np.inf).min(axis=1)
    large = (sides > LARGEST_IN_SPACINGS * finest) | (sides > longest)
    large |= (_error(d) > TOLERANCE) & (sides > SMALLEST_IN_SPACINGS * finest)
    return samples.inside & samples.grid.divisible & large


def _error(d: Floats) -> Floats:
    """Largest relative error (n,) of the values that samples (n, 9) at corners lead to, infinite if undefined."""
    with np.errstate(invalid="ignore", divide="ignore"):
        error = np.abs(d[:, CORNERS] @ BETWEEN.T / d[:, OTHERS] - 1).max(axis=1)
    return np.where(np.isfinite(d).all(axis=1) & (d > 0).all(axis=1), error, np.inf)


def _values(function: Function, grid: Quadtree, places: Floats) -> Floats:
    """Values (n, p) of the function at places (p, 2) of the cells (n,)."""
    x, y = np.moveaxis(grid.centers[:, None] + grid.sides[:, None, None] * places, 2, 0)
    return function(x.ravel(), y.ravel()).reshape(x.shape)
