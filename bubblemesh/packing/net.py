"""Bubbles connected by a constrained Delaunay triangulation."""

from dataclasses import field
from functools import cached_property

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers, all_of_rows, taken
from bubblemesh.geometry.domain import Domain
from bubblemesh.kernels.linking import Legal, legalised
from bubblemesh.meshes.edges import directed_sides, edge_keys, find_keys, one_sided
from bubblemesh.meshes.quality import REGULAR_VALENCE
from bubblemesh.meshes.triangulation import linked
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.lost_bubbles import connected_without_lost
from bubblemesh.packing.neighbours import next_to
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing


@record
class Net:
    """Bubbles with the triangulation of their centres."""

    bubbles: Bubbles
    facets: Integers  # (b, 2): edges along pieces of the boundary; those of its rings have the domain on their left
    facet_piece: Integers  # (b,): boundary piece of each facet
    two_sided: Booleans  # (b,): facets with the domain on both sides
    triangles: Integers  # (t, 3): counter-clockwise
    edges: Integers  # (m, 2): every edge of a triangle once
    legal: Legal | None = field(
        default=None, compare=False
    )  # the Delaunay state after flips; None if triangulated afresh
    connected_at: Floats | None = field(default=None, compare=False)  # places (n, 2), if the bubbles have moved since
    straight: bool = False  # whether every facet is a part of a straight wall, or known never to move

    def of(self, bubbles: Bubbles) -> "Net":
        """Net with the same facets and triangles, of as many other bubbles, or of these at other places."""
        return self._joined(bubbles, self.triangles, self.edges, self.legal, self.start)

    def spaced_by(self, spacing: Spacing) -> "Net":
        """The net whose bubbles have the spacing where they are."""
        return self.of(self.bubbles.moved(self.bubbles.x, spacing.extended(self.bubbles.x)))

    def by(self, legal: Legal, bubbles: Bubbles, connected_at: Floats | None = None) -> "Net":
        """Net with the same facets, of as many bubbles that flips have connected where they are, or were."""
        return self._joined(bubbles, legal.triangles, legal.edges, legal, connected_at)

    def afresh(self, triangles: Integers, edges: Integers) -> "Net":
        """Net with the same facets and bubbles, of other triangles and edges."""
        return self._joined(self.bubbles, triangles, edges, None, None)

    def _joined(
        self, bubbles: Bubbles, triangles: Integers, edges: Integers, legal: Legal | None, connected_at: Floats | None
    ) -> "Net":
        # There are so many of them that `replace`, which asks for all fields, would take a share of the time.
        bounds = self.facets, self.facet_piece, self.two_sided
        return Net(bubbles, *bounds, triangles, edges, legal, connected_at, self.straight)

    @property
    def start(self) -> Floats:
        """Places (n, 2) of the bubbles when they were connected, from which flips go on."""
        return self.bubbles.x if self.connected_at is None else self.connected_at

    @cached_property
    def valence(self) -> Integers:
        """Number of edges (n,) at each bubble."""
        return np.bincount(self.edges.ravel(), minlength=len(self.bubbles))

    @property
    def disorder(self) -> float:
        """Share of the bubbles inside that do not have six neighbours."""
        inside = self.valence[self.bubbles.boundary_count :]
        return float((inside != REGULAR_VALENCE).mean()) if len(inside) else 0.0

    @cached_property
    def inner(self) -> Booleans:
        """Edges (m,) that are not part of the boundary."""
        inner = np.ones(len(self.edges), bool)
        chords = np.flatnonzero(all_of_rows(self.edges < self.bubbles.boundary_count))
        inner[chords] = ~self.are_facets(self.edges[chords])
        return inner

    def are_facets(self, pairs: Integers) -> Booleans:
        """Pairs (k, 2) of bubbles that are, in either order, the ends of a facet."""
        return find_keys(self._facet_keys, edge_keys(np.sort(pairs, axis=1), len(self.bubbles))) >= 0

    @cached_property
    def _facet_keys(self) -> Integers:
        return np.sort(edge_keys(np.sort(self.facets, axis=1), len(self.bubbles)))

    @cached_property
    def turns(self) -> Floats:
        """Angles (n,) by which the boundary turns at its bubbles, in radians if they are small."""
        i, j = self.facets.T
        along, n = taken(self.bubbles.x, j) - taken(self.bubbles.x, i), len(self.bubbles)
        along /= np.hypot(*along.T)[:, None]
        return np.hypot(*(np.bincount(i, part, minlength=n) - np.bincount(j, part, minlength=n) for part in along.T))

    def has_facets_of(self, other: "Net") -> bool:
        """Whether the facets are those of another net, on the same pieces of the boundary."""
        return np.array_equal(self.facets, other.facets) and np.array_equal(self.facet_piece, other.facet_piece)

    @property
    def has_simple_rim(self) -> bool:
        """Whether the facets with the domain on one side neither cross nor touch each other but at their ends."""
        if self.straight:  # the walls of a domain do not
            return True
        sides = shapely.linestrings(self.bubbles.x[self.facets[~self.two_sided]])
        return bool(shapely.is_simple(shapely.multilinestrings(sides)))

    def dilated(self, marked: Booleans, rings: int = 1) -> Booleans:
        """Bubbles (n,) that are marked, or at most so many edges away from one that is."""
        for _ in range(rings):
            marked = marked | next_to(self.edges, marked)
        return marked

    def within(self, bubbles: Integers, rings: int) -> Booleans:
        """Bubbles (n,) at most so many edges away from the given ones, of any shape."""
        near = np.zeros(len(self.bubbles), bool)
        near[bubbles] = True
        return self.dilated(near, rings)

    def part(self, marked: Booleans) -> tuple[Integers, "Net"]:
        """Numbers (k,) and net of the marked bubbles and all corners; facets that cut it off have the piece -1."""
        chosen = marked.copy()
        chosen[: self.bubbles.corners] = True
        numbers, renumbered = np.flatnonzero(chosen), np.cumsum(chosen) - 1
        triangles = self.triangles[all_of_rows(marked[self.triangles])]
        n, sides = len(self.bubbles), directed_sides(triangles)
        rim = sides[np.sort(one_sided(sides, n))]
        own, back, known = edge_keys(self.facets, n), edge_keys(self.facets[:, ::-1], n), np.sort(edge_keys(sides, n))
        order = np.argsort(own)
        place = find_keys(own[order], edge_keys(rim, n))
        piece = np.where(place < 0, -1, self.facet_piece[order[place]])
        within = (find_keys(known, own) >= 0) & (find_keys(known, back) >= 0)
        edges = self.edges[all_of_rows(marked[self.edges])]
        return numbers, Net(
            bubbles=self.bubbles.select(numbers),
            facets=renumbered[np.concatenate([rim, self.facets[within]])],
            facet_piece=np.concatenate([piece, self.facet_piece[within]]),
            two_sided=np.arange(len(rim) + int(within.sum())) >= len(rim),
            triangles=renumbered[triangles],
            edges=renumbered[edges],
            straight=self.straight,
        )


