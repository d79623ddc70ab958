"""Population control in a metric: ellipses go from edges that are too short, and come to those that are too long."""

from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.kernels.tensors import mapped, roots
from bubblemesh.meshes.edges import numbered_edges
from bubblemesh.meshes.quality import doubled_areas
from bubblemesh.meshes.tensors import determinants
from bubblemesh.packing.ellipses.net import EllipseNet, flipped_net
from bubblemesh.packing.neighbours import maximal_independent_set
from bubblemesh.packing.population import (
    FEWEST_NEIGHBOURS,
    MANY_NEIGHBOURS,
    TOO_NEAR_CORNER,
    EdgeLimits,
    facing_wide_corners,
    losers,
)
from bubblemesh.packing.splicing import removed, with_middles
from bubblemesh.records import record
from bubblemesh.spacing.metric.metric import MetricSpacing

AREA_OF_TRIANGLE = np.sqrt(3) / 4  # with sides of 1
SHORT, LONG = 0.9, 1.1  # edges that make a bubble go or come where there are too many or too few around
HALF, QUARTER = 0.5, 0.25  # of a bubble: what is too much there, and the least that is where the whole has too many


class Controlled(NamedTuple):
    """A net after population control, how many bubbles came, and how many are missing."""

    net: EllipseNet
    inserted: int
    missing: int  # bubbles that the area lacks yet, negative for too many


class Lack(NamedTuple):
    """Bubbles that the area lacks in the metric; negative for too many."""

    around: Floats  # (m,): near the middle of each edge
    whole: int


@record
class EllipseDefects(EdgeLimits):
    """Deletion and insertion of ellipses where edges are too short or too long, and the area around confirms it."""

    def __call__(self, ellipses: EllipseNet, spacing: MetricSpacing) -> Controlled:
        """The net with bubbles deleted and inserted, no two of them next to each other."""
        net, lengths, lacking = ellipses.net, ellipses.lengths, _lacking(ellipses, spacing)
        triangles, gone = removed(net.bubbles.x, net.triangles, self._crowded(ellipses, lengths, lacking))
        halved = self._too_long(ellipses, lengths, gone, lacking)
        number = np.cumsum(~gone) - 1
        rest = net.bubbles.select(np.flatnonzero(~gone))
        spliced = with_middles(number[triangles], number[halved], len(rest))
        if spliced is None:
            spliced, halved = number[triangles], halved[:0]
        x = net.bubbles.x[halved].mean(axis=1)
        grown = rest.append(x, np.ones(len(x)))
        missing = lacking.whole + int(gone.sum()) - len(x)
        return Controlled(flipped_net(net, grown, spliced, spacing), len(x), missing)

    def _crowded(self, ellipses: EllipseNet, lengths: Floats, lacking: Lack) -> Booleans:
        """Interior bubbles (n,) that are too near to others, or have too few neighbours; no two have an edge."""
        net, interior = ellipses.net, ellipses.interior
        valence = net.valence
        chosen = interior & (valence <= FEWEST_NEIGHBOURS)
        # What lies in a corner's angle cannot give way: it takes more to be too near to its neighbours.
        at_corner = net.dilated(np.arange(len(valence)) < net.bubbles.corners)[net.edges].any(axis=1)
        short = (lengths < self.delete_shorter) & (lacking.around < 0)
        short |= (lengths < SHORT) & (-lacking.around >= _bar(-lacking.around[lengths < SHORT], -lacking.whole))
        short = np.where(at_corner, lengths < TOO_NEAR_CORNER, short)
        i, j = net.edges[short].T
        chosen[losers(i, j, valence, interior)] = True
        shortest = np.full(len(valence), np.inf)
        np.minimum.at(shortest, net.edges, lengths[:, None])
        rank = np.empty(len(valence), np.int64)
        rank[np.argsort(shortest, kind="stable")] = np.arange(len(valence))
        return maximal_independent_set(chosen, net.edges, rank)

    def _too_long(self, ellipses: EllipseNet, lengths: Floats, gone: Booleans, lacking: Lack) -> Integers:
        """Edges (k, 2) with room for one more bubble, the longest first, no two of them at bubbles that have an edge.

        So each has the room around to itself, in which no bubble has gone either.
        """
        net = ellipses.net
        crowd = (net.valence >= MANY_NEIGHBOURS)[net.edges].any(axis=1)
        long = (lengths > np.where(crowd, self.insert_longer_at_crowd, self.insert_longer)) & (lacking.around > 0)
        long |= (lengths > LONG) & (lacking.around >= _bar(lacking.around[lengths > LONG], lacking.whole))
        long &= net.inner & ~net.dilated(gone)[net.edges].any(axis=1)
        edges = net.edges[long]
        edges = np.concatenate([edges[np.argsort(-lengths[long], kind="stable")], _across_wide_corners(ellipses, gone)])
        rank, first = np.arange(len(edges)), np.full(len(net.bubbles), len(edges))
        np.minimum.at(first, edges, rank[:, None])
        near = first.copy()
        for some, others in (net.edges.T, net.edges.T[::-1]):
            np.minimum.at(near, some, first[others])
        return edges[(near[edges] == rank[:, None]).all(axis=1)]


def _lacking(ellipses: EllipseNet, spacing: MetricSpacing) -> Lack:
    """Number of bubbles that the area in the metric lacks around each edge, and in all.

    Each inner bubble has two triangles, whose area is sqrt(3) / 4 in the metric if they are equilateral. What all of
    them lack together is shared among their nodes, and summed up over the neighbours of both ends.
    """
    x, triangles, (i, j), n = (
        ellipses.net.bubbles.x,
        ellipses.net.triangles,
        ellipses.net.edges.T,
        len(ellipses.tensors),
    )
    # Areas by the cubature that is exact for densities of the third degree; at seven places a layer is seldom missed.
    at_nodes = np.sqrt(determinants(ellipses.tensors))[triangles].sum(axis=1)
    edges, sides = numbered_edges(triangles)
    inside = 1 / spacing.extended(np.concatenate([x[triangles].mean(axis=1), x[edges].mean(axis=1)])) ** 2
    at_center, at_middles = inside[: len(triangles)], inside[len(triangles) :][sides].sum(axis=1)
    density = (27 * at_center + 8 * at_middles + 3 * at_nodes) / 60
    areas = density * np.abs(doubled_areas(x[triangles])) / 2
    own = np.bincount(triangles.ravel(), np.repeat((areas / AREA_OF_TRIANGLE - 1) / 6, 3), n)
    around = own + np.bincount(i, own[j], n) + np.bincount(j, own[i], n)
    return Lack(np.asarray((around[i] + around[j]) / 2), round(float(own.sum())))


def _bar(lacks: Floats, whole: int) -> float:
    """Lack around an edge that makes a bubble come: half of one, or less where some more lack in the whole.

    Then as many of the places with the largest lacks (k,) are enough.
    """
    if not 0 < whole <= len(lacks):
        return HALF
    return min(max(float(-np.partition(-lacks, whole - 1)[whole - 1]), QUARTER), HALF)


def _across_wide_corners(ellipses: EllipseNet, gone: Booleans) -> Integers:
    """Edges (k, 2) inside the domain that face, in the metric, too wide an angle at a corner of the boundary."""
    return facing_wide_corners(ellipses.net, gone, lambda at, v: mapped(roots(ellipses.tensors[at]), v))
