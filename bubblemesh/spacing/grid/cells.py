"""Cells of a quadtree over a domain that are split until they follow the spacing: its leaves, and samples in them."""

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, select, taken
from bubblemesh.geometry.domain import Domain
from bubblemesh.kernels.hilbert import hilbert_index
from bubblemesh.records import record
from bubblemesh.spacing.grid.quadtree import CORNERS, GRID_LEVELS, Quadtree
from bubblemesh.spacing.spacing import Spacing

MOST_AT_ONCE = 1 << 18  # cells that are looked at, about 100 bytes each
PARTS = 8  # of so many

# Largest sides of cells with samples, so that no spot is passed over: in spacings, and of the domain's size.
LARGEST_IN_SPACINGS, LARGEST_IN_DOMAIN = 2.0, 1 / 32


class Leaves(NamedTuple):
    """Square cells inside a domain, along a Hilbert curve."""

    centers: Floats  # (n, 2)
    sides: Floats  # (n,)
    d: Floats  # (n,): spacing at the centres


def leaves(domain: Domain, spacing: Spacing, fraction: float) -> Leaves:
    """Cells with their centres in the domain, of side at most ``fraction`` times the spacing there."""
    blocks = list(leaves_in_blocks(domain, spacing, fraction))
    return Leaves(*(np.concatenate(column) for column in zip(*blocks, strict=True)))


Fraction = float | Callable[[Floats], Floats]  # largest side of cells in spacings, if it depends, by these (n,)


def leaves_in_blocks(domain: Domain, spacing: Spacing, fraction: Fraction) -> Iterator[Leaves]:
    """The cells of `leaves` in their order, some of them at a time where there are very many."""
    root = np.zeros((1, 2), np.int64)
    return _blocks(domain, spacing, fraction, 0, root, [])


class _Found(NamedTuple):
    """Leaves with their places on the Hilbert curve."""

    key: Integers  # (n,)
    centers: Floats  # (n, 2)
    sides: Floats  # (n,)
    d: Floats  # (n,)

    @classmethod
    def joined(cls, parts: Sequence["_Found"]) -> "_Found":
        """Leaves of several parts, in the order of the curve."""
        key, *others = (np.concatenate(column) for column in zip(*parts, strict=True))
        return select(cls(key, *others), np.argsort(key, kind="stable"))

    def between(self, begin: int | None, end: int | None) -> "_Found":
        """The leaves from the row ``begin`` to before ``end``."""
        return _Found(self.key[begin:end], self.centers[begin:end], self.sides[begin:end], self.d[begin:end])


def _blocks(
    domain: Domain, spacing: Spacing, fraction: Fraction, level: int, cells: Integers, found: list[_Found]
) -> Iterator[Leaves]:
    """Leaves within cells (k, 2) of a level, and those that are ``found`` between these, in order."""
    x0, y0, _, _ = domain.bounds
    low, size = np.array([x0, y0]), domain.size
    for finer in range(level, GRID_LEVELS + 1):
        side = size / 2**finer
        centers = low + (cells + 0.5) * side
        inside = domain.contains(centers)
        d = spacing.extended(centers)
        small = side <= (fraction(d) if callable(fraction) else fraction) * d
        done = small & inside
        keys = _keys(taken(cells, done), finer)
        found.append(_Found(keys, taken(centers, done), np.full(len(keys), side), d[done]))
        going_on = ~small
        outside = np.flatnonzero(going_on & ~inside)
        if len(outside):
            # Half the diagonal reaches farther than the cell: one that is wholly outside needs no leaves.
            going_on[outside] = domain.reaches(centers[outside], np.full(len(outside), side * np.sqrt(0.5)))
        cells = taken(cells, going_on)
        if len(cells) == 0:
            break
        cells = (2 * cells[:, None] + CORNERS).reshape(-1, 2)
        if len(cells) > MOST_AT_ONCE:
            yield from _parts(domain, spacing, fraction, finer + 1, cells, _Found.joined(found))
            return
    whole = _Found.joined(found)
    yield Leaves(whole.centers, whole.sides, whole.d)


def _parts(
    domain: Domain, spacing: Spacing, fraction: Fraction, level: int, cells: Integers, found: _Found
) -> Iterator[Leaves]:
    """The leaves of `_blocks`, of some of the cells after the others along the Hilbert curve."""
    keys = _keys(cells, level)
    order = np.argsort(keys)
    cuts = np.arange(0, len(cells), MOST_AT_ONCE // PARTS)[1:]
    between = np.searchsorted(found.key, keys[order[cuts]])
    for first, last, begin, end in zip([0, *cuts], [*cuts, None], [0, *between], [*between, None], strict=True):
        yield from _blocks(domain, spacing, fraction, level, cells[order[first:last]], [found.between(begin, end)])


def _keys(cells: Integers, level: int) -> Integers:
    """Where the Hilbert curve enters cells (k, 2) of a level, in cells of the last one."""
    return hilbert_index(cells, level) << 2 * (GRID_LEVELS - level)


# Of the quarters (4 k,) of cells, four of each in the order of its corners, and the samples (k, p) of these cells: the
# samples (4 k, p) of the quarters.
Values = Callable[[Quadtree, Floats], Floats]


@record
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
            if front is self and not split.any():
                return self
            done.append(front.select(~split))
            if not split.any():
                break
            front = front.quarters(split, domain, values)
        return Samples.merged(done)

    def quarters(self, cells: Booleans, domain: Domain, values: Values) -> "Samples":
        """The quarters of some cells (n,), with samples of their own."""
        grid = self.grid.select(cells).quarters()
        d = values(grid, taken(self.d, cells))
        inside = np.repeat(self.inside[cells], 4)  # no part of a cell reaches farther than the whole
        inside[inside] = domain.reaches(taken(grid.centers, inside), grid.sides[inside] * np.sqrt(0.5))  # or nearly so
        return Samples(grid, inside, d)

    def select(self, cells: Booleans) -> "Samples":
        """Samples of some cells (n,)."""
        return Samples(self.grid.select(cells), self.inside[cells], taken(self.d, cells))

    @classmethod
    def merged(cls, parts: Sequence["Samples"]) -> "Samples":
        """Samples of all cells of parts of one grid."""
        grid, order = Quadtree.merged([part.grid for part in parts])
        inside, d = (np.concatenate([getattr(part, name) for part in parts]) for name in ("inside", "d"))
        return cls(grid, inside[order], taken(d, order))
