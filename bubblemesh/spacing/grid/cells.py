"""Cells of a quadtree over a domain that are split until they follow the spacing: its leaves, and samples in them."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, hilbert_index
from bubblemesh.geometry.domain import Domain
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


@dataclass(frozen=True)
class Samples:
    """A quadtree around a domain, and a spacing at some places of each cell."""

    grid: Quadtree
    inside: Booleans  # (n,): cells that reach into the domain, or nearly so
    d: Floats  # (n, p): spacing at the places, whether or not they lie in the domain

    @classmethod
    def of_one_cell(cls, grid: Quadtree, d: Floats) -> "Samples":
        """Spacing (1, p) in the one cell of a grid."""
        return cls(grid, np.ones(1, bool), d)

    def refined(
        self,
        domain: Domain,
        coarse: Callable[["Samples"], Booleans],
        values: Callable[[Quadtree, Integers, Floats], Floats],
        most: int,
    ) -> "Samples":
        """The samples with cells split in four until none is ``coarse``, or ``most`` times.

        Of a grid, its new cells (k,), and the samples (k, p) of the cells from which they stem, ``values`` makes the
        samples (k, p) of the new cells. Quarters of a cell follow each other in the order of its corners.
        """
        samples = self
        for _ in range(most):
            split = coarse(samples)
            if not split.any():
                break
            grid, origin, fresh = samples.grid.split(split)
            new = np.flatnonzero(fresh)
            inside, d = samples.inside[origin], samples.d[origin]
            inside[new] = _reaching(domain, grid.centers[new], grid.sides[new])
            d[new] = values(grid, new, d[new])
            samples = Samples(grid, inside, d)
        return samples


def _reaching(domain: Domain, centers: Floats, sides: Floats) -> Booleans:
    """Whether each of the square cells (k,) reaches into the domain, or nearly so."""
    reaching = domain.contains(centers)
    outside = np.flatnonzero(~reaching)
    reaching[outside] = domain.signed_distance(centers[outside]) > -sides[outside] * np.sqrt(0.5)
    return reaching
