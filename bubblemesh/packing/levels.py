"""Levels: a coarse packing is put in order, and its order carried over to finer ones."""

from dataclasses import replace
from typing import Annotated, ClassVar, Protocol

import numpy as np
from annotated_types import Gt, Le
from typing_extensions import Doc

from bubblemesh.arrays import Integers
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.domain import Domain
from bubblemesh.kernels.hilbert import along_hilbert_curve
from bubblemesh.kernels.refining import LEFT_OUT, WHOLE, refined_triangles
from bubblemesh.meshes.triangulation import linked
from bubblemesh.packing.net import Net, connect, reconnect, unconnected
from bubblemesh.packing.placement.diffusion import NEAREST_TO_BOUNDARY, boundary_bubbles, distance_to_facets
from bubblemesh.records import record
from bubblemesh.spacing.grid.cells import Leaves, leaves
from bubblemesh.spacing.rules.gap_sources import GapSources
from bubblemesh.spacing.rules.grading import STEEPEST_GROWTH, gradient_limited
from bubblemesh.spacing.rules.sources import coarse_curves, short_pieces
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.terms.combination import Combination

SAMPLE = 4.0  # spacings: the gradient is taken over cells of that size
STEEP_PART = 0.95  # of the bubbles may be where the spacing is too steep for a coarse level
ACROSS = 3.0  # bubbles of a coarse level across the narrowest parts of the domain
SPLIT = 1.6  # edges longer than this, in units of the finer spacing, are halved


class Levels(Protocol):
    """The spacings that are packed one after the other."""

    @property
    def several(self) -> bool:
        """Whether there may be others than the one asked for."""

    def __call__(self, domain: Domain, spacing: Spacing, expected_nodes: float) -> tuple[Spacing, ...]:
        """Spacings of the levels, the coarsest first and the one asked for last."""


@record
class SingleLevel:
    """The spacing asked for, and no other."""

    several: ClassVar[bool] = False

    def __call__(self, domain: Domain, spacing: Spacing, expected_nodes: float) -> tuple[Spacing, ...]:
        return (spacing,)


@record
class Doubling:
    """Coarser spacings first, doubled as often as the spacing stays gentle and enough bubbles are left."""

    several: ClassVar[bool] = True

    coarsest_nodes: Annotated[
        int, Gt(0), Le(1_000_000_000), Doc("least number of bubbles, about, that the coarsest level has")
    ] = 200
    steepest: Annotated[float, Gt(0), Doc("gradient that only a twentieth of a level's bubbles may exceed")] = 0.2

    def __call__(self, domain: Domain, spacing: Spacing, expected_nodes: float) -> tuple[Spacing, ...]:
        most = np.log2(max(expected_nodes / self.coarsest_nodes, 1)) / 2
        if most >= 1:
            steep = steepness(leaves(domain, spacing, SAMPLE), spacing)
            most = min(most, np.log2(self.steepest) - np.log2(max(steep, np.finfo(float).tiny)))
        coarse = (coarsened(domain, spacing, 2.0**k) for k in range(int(most), 0, -1))
        return (*coarse, spacing)


def steepness(cells: Leaves, spacing: Spacing) -> float:
    """Gradient of the spacing that only a twentieth of the bubbles exceeds."""
    step = cells.sides / 4
    low, high = (
        np.stack([spacing.extended(cells.centers + sign * step[:, None] * axis) for axis in np.eye(2)])
        for sign in (-1, 1)
    )
    gradient = np.hypot(*((high - low) / (2 * step)))
    if len(gradient) == 0:  # the domain is thinner than the cells
        return 0.0
    order = np.argsort(gradient)
    bubbles = np.cumsum((cells.sides / cells.d)[order] ** 2)
    return float(gradient[order][np.searchsorted(bubbles, STEEP_PART * bubbles[-1])])


def coarsened(domain: Domain, spacing: Spacing, factor: float) -> Spacing:
    """The spacing times ``factor``, but finer where the boundary bends, has corners or is near to itself."""
    loose = Spacing(Combination((spacing,), factor), factor * spacing.floor)
    limits = short_pieces(domain, loose).joined(coarse_curves(domain, loose))
    narrow = GapSources(ACROSS, STEEPEST_GROWTH, spacing)(domain, loose)
    limited = gradient_limited(domain, loose, STEEPEST_GROWTH, limits.joined(narrow)).spacing
    if limited is loose:
        return loose
    return Spacing(lambda x, y: np.maximum(limited.function(x, y), spacing.function(x, y)), spacing.floor)


def finer(net: Net, domain: Domain, spacing: Spacing) -> Net:
    """The bubbles of a coarse net and the middles of its edges, for a finer spacing; the boundary is spaced anew."""
    x, edges, first = net.bubbles.x, np.flatnonzero(net.inner), net.bubbles.boundary_count
    ends = x[net.edges[edges]]
    middles = ends.mean(axis=1)
    long = np.hypot(*(ends[:, 1] - ends[:, 0]).T) > SPLIT * spacing.extended(middles)
    x = np.vstack([x[first:], middles[long]])
    order = along_hilbert_curve(x)
    x = x[order]
    shell, d = boundary_bubbles(domain, spacing), spacing.extended(x)
    clear = distance_to_facets(shell, domain, x, d) > NEAREST_TO_BOUNDARY * d
    grown = shell.append(x[clear], d[clear])
    numbers = np.empty(len(x), np.int64)
    numbers[order] = np.where(clear, len(shell) + np.cumsum(clear) - 1, LEFT_OUT)
    inside = len(net.bubbles) - first
    middle = np.full(len(net.edges), WHOLE)
    middle[edges[long]] = numbers[inside:]
    number = np.concatenate([np.full(first, LEFT_OUT), numbers[:inside]])
    bubbles = replace(grown, touched=np.zeros(len(grown), bool))
    fine = unconnected(bubbles, domain)
    triangles = _finer_triangles(net, number, middle, fine)
    return connect(bubbles, domain) if triangles is None else reconnect(fine, bubbles, triangles)


def _finer_triangles(net: Net, number: Integers, middle: Integers, fine: Net) -> Integers | None:
    """Triangles (t, 3) of a ``fine`` net without any, most of them parts of those of a coarse net.

    Its nodes (n,) and the middles of its edges (m,) have other numbers there. The rest, beside the boundary, is
    triangulated. None if that fails, or without compiled kernels: then all has to be.
    """
    found = refined_triangles(net.triangles, net.edges, number, middle)
    if found is None:
        return None
    (known, rim), x, count = found, fine.bubbles.x, fine.bubbles.boundary_count
    rest = np.ones(len(x), bool)
    rest[known] = False
    rest[rim] = rest[:count] = True
    numbers, renumbered = np.flatnonzero(rest), np.cumsum(rest) - 1
    walls = renumbered[np.concatenate([fine.facets, rim])]
    two_sided = np.append(fine.two_sided, np.zeros(len(rim), bool))
    try:
        return np.concatenate([known, numbers[linked(x[rest], walls, two_sided)[0]]])
    except GeometryError:  # a finer boundary may bulge out to where it was not before
        return None