def connect(bubbles: Bubbles, domain: Domain, before: Net | None = None, triangles: Integers | None = None) -> Net:
    """Connect bubbles; those outside the boundary edges belong to no triangle.

    A net ``before`` of as many bubbles, with the same boundary edges, may spare most of the work: flips go on from its
    triangles. So they do from other ``triangles`` (t, 3) of the region, counter-clockwise between these bubbles where
    they are now, however many these are.
    """
    if before is None or (triangles is None and len(bubbles) != len(before.bubbles)):
        return _triangulated(unconnected(bubbles, domain))
    if _same_on_boundary(before.bubbles, bubbles):
        return reconnect(before, bubbles, triangles)
    net = unconnected(bubbles, domain)
    if net.has_facets_of(before):
        return reconnect(before, bubbles, triangles)
    return _triangulated(net) if triangles is None else reconnect(net, bubbles, triangles)


def reconnect(net: Net, bubbles: Bubbles, triangles: Integers | None = None) -> Net:
    """Connect the bubbles of a net anew at other places, within the same facets: by flips if these will do.

    With ``triangles`` (t, 3), as in `connect`, they may be other bubbles.
    """
    count = bubbles.boundary_count
    held = _same_on_boundary(net.bubbles, bubbles)
    stays = held and triangles is None and np.array_equal(net.start[:count], bubbles.x[:count])
    start = net.start if stays else bubbles.x
    found: Legal | None = None
    if triangles is None and net.legal is not None:
        found = legalised(net.triangles, start, bubbles.x, net.facets, net.legal)
    elif _all_within(known := net.triangles if triangles is None else triangles, bubbles):
        found = legalised(known, start, bubbles.x, net.facets)
    # Flips do not see rims that cross each other on the outside, as they might do on their way, too.
    moved = net.of(bubbles) if found is None else net.by(found, bubbles)
    if found is not None and (held or moved.has_simple_rim):
        return moved
    return (_without_lost(net, moved) if stays else None) or _triangulated(moved)


