"""Cells of a quadtree over a domain that are split until they follow the spacing: its leaves, and samples in them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.domain import Domain
from bubblemesh.kernels.hilbert import hilbert_index
from bubblemesh.spacing.grid.quadtree import CORNERS, GRID_LEVELS, Quadtree
from bubblemesh.spacing.spacing import Spacing

# Largest sides of cells with samples, so that no spot is passed over: in spacings, and of the domain's size.
LARGEST_IN_SPACINGS, LARGEST_IN_DOMAIN = 2.0, 1 / 32


@dataclass(frozen=True)
class Leaves:
    """Square cells inside a domain, along a Hilbert curve."""

    centers: Floats  # (n, 2)
    sides: Floats  # (n,)
    d: Floats  # (n,): spacing at the centres


def leaves(domain: Domain, spacing: Spacing, fraction: float) -> Leaves:
    """Cells with their centres in the domain, of side at most ``fraction`` times the spacing there."""
    x0, y0, _, _ = domain.bounds
    low, size = np.array([x0, y0]), domain.size
    cells = np.zeros((1, 2), np.int64)
    found: list[tuple[Integers, Floats, Floats, Floats]] = []
    for level in range(GRID_LEVELS + 1):
        side = size / 2**level
        centers = low + (cells + 0.5) * side
        inside = domain.contains(centers)
        d = spacing.extended(centers)
        small = side <= fraction * d
        done = small & inside
        key = hilbert_index(cells[done], level) << 2 * (GRID_LEVELS - level)
        found.append((key, centers[done], np.full(int(done.sum()), side), d[done]))
        going_on = np.flatnonzero(~small)
        outside = going_on[~inside[going_on]]
        # Half the diagonal reaches farther than the cell: one that is wholly outside needs no leaves.
        away = outside[domain.surely_outside(centers[outside], np.full(len(outside), side * np.sqrt(0.5)))]
        cells = cells[np.setdiff1d(going_on, away, assume_unique=True)]
        if len(cells) == 0:
            break
        cells = (2 * cells[:, None] + CORNERS).reshape(-1, 2)
    key, centers, sides, d = (np.concatenate(column) for column in zip(*found, strict=True))
    order = np.argsort(key, kind="stable")
    return Leaves(centers[order], sides[order], d[order])


# Of a grid, its new cells (k,), and the samples (k, p) of the cells from which they stem: the samples (k, p) of the new
# cells. Quarters of a cell follow each other in the order of its corners.
Values = Callable[[Quadtree, Integers, Floats], Floats]


@dataclass(frozen=True)
class Samples:
    """A quadtree around a domain, and a spacing at some places of each cell."""

    grid: Quadtree
    inside: Booleans  # (n,): cells that reach into the domain, or nearly so
    d: Floats  # (n, p): spacing at the places, whether or not they lie in the domain

    def refined(self, domain: Domain, coarse: Callable[["Samples"], Booleans], values: Values) -> "Samples":
        """The samples with cells split in four as long as they are ``coarse``, which is asked once for each cell."""
        front, done = self, list[Samples]()
        for _ in range(GRID_LEVELS + 1):
            split = coarse(front)
            done.append(front.select(~split))
            if not split.any():
                break
            front = front.quarters(split, domain, values)
        return Samples.merged(done)

    def quarters(self, cells: Booleans, domain: Domain, values: Values) -> "Samples":
        """The quarters of some cells (n,), with samples of their own."""
        grid, origin, _ = self.grid.select(cells).split(np.ones(int(cells.sum()), bool))
        d = values(grid, np.arange(len(grid)), self.d[cells][origin])
        inside = self.inside[cells][origin]  # no part of a cell reaches farther than the whole
        inside[inside] = _reaching(domain, grid.centers[inside], grid.sides[inside])
        return Samples(grid, inside, d)

    def select(self, cells: Booleans) -> "Samples":
        """Samples of some cells (n,)."""
        return Samples(self.grid.select(cells), self.inside[cells], self.d[cells])

    @classmethod
    def merged(cls, parts: Sequence["Samples"]) -> "Samples":
        """Samples of all cells of parts of one grid."""
        grid, order = Quadtree.merged([part.grid for part in parts])
        inside, d = (np.concatenate([getattr(part, name) for part in parts])[order] for name in ("inside", "d"))
        return cls(grid, inside, d)


def _reaching(domain: Domain, centers: Floats, sides: Floats) -> Booleans:
    """Whether each of the square cells (k,) reaches into the domain, or nearly so."""
    reaching = domain.contains(centers)
    outside = np.flatnonzero(~reaching)
    reaching[outside] = domain.signed_distance(centers[outside]) > -sides[outside] * np.sqrt(0.5)
    return reaching
