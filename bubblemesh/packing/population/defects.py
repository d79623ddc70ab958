"""Population control by the defects of the triangulation: nodes with too few neighbours, edges too short or long."""

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from annotated_types import Ge, Gt, Le
from typing_extensions import Doc

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.domain import Domain
from bubblemesh.meshes.quality import edge_ratios
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.neighbours import maximal_independent_set
from bubblemesh.packing.net import Net
from bubblemesh.packing.population import Change
from bubblemesh.spacing.spacing import Spacing

FEWEST_NEIGHBOURS = 4
MANY_NEIGHBOURS = 8
FEWEST_ON_A_WALL = 3  # of a bubble on a straight wall, that is two triangles with right angles
CLOSE_ON_A_WALL = 0.92  # spacings
WIDEST = np.cos(np.radians(80.0))  # at a corner: two triangles of 45 degrees are better than one with a right angle
NEAREST_TO_CORNER = 0.6  # spacings that a new bubble keeps
TOO_NEAR_CORNER = 0.5  # spacings within which one goes; less, so that none comes and goes in turns


@dataclass(frozen=True)
class Defects:
    """Deletion and insertion where the triangulation shows that bubbles are too many or missing.

    An interior bubble goes from an edge that is too short, or if it has four neighbours or fewer. So does one on a
    straight wall that is crowded and has two triangles only. A bubble comes to the middle of an edge that is too long.
    """

    delete_shorter: Annotated[float, Gt(0), Le(1), Doc("a bubble goes from an edge shorter than this, in spacings")] = (
        0.72
    )
    insert_longer: Annotated[float, Ge(1), Le(2), Doc("a bubble comes to an edge longer than this, in spacings")] = 1.38
    insert_longer_at_crowd: Annotated[float, Ge(1), Le(2), Doc("the same beside a bubble with eight neighbours")] = 1.12

    def __call__(self, net: Net, domain: Domain, spacing: Spacing, random: np.random.Generator) -> Change:
        bubbles = net.bubbles
        ratio = relative_lengths(bubbles, net.edges)
        gone = self._crowded(net, ratio, crowded_on_walls(net, domain))
        halved = self._too_long(net, ratio, gone)
        x = bubbles.x[halved].mean(axis=1)
        touched = np.zeros(len(bubbles), bool)
        touched[net.edges[gone[net.edges].any(axis=1)]] = True
        touched[halved] = True
        rest = replace(bubbles, touched=touched).select(np.flatnonzero(~gone))
        return Change(rest.append(x, spacing.extended(x)), deleted=len(bubbles) - len(rest), inserted=len(x))

    def _crowded(self, net: Net, ratio: Floats, on_walls: Booleans) -> Booleans:
        """Bubbles (n,) to delete, no two of them connected: those given, and interior ones."""
        valence = net.valence
        interior = np.arange(len(valence)) >= net.bubbles.boundary_count
        chosen = on_walls | (interior & (valence <= FEWEST_NEIGHBOURS))
        # What lies in a corner's angle cannot give way: it takes more to be too near.
        at_corner = (net.edges < net.bubbles.corners).any(axis=1)
        i, j = net.edges[ratio < np.where(at_corner, TOO_NEAR_CORNER, self.delete_shorter)].T
        # Of two bubbles too near to each other the one with fewer neighbours goes, and none of the boundary.
        second = interior[j] & ((valence[j] <= valence[i]) | ~interior[i])
        loser = np.where(second, j, i)
        chosen[loser[interior[loser]]] = True
        return maximal_independent_set(chosen, net.edges, np.arange(len(chosen)))

    def _too_long(self, net: Net, ratio: Floats, gone: Booleans) -> Integers:
        """Edges (k, 2) with room for one more bubble, no two of them at the same bubble."""
        crowd = (net.valence >= MANY_NEIGHBOURS)[net.edges].any(axis=1)
        long = ratio > np.where(crowd, self.insert_longer_at_crowd, self.insert_longer)
        long &= net.inner & ~gone[net.edges].any(axis=1)
        edges = net.edges[long]
        edges = np.concatenate([edges[np.argsort(-ratio[long], kind="stable")], across_wide_corners(net, gone)])
        rank = np.arange(len(edges))
        first = np.full(len(net.bubbles), len(edges))
        np.minimum.at(first, edges, rank[:, None])
        return edges[(first[edges] == rank[:, None]).all(axis=1)]


def relative_lengths(bubbles: Bubbles, edges: Integers) -> Floats:
    """Lengths (m,) of edges (m, 2) over the mean spacing of their ends."""
    return edge_ratios(bubbles.x, edges, bubbles.d[edges].mean(axis=1))


def crowded_on_walls(net: Net, domain: Domain) -> Booleans:
    """Sliding bubbles (n,) on straight walls, nearer to their neighbours there than the spacing, with two triangles.

    Beside a perfect packing they have three. On a curve every bubble serves the shape of the boundary.
    """
    bubbles, n = net.bubbles, len(net.bubbles)
    ratio = relative_lengths(bubbles, net.facets)
    crowded = np.bincount(net.facets.ravel(), np.repeat(ratio, 2), minlength=n) < 2 * CLOSE_ON_A_WALL
    straight = np.zeros(n, bool)
    bound = domain.boundary.curved | domain.boundary.inner | domain.on_periodic_side
    straight[bubbles.sliding] = ~bound[bubbles.piece]
    return straight & crowded & (net.valence == FEWEST_ON_A_WALL)


def across_wide_corners(net: Net, gone: Booleans) -> Integers:
    """Edges (k, 2) inside the domain that face too wide an angle at a corner of the boundary."""
    x, corners = net.bubbles.x, net.bubbles.corners
    first = np.argmin(net.triangles, axis=1)
    beside = np.flatnonzero((net.triangles.min(axis=1) < corners) & ~gone[net.triangles].any(axis=1))
    apex, a, b = (net.triangles[beside, (first[beside] + k) % 3] for k in range(3))
    u, v = x[a] - x[apex], x[b] - x[apex]
    lengths = np.hypot(*u.T) * np.hypot(*v.T)
    wide = np.einsum("ij,ij->i", u, v) < WIDEST * lengths
    roomy = np.hypot(*(u + v).T) / 2 > NEAREST_TO_CORNER * net.bubbles.d[apex]
    faced = np.sort(np.column_stack([a, b])[wide & roomy], axis=1)
    return faced[~net.are_facets(faced)]
