"""Initial bubbles on hexagonal lattices, where most of them have the same spacing."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Annotated

import numpy as np
from annotated_types import Ge, Gt, Le
from typing_extensions import Doc

from bubblemesh.arrays import Booleans, Floats, Integers, first_rows, largest_of_rows, taken
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.placement import Placement, require_at_most
from bubblemesh.packing.placement.crystals import Crystal
from bubblemesh.packing.placement.diffusion import Diffusion, ErrorDiffusion, NearLines, boundary_bubbles, near_facets
from bubblemesh.packing.placement.plateaus import plateaus
from bubblemesh.records import record
from bubblemesh.spacing.grid.cells import Leaves, leaves_in_blocks
from bubblemesh.spacing.spacing import Spacing

FEWEST = 625  # bubbles, of which a whole row is 4 %: so that a requested number of nodes can be met to 2 %
MOST = 0.5  # of the bubbles, for all lattices together
CLEAR = 0.5  # spacings that a lattice keeps from the boundary
LARGEST_CELL = 0.65  # spacings: none of such a side has two bubbles of a lattice
REACH = 0.5 + 1e-9  # sides of a cell from its centre: what lies on its edge is in the cells on both sides


@record
class HexagonalLattice(Placement):
    """Lattices along the walls where most bubbles have the same spacing, and error diffusion elsewhere.

    Each spacing that a tenth of the bubbles have gets a lattice, along the longest straight walls where it holds, if
    there are many of them, also between the walls that it does not fit.
    """

    leaf: Annotated[float, Ge(0.1), Le(0.5), Doc("largest side of the cells, in spacings")] = 0.35
    even: Annotated[
        float, Gt(0), Le(1), Doc("part of the bubbles on lattices from which on there are no coarser levels")
    ] = 0.95

    def fitted(self, domain: Domain, spacing: Spacing, expected_nodes: float = 0.0, halvings: int = 0) -> "Lattices":
        fewest = 0 if halvings else FEWEST
        large = [flat for flat in plateaus(domain, spacing, expected_nodes) if flat.bubbles >= fewest]
        found = (Crystal.fitting(plateau, domain, spacing) for plateau in large)
        crystals = tuple(crystal for crystal in found if crystal.has_room(domain, spacing))
        share = sum(crystal.plateau.share for crystal in crystals)
        return Lattices(self.leaf, crystals if share >= MOST else (), share >= self.even)

    def shared(self, domain: Domain, spacing: Spacing, expected_nodes: float) -> Placement:
        lattices = self.fitted(domain, spacing, expected_nodes)
        return lattices if lattices.crystals else self

    def __call__(self, domain: Domain, spacing: Spacing, max_nodes: int) -> Bubbles:
        return self.fitted(domain, spacing)(domain, spacing, max_nodes)


@record
class Lattices(Placement):
    """Certain lattices, each where its plateau's spacing holds, and error diffusion elsewhere."""

    leaf: float
    crystals: tuple[Crystal, ...]
    in_order: bool = False

    def fitted(self, domain: Domain, spacing: Spacing, expected_nodes: float = 0.0, halvings: int = 0) -> "Lattices":
        # Refined, they go on in those of other parts, which may have another number of levels.
        return replace(self, crystals=tuple(crystal.coarser(2.0**halvings) for crystal in self.crystals))

    def one_by_one(self) -> Placement:
        return ErrorDiffusion(self.leaf) if self.crystals else self

    def __call__(self, domain: Domain, spacing: Spacing, max_nodes: int) -> Bubbles:
        shell = boundary_bubbles(domain, spacing)
        to_boundary, found = near_facets(shell, domain), list[Floats]()
        diffusion = Diffusion(to_boundary)
        for cells, lattice in self._walk(domain, spacing):
            x, laid = self._laid(cells, lattice, to_boundary)
            found.append(taken(x, laid | diffusion.chosen(cells, (lattice < 0).astype(float))))
        x = np.concatenate(found)
        x = taken(x, first_rows(x))
        require_at_most(max_nodes, len(shell) + len(x), spacing)
        return shell.append(x, spacing(x))

    def again(self, start: Bubbles, domain: Domain, spacing: Spacing) -> Bubbles:
        to_boundary, count = near_facets(start, domain), start.boundary_count
        walk = self._walk(domain, spacing)
        found = [taken(*self._laid(cells, lattice, to_boundary)) for cells, lattice in walk]
        x = np.concatenate([start.x[count:][self._lattice(start.d[count:]) < 0], *found])
        x = taken(x, first_rows(x))
        return start.select(np.arange(count)).append(x, spacing.extended(x))

    def _lattice(self, d: Floats) -> Integers:
        """Numbers (n,) of the lattices for spacings d (n,), or -1."""
        found = np.full(len(d), -1)
        for number in reversed(range(len(self.crystals))):
            found[self.crystals[number].plateau.holds(d)] = number
        return found

    def _walk(self, domain: Domain, spacing: Spacing) -> Iterator[tuple[Leaves, Integers]]:
        """Cells of a domain, block by block, larger ones on lattices, and the number of the lattice of each, or -1."""

        def largest(d: Floats) -> Floats:
            return np.where(self._lattice(d) < 0, self.leaf, LARGEST_CELL)

        for cells in leaves_in_blocks(domain, spacing, largest):
            yield cells, self._lattice(cells.d)

    def _laid(self, cells: Leaves, lattice: Integers, to_boundary: NearLines) -> tuple[Floats, Booleans]:
        """Places (n, 2) in cells for bubbles, on lattices if possible, and the cells (n,) where they are.

        Some are in two cells, next to each other.
        """
        x, laid = cells.centers.copy(), np.zeros(len(lattice), bool)
        for number, crystal in enumerate(self.crystals):
            mine = np.flatnonzero(lattice == number)
            places = crystal.nearest(taken(cells.centers, mine))
            within = largest_of_rows(np.abs(places - taken(cells.centers, mine))) <= REACH * cells.sides[mine]
            mine, places = mine[within], taken(places, within)
            clear = to_boundary(places, cells.d[mine]) > CLEAR * cells.d[mine]
            x[mine[clear]], laid[mine[clear]] = taken(places, clear), True
        return x, laid
