"""Warm start: the nodes of a previous mesh stay where the spacing has not changed."""

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from bubblemesh.arrays import Booleans, Floats
from bubblemesh.geometry.domain import Domain
from bubblemesh.kernels.hilbert import along_hilbert_curve
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.placement import Placement, require_at_most
from bubblemesh.packing.placement.diffusion import (
    NEAREST_TO_BOUNDARY,
    boundary_bubbles,
    diffused_points,
    distance_to_facets,
)
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing

if TYPE_CHECKING:
    from scipy.spatial import KDTree

SAME = 0.03  # relative difference of sizes that counts as none
CALM = 0.05  # relative difference of sizes up to which the order is left as it is
LEAF = 0.35  # spacings


@record
class PreviousNodes:
    """Nodes of an earlier mesh, from which the next one starts."""

    points: Floats  # (n, 2)
    sizes: Floats  # (n,): distance to their neighbours, smoothed

    @cached_property
    def _tree(self) -> "KDTree":
        from scipy.spatial import KDTree  # takes longer to load than the whole interface for Python programs

        return KDTree(self.points)

    def at(self, points: Floats) -> Floats:
        """The size (m,) of the mesh around points (m, 2), infinite if it has no nodes."""
        if len(self.points) == 0:
            return np.full(len(points), np.inf)
        return self.sizes[self._tree.query(points)[1]]

    def calm(self, bubbles: Bubbles) -> Booleans:
        """Bubbles (n,) of the size that the mesh has there."""
        return np.abs(self.at(bubbles.x) / bubbles.d - 1) <= CALM

    def share_of_own_size(self, domain: Domain, spacing: Spacing) -> float:
        """Part of the nodes that lie where the spacing is their own size."""
        inside = domain.contains(self.points)
        d = spacing.extended(self.points)
        return float((inside & (np.abs(self.sizes / d - 1) <= CALM)).mean()) if len(inside) else 0.0


@record
class WarmStart(Placement):
    """Nodes of a mesh, thinned out where the spacing is larger than their size, and new ones where it is smaller.

    Both by error diffusion along a Hilbert curve, so that the number of bubbles is right everywhere.
    """

    previous: PreviousNodes

    def __call__(self, domain: Domain, spacing: Spacing, max_nodes: int) -> Bubbles:
        shell = boundary_bubbles(domain, spacing)
        staying = self._staying(domain, spacing, shell)
        new = diffused_points(domain, spacing, shell, LEAF, self._lacking)
        x = np.vstack([staying, new])
        require_at_most(max_nodes, len(shell) + len(x), spacing)
        return shell.append(x, spacing(x))

    def _staying(self, domain: Domain, spacing: Spacing, shell: Bubbles) -> Floats:
        """Points (k, 2) of the nodes that stay."""
        order = along_hilbert_curve(self.previous.points)
        x, size = self.previous.points[order], self.previous.sizes[order]
        inside = domain.contains(x)
        x, size = x[inside], size[inside]
        d = spacing(x)
        clear = distance_to_facets(shell, domain, x, d) > NEAREST_TO_BOUNDARY * d
        x, ratio = x[clear], (size / d)[clear]
        stay = np.where(ratio < 1 - SAME, ratio**2, 1.0)
        return x[np.diff(np.floor(np.cumsum(stay) + 0.5), prepend=0) > 0]

    def _lacking(self, x: Floats, d: Floats) -> Floats:
        """Part (n,) of the bubbles of sizes d (n,) at x (n, 2) that the nodes lack."""
        ratio = d / self.previous.at(x)
        return np.where(ratio < 1 - SAME, 1 - ratio**2, 0.0)
