"""Bubbles connected by a constrained Delaunay triangulation."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.domain import Domain
from bubblemesh.kernels.linking import legalised
from bubblemesh.meshes.edges import directed_sides, edge_keys, find_keys, one_sided
from bubblemesh.meshes.triangulation import linked
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.neighbours import next_to
from bubblemesh.spacing.spacing import Spacing


@dataclass(frozen=True)
class Net:
    """Bubbles with the triangulation of their centres."""

    bubbles: Bubbles
    facets: Integers  # (b, 2): edges along pieces of the boundary; those of its rings have the domain on their left
    facet_piece: Integers  # (b,): boundary piece of each facet
    two_sided: Booleans  # (b,): facets with the domain on both sides
    triangles: Integers  # (t, 3): counter-clockwise
    edges: Integers  # (m, 2): every edge of a triangle once

    @cached_property
    def valence(self) -> Integers:
        """Number of edges (n,) at each bubble."""
        return np.bincount(self.edges.ravel(), minlength=len(self.bubbles))

    @cached_property
    def inner(self) -> Booleans:
        """Edges (m,) that are not part of the boundary."""
        inner = np.ones(len(self.edges), bool)
        chords = np.flatnonzero((self.edges < self.bubbles.boundary_count).all(axis=1))
        inner[chords] = ~self.are_facets(self.edges[chords])
        return inner

    def are_facets(self, pairs: Integers) -> Booleans:
        """Pairs (k, 2) of bubbles that are, in either order, the ends of a facet."""
        n = len(self.bubbles)
        return np.isin(edge_keys(np.sort(pairs, axis=1), n), edge_keys(np.sort(self.facets, axis=1), n))

    def dilated(self, marked: Booleans) -> Booleans:
        """Bubbles (n,) that are marked or next to one that is."""
        return marked | next_to(self.edges, marked)

    def within(self, bubbles: Integers, rings: int) -> Booleans:
        """Bubbles (n,) at most so many edges away from the given ones, of any shape."""
        near = np.zeros(len(self.bubbles), bool)
        near[bubbles] = True
        for _ in range(rings):
            near = self.dilated(near)
        return near

    def part(self, marked: Booleans) -> tuple[Integers, "Net"]:
        """Numbers (k,) and net of the marked bubbles and all corners; facets that cut it off have the piece -1."""
        chosen = marked.copy()
        chosen[: self.bubbles.corners] = True
        numbers, renumbered = np.flatnonzero(chosen), np.cumsum(chosen) - 1
        triangles = self.triangles[marked[self.triangles].all(axis=1)]
        n, sides = len(self.bubbles), directed_sides(triangles)
        rim = sides[np.sort(one_sided(sides, n))]
        own, forth = edge_keys(self.facets, n), edge_keys(sides, n)
        order = np.argsort(own)
        place = find_keys(own[order], edge_keys(rim, n))
        piece = np.where(place < 0, -1, self.facet_piece[order[place]])
        within = np.isin(own, forth) & np.isin(edge_keys(self.facets[:, ::-1], n), forth)
        edges = self.edges[marked[self.edges].all(axis=1)]
        return numbers, Net(
            bubbles=self.bubbles.select(numbers),
            facets=renumbered[np.concatenate([rim, self.facets[within]])],
            facet_piece=np.concatenate([piece, self.facet_piece[within]]),
            two_sided=np.arange(len(rim) + int(within.sum())) >= len(rim),
            triangles=renumbered[triangles],
            edges=renumbered[edges],
        )


def connect(bubbles: Bubbles, domain: Domain, before: Net | None = None) -> Net:
    """Connect bubbles; those outside the boundary edges belong to no triangle.

    If they are those of a net ``before``, with the same ones on the boundary, that may spare most of the work.
    """
    if before is not None and len(bubbles) == len(before.bubbles) and _same_on_boundary(before.bubbles, bubbles):
        return _moved_inside(before, bubbles)
    facets, piece = domain.boundary.edges(bubbles.piece, bubbles.s)
    two_sided = domain.boundary.inner[piece]
    return Net(bubbles, facets, piece, two_sided, *linked(bubbles.x, facets, two_sided))


def reconnect(net: Net, bubbles: Bubbles) -> Net:
    """Connect the bubbles of a net anew at other places, within the same facets."""
    if _same_on_boundary(net.bubbles, bubbles):
        return _moved_inside(net, bubbles)
    return _triangulated_anew(net, bubbles)  # flips would not see boundary edges that cross each other on the outside


def _moved_inside(net: Net, bubbles: Bubbles) -> Net:
    """Net of the bubbles of another one whose places on the boundary are the same, by flips if these will do."""
    found = _flipped(net, bubbles.x) if (net.valence > 0).all() else None
    if found is None:
        return _triangulated_anew(net, bubbles)
    return replace(net, bubbles=bubbles, triangles=found[0], edges=found[1])


def _flipped(net: Net, x: Floats) -> tuple[Integers, Integers] | None:
    """Triangles and edges of a net for its bubbles at x (n, 2), where flips lead to them; None elsewhere.

    The net's bubbles may have moved since its triangles were made: on the way by where they are fewer are inverted.
    """
    found = legalised(net.triangles, x, net.facets)
    if found is None and (halfway := legalised(net.triangles, net.bubbles.x, net.facets)) is not None:
        return legalised(halfway[0], x, net.facets)
    return found


def _triangulated_anew(net: Net, bubbles: Bubbles) -> Net:
    triangles, edges = linked(bubbles.x, net.facets, net.two_sided)
    return replace(net, bubbles=bubbles, triangles=triangles, edges=edges)


def _same_on_boundary(some: Bubbles, others: Bubbles) -> bool:
    """Whether the bubbles on the boundary are the same ones at the same places."""
    count = some.boundary_count
    same = count == others.boundary_count and np.array_equal(some.piece, others.piece)
    return same and np.array_equal(some.s, others.s) and np.array_equal(some.x[:count], others.x[:count])


def connect_inside(bubbles: Bubbles, domain: Domain, spacing: Spacing, before: Net | None = None) -> Net:
    """Connect bubbles without those outside, and evaluate the spacing where they are.

    For a net ``before`` see `connect`.
    """
    net = connect(bubbles, domain, before)
    kept = net.valence > 0
    d = np.where(kept, 0.0, np.nan)
    d[kept] = spacing.extended(bubbles.x[kept])
    if kept.all():
        return replace(net, bubbles=replace(bubbles, d=d))
    number = np.cumsum(kept) - 1
    rest = replace(bubbles, d=d).select(np.flatnonzero(kept))
    renumbered = {name: number[getattr(net, name)] for name in ("facets", "triangles", "edges")}
    return replace(net, bubbles=rest, **renumbered)
