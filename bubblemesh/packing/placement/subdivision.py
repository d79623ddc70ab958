"""Initial bubbles by hierarchical spatial subdivision (section 2.3 of the paper)."""

from typing import Annotated, Any

import numpy as np
from annotated_types import Gt, Le
from numpy.typing import NDArray
from typing_extensions import Doc

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.boundary_edges import split_cutting_edges
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.placement import Placement, require_at_most
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing

TIE = 1e-9  # relative: lengths that equal the spacing must not depend on rounding
LATTICE_LEVELS = 40
SQRT3 = np.sqrt(3.0)
SIDES = np.array([[0, 0, 1, 0], [1, 0, 1, 1], [0, 1, 1, 1], [0, 0, 0, 1]])  # of a rhombus, in its two axes


@record
class HierarchicalSubdivision(Placement):
    """Bisection of the boundary, and of an oblique quadtree over the interior, down to the spacing."""

    w1: Annotated[float, Gt(0), Le(4), Doc("a boundary interval with w1 * length >= spacing is split")] = 1.0
    w2: Annotated[float, Gt(0), Le(2), Doc("the same for sides of the quadtree's rhombi; if small, few bubbles")] = 1.0
    clearance: Annotated[float, Gt(0), Le(1), Doc("distance of first bubbles from the boundary, in spacings")] = 0.3

    def __call__(self, domain: Domain, spacing: Spacing, max_nodes: int) -> Bubbles:
        boundary = domain.boundary
        piece, s = bisected(domain, spacing, self.w1, max_nodes)
        on_boundary = np.vstack([boundary.corners, boundary.points(piece, s)])
        inside = self._interior(domain, spacing, max_nodes)
        x = np.vstack([on_boundary, inside])
        placed = Bubbles(x, spacing(x), piece, s, len(boundary.corners), touched=np.zeros(len(x), bool))
        return split_cutting_edges(placed, domain, spacing)

    def _interior(self, domain: Domain, spacing: Spacing, max_nodes: int) -> Floats:
        """Corners (k, 2) of the quadtree's rhombi that are far enough from the boundary."""
        x0, y0, x1, y1 = domain.bounds
        width, height = x1 - x0, y1 - y0
        side = max(width + height / SQRT3, 2 * height / SQRT3)
        lattice = Lattice(np.array([x0 - height / SQRT3, y0]), side)
        cells, corners = np.zeros((1, 2), np.int64), []
        for level in range(LATTICE_LEVELS):
            corners.append(_corners(cells) << (LATTICE_LEVELS - level))
            require_at_most(max_nodes, len(cells), spacing)
            split = self._to_split(lattice, cells, level, spacing) & _meets(domain, lattice, cells, level)
            cells = _corners(2 * cells[split])  # of four quarters each
            if len(cells) == 0:
                break
        points = lattice.points(_distinct(np.vstack(corners)), LATTICE_LEVELS)
        points = points[domain.contains(points)]
        return points[domain.surely_inside(points, self.clearance * spacing(points))]

    def _to_split(self, lattice: "Lattice", cells: Integers, level: int, spacing: Spacing) -> Booleans:
        """Rhombi (k,) with a side that is too long for the spacing at its ends."""
        d = spacing.extended(lattice.points(_corners(cells), level)).reshape(len(cells), 2, 2)
        length = self.w2 * lattice.side / 2**level * (1 + TIE)
        return np.any([length >= (d[:, i, j] + d[:, k, m]) / 2 for i, j, k, m in SIDES], axis=0)


@record
class Lattice:
    """Oblique coordinates: axes at 60 degrees from ``origin`` (2,), unit ``side`` / 2**level."""

    origin: Floats
    side: float

    def points(self, cells: NDArray[Any], level: int) -> Floats:
        """Points (k, 2) at the lattice coordinates (k, 2)."""
        u, v = np.asarray(cells, float).T * (self.side / 2**level)
        return self.origin + np.column_stack([u + v / 2, v * (SQRT3 / 2)])


def bisected(domain: Domain, spacing: Spacing, w1: float, max_nodes: int) -> tuple[Integers, Floats]:
    """Pieces (k,) and arc lengths (k,) of the new bubbles on the boundary, by recursive bisection.

    A closed curve has no corner to start from: its bubbles start at its quarters.
    """
    boundary = domain.boundary
    quarters = np.flatnonzero(boundary.closed)
    piece = np.concatenate([np.flatnonzero(~boundary.closed), np.repeat(quarters, 4)])
    parts = np.where(boundary.closed[piece], 4, 1)
    low = np.concatenate([np.zeros(len(piece) - 4 * len(quarters)), np.tile(np.arange(4) / 4, len(quarters))])
    low = low * boundary.lengths[piece]
    high = low + boundary.lengths[piece] / parts
    placed = [(piece[parts > 1], low[parts > 1])]
    for _ in range(LATTICE_LEVELS):
        ends = [spacing(boundary.points(piece, at)) for at in (low, high)]
        split = w1 * (high - low) * (1 + TIE) >= (ends[0] + ends[1]) / 2
        piece, low, high = piece[split], low[split], high[split]
        middle = (low + high) / 2
        placed.append((piece, middle))
        require_at_most(max_nodes, len(piece), spacing)
        piece, low, high = np.tile(piece, 2), np.append(low, middle), np.append(middle, high)
        if len(piece) == 0:
            break
    pieces, arc_lengths = (np.concatenate(column) for column in zip(*placed, strict=True))
    order = np.lexsort((arc_lengths, pieces))
    return pieces[order], arc_lengths[order]


def _corners(cells: Integers) -> Integers:
    """The four corners (4 k, 2) of each rhombus (k, 2), by (row, column) of the two axes."""
    return (cells[:, None] + np.array([[0, 0], [0, 1], [1, 0], [1, 1]])).reshape(-1, 2)


def _distinct(cells: Integers) -> Integers:
    """The cells (k, 2) in order, each once."""
    # As complex numbers, which hold such integers exactly, pairs are sorted several times faster.
    ordered = np.sort(cells.astype(float).view(complex).ravel())
    ordered = ordered[np.append(True, ordered[1:] != ordered[:-1])]
    return np.column_stack([ordered.real, ordered.imag]).astype(np.int64)


def _meets(domain: Domain, lattice: Lattice, cells: Integers, level: int) -> Booleans:
    """Rhombi (k,) that may reach into the domain: the others need no bubbles."""
    centers = lattice.points(cells + 0.5, level)
    reach = lattice.side / 2**level * SQRT3 / 2
    return domain.reaches(centers, np.full(len(centers), reach))
