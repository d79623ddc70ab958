"""Quadtree over a domain whose cells follow the spacing."""

from dataclasses import dataclass

import numpy as np

from bubblemesh.arrays import Floats, Integers, hilbert_index
from bubblemesh.geometry.domain import Domain
from bubblemesh.spacing.grid.quadtree import CORNERS, DEEPEST
from bubblemesh.spacing.spacing import Spacing


@dataclass(frozen=True)
class Leaves:
    """Square cells inside a domain, along a Hilbert curve.

    Attributes
    ----------
    centers : (n, 2)
    sides : (n,)
    d : (n,)
        Spacing at the centres.
    """

    centers: Floats
    sides: Floats
    d: Floats


def leaves(domain: Domain, spacing: Spacing, fraction: float) -> Leaves:
    """Cells with their centres in the domain, of side at most ``fraction`` times the spacing there."""
    x0, y0, _, _ = domain.bounds
    low, size = np.array([x0, y0]), domain.size
    cells = np.zeros((1, 2), np.int64)
    found: list[tuple[Integers, Floats, Floats, Floats]] = []
    for level in range(DEEPEST + 1):
        side = size / 2**level
        centers = low + (cells + 0.5) * side
        inside = domain.contains(centers)
        d = spacing.extended(centers)
        small = side <= fraction * d
        done = small & inside
        key = hilbert_index(cells[done], level) << 2 * (DEEPEST - level)
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
