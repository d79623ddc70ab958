"""Ellipses connected by a triangulation that is Delaunay in their metric."""

from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.domain import Domain
from bubblemesh.kernels.ellipse_flips import flipped
from bubblemesh.kernels.ellipse_motion import moved
from bubblemesh.kernels.tensors import lengths
from bubblemesh.meshes.tensors import area_sizes, edge_lengths
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.net import Net, connect
from bubblemesh.spacing.metric.metric import MetricSpacing

NEAR = 0.1  # in the metric: tensors evaluated so near to a bubble do for it


class EllipseNet(NamedTuple):
    """Bubbles with their triangulation, and the tensors of their ellipses.

    Bubbles never leave the triangles around them: the same facets hold from one triangulation anew to the next.
    """

    net: Net
    tensors: Floats  # (n, 3)
    known: Floats  # (n, 2): where these were evaluated, near the bubbles

    @property
    def lengths(self) -> Floats:
        """Lengths (m,) of the edges in the metric."""
        return edge_lengths(self.net.bubbles.x, self.tensors, self.net.edges)

    @property
    def interior(self) -> Booleans:
        """Mask (n,) of the bubbles inside the domain."""
        return np.arange(len(self.tensors)) >= self.net.bubbles.boundary_count

    def displaced(self, moves: Floats) -> "EllipseNet":
        """The net after moves (n, 2) of bubbles, as far as they invert no triangle, and flips in the same tensors."""
        x, _ = moved(self.net.bubbles.x, moves, self.net.triangles)
        return _flipped(self.net, self.net.bubbles.moved(x), self.net.triangles, self.tensors, self.known)

    def moved(self, x: Floats, spacing: MetricSpacing) -> "EllipseNet":
        """The net with its bubbles at x (n, 2), where no triangle is inverted, after flips."""
        tensors, known, far = self.tensors.copy(), self.known.copy(), lengths(self.tensors, x - self.known) > NEAR
        if far.any():
            tensors[far], known[far] = spacing.at(x[far]), x[far]
        return _flipped(self.net, self.net.bubbles.moved(x), self.net.triangles, tensors, known)

    def at(self, x: Floats) -> "EllipseNet":
        """Net with the same triangles and tensors, with the bubbles at x (n, 2)."""
        return EllipseNet(self.net.of(self.net.bubbles.moved(x)), self.tensors, self.known)

    def by(self, x: Floats, triangles: Integers, edges: Integers) -> "EllipseNet":
        """Net with the same tensors, with the bubbles at x (n, 2), triangles (t, 3) after flips, and edges (e, 2)."""
        return _linked(self.net, self.net.bubbles.moved(x), triangles, edges, self.tensors, self.known)


def flipped_net(net: Net, bubbles: Bubbles, triangles: Integers, spacing: MetricSpacing) -> EllipseNet:
    """Bubbles with the facets of a net, and their triangles (t, 3) after flips."""
    return _flipped(net, bubbles, triangles, spacing.at(bubbles.x), bubbles.x)


def _flipped(net: Net, bubbles: Bubbles, triangles: Integers, tensors: Floats, known: Floats) -> EllipseNet:
    return _linked(net, bubbles, *flipped(triangles, bubbles.x, tensors, net.facets), tensors, known)


def _linked(
    net: Net, bubbles: Bubbles, triangles: Integers, edges: Integers, tensors: Floats, known: Floats
) -> EllipseNet:
    there = bubbles.moved(bubbles.x, area_sizes(tensors))
    return EllipseNet(Net(there, net.facets, net.facet_piece, net.two_sided, triangles, edges), tensors, known)


def connected(bubbles: Bubbles, domain: Domain, spacing: MetricSpacing) -> EllipseNet:
    """Bubbles of a domain triangulated anew, without those outside."""
    net = connect(bubbles, domain)
    kept = (net.valence > 0) | (np.arange(len(bubbles)) < bubbles.boundary_count)
    if not kept.all():
        net = connect(bubbles.select(np.flatnonzero(kept)), domain)
    return flipped_net(net, net.bubbles, net.triangles, spacing)
