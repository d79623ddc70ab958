"""Quadtree grid whose cells resolve a spacing and the sources around which it is finer."""

from dataclasses import dataclass, replace

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.domain import Domain
from bubblemesh.spacing.grid.quadtree import Quadtree
from bubblemesh.spacing.rules.sources import Sources
from bubblemesh.spacing.spacing import Spacing

CELL = 2.0  # spacings: largest side of a cell
COARSEST = 1 / 32  # of the domain's size: spots as large as that are not passed over
SPLITS = 1000
SAMPLES = np.array([[0, 0], [-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]])  # of a cell, from its centre
PAIRS = np.array([[0, 1], [0, 2], [0, 3], [0, 4], [1, 2], [3, 4], [1, 3], [2, 4]])


@dataclass(frozen=True)
class Sampled:
    """A grid and the wanted spacing in its cells.

    Attributes
    ----------
    grid : Quadtree
    inside : (n,)
        Which cells reach into the domain.
    d : (n, 5)
        Spacing at the centres and corners, whether or not they lie in the domain.
    finest : (n,)
        Largest side that its sources allow for each cell, infinite where there is none.
    """

    grid: Quadtree
    inside: Booleans
    d: Floats
    finest: Floats

    def largest(self, coarsest: float) -> Floats:
        """Largest sides (n,) of cells that resolve the spacing and the sources."""
        wanted = np.minimum(CELL * self.d.min(axis=1), self.finest)
        return np.where(self.inside & self.grid.divisible, np.minimum(wanted, coarsest), np.inf)

    def slopes(self) -> Floats:
        """Growth (n, 8) of the spacing per length between the `PAIRS` of samples."""
        lengths = self.grid.sides[:, None] * np.hypot(*(SAMPLES[PAIRS[:, 1]] - SAMPLES[PAIRS[:, 0]]).T)
        return np.abs(self.d[:, PAIRS[:, 1]] - self.d[:, PAIRS[:, 0]]) / lengths


def whole(domain: Domain) -> Sampled:
    """One cell around the domain, with samples that have it split."""
    grid = Quadtree.around(domain.bounds)
    return Sampled(grid, np.ones(1, bool), np.zeros((1, len(SAMPLES))), np.zeros(1))


def resolved(sampled: Sampled, domain: Domain, spacing: Spacing, sources: Sources, largest: Floats | float) -> Sampled:
    """Cells split until they resolve the spacing, none is above ``largest`` (n,), and their sizes are balanced."""
    sampled = replace(sampled, finest=_finest(sampled.grid, sources))
    split = sampled.grid.sides > largest
    for _ in range(SPLITS):
        split |= sampled.grid.sides > sampled.largest(COARSEST * domain.size)
        if not split.any():
            split = sampled.grid.unbalanced()
        if not split.any():
            break
        grid, origin, fresh = sampled.grid.split(split)
        mine = np.flatnonzero(fresh)
        inside, d = sampled.inside[origin], sampled.d[origin]
        inside[mine] = reaching(domain, grid.centers[mine], grid.sides[mine])
        d[mine] = spacing.extended(places(grid, mine).reshape(-1, 2)).reshape(-1, len(SAMPLES))
        sampled = Sampled(grid, inside, d, _finest(grid, sources))
        split = np.zeros(len(grid), bool)
    return sampled


def _finest(grid: Quadtree, sources: Sources) -> Floats:
    """Largest side (n,) that its sources allow for each cell, infinite where there is none."""
    finest = np.full(len(grid), np.inf)
    np.minimum.at(finest, grid.located(sources.points), sources.cells)
    return finest


def places(grid: Quadtree, cells: Integers) -> Floats:
    """Samples (k, 5, 2) of some cells: centre and corners."""
    return np.concatenate([grid.centers[cells, None], grid.corners(cells)], axis=1)


def reaching(domain: Domain, centers: Floats, sides: Floats) -> Booleans:
    """Which square cells (k,) reach into the domain, or nearly so."""
    reaching = domain.contains(centers)
    outside = np.flatnonzero(~reaching)
    reaching[outside] = domain.signed_distance(centers[outside]) > -sides[outside] * np.sqrt(0.5)
    return reaching
