"""Bubbles connected by a constrained Delaunay triangulation."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from bubblemesh.arrays import Booleans, Integers
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.triangulation import linked

__all__ = ["Net", "connected", "enmeshed"]


@dataclass(frozen=True)
class Net:
    """Bubbles with the triangulation of their centres.

    Attributes
    ----------
    bubbles : Bubbles
    facets : (b, 2)
        Boundary edges, with the domain on their left.
    facet_piece : (b,)
        The boundary piece that each of them follows.
    triangles : (t, 3)
        Counter-clockwise.
    edges : (m, 2)
        Every edge of the triangles once.
    """

    bubbles: Bubbles
    facets: Integers
    facet_piece: Integers
    triangles: Integers
    edges: Integers

    @cached_property
    def valence(self) -> Integers:
        """Number of edges (n,) at each bubble."""
        return np.bincount(self.edges.ravel(), minlength=len(self.bubbles))

    @cached_property
    def inner(self) -> Booleans:
        """Which edges (m,) are not part of the boundary."""
        n, last = len(self.bubbles), self.bubbles.boundary_count
        inner = np.ones(len(self.edges), bool)
        chords = np.flatnonzero((self.edges < last).all(axis=1))
        low, high = np.sort(self.facets, axis=1).T
        mine = np.sort(self.edges[chords], axis=1)
        inner[chords[np.isin(mine[:, 0] * n + mine[:, 1], low * n + high)]] = False
        return inner


def connected(bubbles: Bubbles, domain: Domain) -> Net:
    """The net of the bubbles; those outside the boundary edges belong to no triangle."""
    facets, piece = domain.boundary.edges(bubbles.piece, bubbles.s)
    return Net(bubbles, facets, piece, *linked(bubbles.x, facets))


def enmeshed(bubbles: Bubbles, domain: Domain, spacing: Spacing) -> Net:
    """The net of the bubbles without those outside, with the spacing at their present places."""
    net = connected(bubbles, domain)
    kept = net.valence > 0
    d = np.where(kept, 0.0, np.nan)
    d[kept] = spacing.extended(bubbles.x[kept])
    if kept.all():
        return replace(net, bubbles=replace(bubbles, d=d))
    number = np.cumsum(kept) - 1
    rest = replace(bubbles, d=d).kept(np.flatnonzero(kept))
    return Net(rest, number[net.facets], net.facet_piece, number[net.triangles], number[net.edges])
