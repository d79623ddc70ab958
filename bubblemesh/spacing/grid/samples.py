"""Samples of a spacing in the cells of a quadtree, which are split where these are too coarse."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.domain import Domain
from bubblemesh.spacing.grid.quadtree import Quadtree


@dataclass(frozen=True)
class Samples:
    """A quadtree around a domain, and a spacing at some places of each cell.

    Attributes
    ----------
    grid : Quadtree
    inside : (n,)
        Which cells reach into the domain, or nearly so.
    d : (n, p)
        Spacing at the places, whether or not they lie in the domain.
    """

    grid: Quadtree
    inside: Booleans
    d: Floats

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
