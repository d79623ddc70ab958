"""Population control in a metric: ellipses go from edges that are too short, and come to those that are too long."""

from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.meshes.quality import doubled_areas
from bubblemesh.meshes.tensors import mapped, roots
from bubblemesh.packing.ellipses.net import EllipseNet, flipped_net
from bubblemesh.packing.neighbours import maximal_independent_set
from bubblemesh.packing.population import (
    FEWEST_NEIGHBOURS,
    MANY_NEIGHBOURS,
    NEAREST_TO_CORNER,
    TOO_NEAR_CORNER,
    WIDEST_CORNER,
    Defects,
)
from bubblemesh.packing.splicing import removed, with_middles
from bubblemesh.spacing.metric.metric import MetricSpacing

AREA_OF_TRIANGLE = np.sqrt(3) / 4
SHORT, LONG = 0.85, 1.2  # edges that make a bubble go or come only where there are too many or too few


class Controlled(NamedTuple):
    """A net after population control, and how many bubbles that took."""

    net: EllipseNet
    deleted: int
    inserted: int


def controlled(ellipses: EllipseNet, spacing: MetricSpacing, defects: Defects) -> Controlled:
    """The net with bubbles deleted and inserted by the defects, no two of them next to each other."""
    net, lengths, lacking = ellipses.net, ellipses.lengths, _lacking(ellipses, spacing)
    triangles, gone = removed(net.bubbles.x, net.triangles, _crowded(ellipses, lengths, defects, -lacking))
    halved = _too_long(ellipses, lengths, gone, defects, lacking)
    number, count = np.cumsum(~gone) - 1, int(gone.sum())
    rest = net.bubbles.select(np.flatnonzero(~gone))
    spliced = with_middles(number[triangles], number[halved], len(rest))
    if spliced is None:
        spliced, halved = number[triangles], halved[:0]
    x = net.bubbles.x[halved].mean(axis=1)
    grown = rest.append(x, np.ones(len(x)))
    return Controlled(flipped_net(net, grown, spliced, spacing), count, len(x))


def _lacking(ellipses: EllipseNet, spacing: MetricSpacing) -> int:
    """Number of bubbles that the area lacks in the metric; negative if there are too many.

    Each inner bubble has two triangles, whose area is sqrt(3) / 4 in the metric if they are equilateral.
    """
    x, triangles = ellipses.net.bubbles.x, ellipses.net.triangles
    areas = np.abs(doubled_areas(x[triangles])) / 2 / spacing.extended(x[triangles].mean(axis=1)) ** 2
    return round((float(areas.sum()) / AREA_OF_TRIANGLE - len(triangles)) / 2)


def _crowded(ellipses: EllipseNet, lengths: Floats, defects: Defects, excess: int) -> Booleans:
    """Interior bubbles (n,) that are too near to others, or have too few neighbours; no two have an edge."""
    net, interior = ellipses.net, ellipses.interior
    valence = net.valence
    chosen = interior & (valence <= FEWEST_NEIGHBOURS)
    # What lies in a corner's angle cannot give way: it takes more to be too near to its neighbours.
    at_corner = net.dilated(np.arange(len(valence)) < net.bubbles.corners)[net.edges].any(axis=1)
    short = lengths < np.where(at_corner, TOO_NEAR_CORNER, defects.delete_shorter)
    short |= ~at_corner & (lengths < min(_nth_least(lengths, excess), SHORT))
    i, j = net.edges[short].T
    second = interior[j] & ((valence[j] <= valence[i]) | ~interior[i])
    loser = np.where(second, j, i)
    chosen[loser[interior[loser]]] = True
    return maximal_independent_set(chosen, net.edges, np.arange(len(chosen)))


def _nth_least(numbers: Floats, count: int) -> float:
    """The number below which there are so many of some (n,); none for a count that is not positive."""
    return float(np.partition(numbers, count)[count]) if 0 < count < len(numbers) else -np.inf


def _too_long(ellipses: EllipseNet, lengths: Floats, gone: Booleans, defects: Defects, lacking: int) -> Integers:
    """Edges (k, 2) with room for one more bubble, no two of them at one bubble, the longest first."""
    net = ellipses.net
    crowd = (net.valence >= MANY_NEIGHBOURS)[net.edges].any(axis=1)
    long = lengths > np.where(crowd, defects.insert_longer_at_crowd, defects.insert_longer)
    long |= lengths > max(-_nth_least(-lengths, lacking), LONG)
    long &= net.inner & ~gone[net.edges].any(axis=1)
    edges = net.edges[long]
    edges = np.concatenate([edges[np.argsort(-lengths[long], kind="stable")], _across_wide_corners(ellipses, gone)])
    rank, first = np.arange(len(edges)), np.full(len(net.bubbles), len(edges))
    np.minimum.at(first, edges, rank[:, None])
    return edges[(first[edges] == rank[:, None]).all(axis=1)]


def _across_wide_corners(ellipses: EllipseNet, gone: Booleans) -> Integers:
    """Edges (k, 2) inside the domain that face, in the metric, too wide an angle at a corner of the boundary."""
    net, x, corners = ellipses.net, ellipses.net.bubbles.x, ellipses.net.bubbles.corners
    first = np.argmin(net.triangles, axis=1)
    beside = np.flatnonzero((net.triangles.min(axis=1) < corners) & ~gone[net.triangles].any(axis=1))
    apex, a, b = (net.triangles[beside, (first[beside] + k) % 3] for k in range(3))
    root = roots(ellipses.tensors[apex])
    u, v = mapped(root, x[a] - x[apex]), mapped(root, x[b] - x[apex])
    wide = np.einsum("ij,ij->i", u, v) < WIDEST_CORNER * np.hypot(*u.T) * np.hypot(*v.T)
    roomy = np.hypot(*(u + v).T) / 2 > NEAREST_TO_CORNER
    faced = np.column_stack([a, b])[wide & roomy]
    return faced[~net.are_facets(faced)]
