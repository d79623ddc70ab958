"""Grids whose cells resolve a spacing and the sources around which it is finer."""

from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.domain import Domain
from bubblemesh.spacing.grid.quadtree import Quadtree
from bubblemesh.spacing.grid.samples import Samples
from bubblemesh.spacing.rules.sources import Sources
from bubblemesh.spacing.spacing import Spacing

CELL = 2.0  # spacings: largest side of a cell
COARSEST = 1 / 32  # of the domain's size: spots as large as that are not passed over
SPLITS = 1000
PLACES = np.array([[0, 0], [-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]])  # of samples, from a cell's centre
PAIRS = np.array([[0, 1], [0, 2], [0, 3], [0, 4], [1, 2], [3, 4], [1, 3], [2, 4]])
TOLERANCE = 1e-3  # relative excess of the growth that does not count


class SteepestPlace(NamedTuple):
    """Place (x, y) where a spacing grows fastest, the spacing on its fine side, and the growth per length."""

    at: tuple[float, float]
    size: float
    growth: float


def unresolved(domain: Domain) -> Samples:
    """One cell around the domain, with samples that have it split."""
    return Samples.of_one_cell(Quadtree.around(domain.bounds), np.zeros((1, len(PLACES))))


def resolved(
    samples: Samples, domain: Domain, spacing: Spacing, sources: Sources, largest: Floats | float = np.inf
) -> Samples:
    """Cells split until they resolve the spacing, none is above ``largest`` (n,), and their sizes are balanced."""

    def coarse(refined: Samples) -> Booleans:
        grid = refined.grid
        sides = np.minimum(CELL * refined.d.min(axis=1), COARSEST * domain.size)
        np.minimum.at(sides, grid.located(sources.points), sources.cells)
        split = refined.inside & grid.divisible & (grid.sides > sides)
        if refined is samples:
            split |= grid.sides > largest
        return split if split.any() else grid.unbalanced()

    def values(grid: Quadtree, cells: Integers, _: Floats) -> Floats:
        return spacing.extended(_places(grid, cells).reshape(-1, 2)).reshape(-1, len(PLACES))

    return samples.refined(domain, coarse, values, SPLITS)


def too_steep(samples: Samples, growth: float) -> Booleans:
    """Whether the spacing grows by more than ``growth`` per length, (n, 8), between the `PAIRS` of places of a cell."""
    return _slopes(samples) > growth * (1 + TOLERANCE)


def steepest(samples: Samples, domain: Domain, growth: float) -> SteepestPlace | None:
    """Place where the spacing grows fastest between samples that lie in the domain, if faster than ``growth``."""
    cell, pair = np.nonzero(too_steep(samples, growth) & samples.inside[:, None])
    ends = _places(samples.grid, cell)[np.arange(len(cell))[:, None], PAIRS[pair]]
    real = domain.contains(ends[:, 0]) & domain.contains(ends[:, 1])
    cell, pair, ends = cell[real], pair[real], ends[real]
    if len(cell) == 0:
        return None
    slopes = _slopes(samples)[cell, pair]
    k = slopes.argmax()
    d = samples.d[cell[k], PAIRS[pair[k]]]
    x, y = ends[k, d.argmin()].tolist()
    return SteepestPlace((x, y), float(d.min()), float(slopes[k]))


def _slopes(samples: Samples) -> Floats:
    """Growth (n, 8) of the spacing per length between the `PAIRS` of places."""
    lengths = samples.grid.sides[:, None] * np.hypot(*(PLACES[PAIRS[:, 1]] - PLACES[PAIRS[:, 0]]).T)
    return np.abs(samples.d[:, PAIRS[:, 1]] - samples.d[:, PAIRS[:, 0]]) / lengths


def _places(grid: Quadtree, cells: Integers) -> Floats:
    """Places (k, 5, 2) of samples in some cells: centre and corners."""
    return np.concatenate([grid.centers[cells, None], grid.corners(cells)], axis=1)