def unconnected(bubbles: Bubbles, domain: Domain) -> Net:
    """Bubbles of a domain with their boundary edges, and no triangles."""
    facets, piece = domain.boundary.edges(bubbles.piece, bubbles.s)
    inner, straight = domain.boundary.inner[piece], not domain.boundary.curved[piece].any()
    return Net(bubbles, facets, piece, inner, np.zeros((0, 3), int), np.zeros((0, 2), int), straight=straight)


def _all_within(triangles: Integers, bubbles: Bubbles) -> bool:
    """Whether every bubble is a node of a triangle, but for corners, which may be of other parts."""
    within = np.zeros(len(bubbles), bool)
    within[triangles] = True
    return bool(within[bubbles.corners :].all())


def _without_lost(before: Net, net: Net) -> Net | None:
    """A net with bubbles outside, which belong to no triangle, by flips from the one before they left, if these do."""
    if len(net.facets) == 0:
        return None
    ways = before.start, net.bubbles.x, before.triangles, before.edges
    found = connected_without_lost(*ways, net.facets, net.facets[~net.two_sided])
    if found is None:
        return None
    return net.afresh(*found)


def _triangulated(net: Net) -> Net:
    return net.afresh(*linked(net.bubbles.x, net.facets, net.two_sided))


def _same_on_boundary(some: Bubbles, others: Bubbles) -> bool:
    """Whether the bubbles on the boundary are the same ones at the same places."""
    count = some.boundary_count
    same = count == others.boundary_count and _equal(some.piece, others.piece) and _equal(some.s, others.s)
    return same and np.array_equal(some.x[:count], others.x[:count])


def _equal(some: Floats | Integers, others: Floats | Integers) -> bool:
    return some is others or np.array_equal(some, others)


def connect_within(
    bubbles: Bubbles, domain: Domain, before: Net | None = None, triangles: Integers | None = None
) -> Net:
    """Connect bubbles without those outside.

    For a net ``before`` and ``triangles`` (t, 3) see `connect`.
    """
    net = connect(bubbles, domain, before, triangles)
    if net.legal is not None or (kept := net.valence > 0).all():  # flips lose none
        return net
    number = np.cumsum(kept) - 1
    facets, triangles, edges = (number[of_bubbles] for of_bubbles in (net.facets, net.triangles, net.edges))
    rest = bubbles.select(np.flatnonzero(kept))
    return Net(rest, facets, net.facet_piece, net.two_sided, triangles, edges, straight=net.straight)


def connect_inside(
    bubbles: Bubbles, domain: Domain, spacing: Spacing, before: Net | None = None, triangles: Integers | None = None
) -> Net:
    """Connect bubbles as `connect_within`, and evaluate the spacing where they are."""
    return connect_within(bubbles, domain, before, triangles).spaced_by(spacing)
