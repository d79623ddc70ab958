"""Refinement: nodes are added until no angle is smaller, no triangle larger, and none less free than asked for.

References
----------
J. Ruppert, "A Delaunay refinement algorithm for quality 2-dimensional mesh generation", J. Algorithms 18 (1995);
L. P. Chew, "Guaranteed-quality mesh generation for curved surfaces", SoCG 1993, for nodes that a split edge removes;
G. L. Miller, S. E. Pav, N. J. Walkington, "When and why Delaunay refinement algorithms work", Int. J. Comput. Geom.
Appl. 15 (2005), for sharp corners; A. Ungor, "Off-centers", Comput. Geom. 42 (2009), for where nodes are added.
"""

from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers, all_of_rows, others
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.periodic import counterparts, matching_edges
from bubblemesh.meshes.edges import edge_keys, find_keys
from bubblemesh.meshes.quality import angles, signed_areas
from bubblemesh.meshes.triangulation import circumcircles, regions
from bubblemesh.messages import node_limit, place
from bubblemesh.packing.boundary_edges import split_cutting_edges
from bubblemesh.packing.demands import Demands
from bubblemesh.packing.net import Net, connect, connect_inside, reconnect
from bubblemesh.packing.progress import TimeUp, Watch
from bubblemesh.packing.sharp_corners import SharpCorners
from bubblemesh.packing.smoothing import Smoothing
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing

ROUNDS = 1000
SHORTEST = 1e-10  # of the domain's size: edges that are not split any more
SHORTEST_IN_SPACINGS = 1e-4  # the same, in spacings: so short is no edge but where corners ask each other for nodes
ROUNDING = 1e-9  # relative
ALMOST = 0.99  # of the way to where the angle would be exactly as wanted
AROUND = 3  # rings of nodes around new ones that are smoothed
SMOOTHINGS, ATTEMPTS = 2, 6


class Excused(NamedTuple):
    """A corner of the domain that is sharper than allowed, and the least angle of the triangles that it excuses."""

    at: tuple[float, float]
    angle: float  # degrees


@record
class Refined:
    """A net after refinement."""

    net: Net
    added: int  # nodes more than before
    angle: float  # degrees: the least one of the triangles that no sharp corner excuses
    excess: float  # largest area of a triangle in terms of the one allowed, 0 if any is
    overconstrained: int  # triangles that need a node inside and have none
    excused: tuple[Excused, ...]
    stopped: str | None = None  # when or where, if demands are not met
    out_of_nodes: bool = False  # whether that was by the limit on these


class Faults(NamedTuple):
    """Triangles that are not as they have to be."""

    triangles: Integers  # (k,), the worst first
    sharp: Booleans  # (k,), whether an angle is too small, rather than the area too large


class Additions(NamedTuple):
    """Nodes to add: one in each of some facets (j,), and free ones at points (k, 2)."""

    facets: Integers
    points: Floats


@record
class Refinement:
    """The refinement of nets of a domain."""

    domain: Domain
    spacing: Spacing
    demands: Demands

    def __call__(self, net: Net, watch: Watch = lambda share: None) -> Refined:
        """The net with as many more nodes as the demands take, or as limits allow, smoothed around these."""
        start, most = net, self.demands.max_nodes
        net = replace(net, bubbles=replace(net.bubbles, touched=np.zeros(len(net.bubbles), bool)))
        stopped: str | None = f"after {ROUNDS} rounds"
        out_of_nodes = False
        for _ in range(ROUNDS):
            overconstrained, faults = self._overconstrained(net), self._faults(net)
            if len(overconstrained) + len(faults.triangles) == 0:
                stopped = None
                break
            try:
                watch(1.0)
            except TimeUp as reason:
                stopped = f"by {reason}"
                break
            grown = self._grown(net, self._freeing(net, overconstrained))
            if grown is None and len(faults.triangles):
                grown = self._grown(net, self._additions(net, faults))
            if grown is None:
                left = net.bubbles.x[net.triangles[np.append(faults.triangles, overconstrained)[0]]].mean(axis=0)
                stopped = f"where edges are too short or too near to each other to be split, as at {place(left)}"
                break
            out_of_nodes = len(grown.bubbles) > most
            if out_of_nodes:
                stopped = f"by {node_limit()}: {most}"
                break
            net = grown
        if len(net.bubbles) == len(start.bubbles) and not net.bubbles.touched.any():
            return self._result(start, 0, stopped, out_of_nodes)
        net = connect_inside(self._smoothed(net).bubbles, self.domain, self.spacing)
        return self._result(net, len(net.bubbles) - len(start.bubbles), stopped, out_of_nodes)

    @cached_property
    def _corners(self) -> SharpCorners:
        return SharpCorners(self.domain.boundary)

    def _least_angles(self, net: Net) -> tuple[Floats, Integers]:
        """Least angles (t,) of the triangles in degrees, and the corners (t,) that excuse those too small, or -1."""
        least = np.nan_to_num(angles(net.bubbles.x, net.triangles).min(axis=1))
        excusing = np.full(len(least), -1)
        found = np.flatnonzero(least < self.demands.angle * (1 - ROUNDING))
        excusing[found] = self._corners.excusing(net, net.triangles[found], self.demands.corner_angle)
        return least, excusing

    def _excess(self, net: Net) -> Floats:
        """Areas (t,) of the triangles in terms of the largest ones allowed."""
        areas, most = signed_areas(net.bubbles.x, net.triangles), np.array(self.demands.areas)
        if len(most) == 1:
            return np.asarray(areas / most[0])
        boundary, piece = self.domain.boundary, net.facet_piece
        region = regions(net.triangles, net.facets, boundary.left[piece], boundary.right[piece])
        return np.asarray(areas / most[region])

    def _faults(self, net: Net) -> Faults:
        """Triangles that break a demand and are not excused."""
        least, excusing = self._least_angles(net)
        sharp = (least < self.demands.angle * (1 - ROUNDING)) & (excusing < 0)
        which = np.flatnonzero(sharp | (self._excess(net) > 1 + ROUNDING))
        which = which[np.argsort(least[which], kind="stable")]
        return Faults(which, sharp[which])

    def _overconstrained(self, net: Net) -> Integers:
        """Triangles (k,) that need a node which is not on the rings of the domain, and have none."""
        if not self.demands.inner_node:
            return np.zeros(0, np.int64)
        on_rings = np.zeros(len(net.bubbles), bool)
        on_rings[net.facets[~net.two_sided]] = True
        return np.flatnonzero(all_of_rows(on_rings[net.triangles]))

    def _freeing(self, net: Net, triangles: Integers) -> Additions:
        """Nodes that give triangles (k,) a node inside: in the middle of their longest side that is on no ring.

        What is new beside it has that node, so that no other triangle comes to need one.
        """
        x, corners, n = net.bubbles.x, net.triangles[triangles], len(net.bubbles)
        facets = edge_keys(np.sort(net.facets, axis=1), n)
        order = np.argsort(facets)
        sides = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2)
        place = find_keys(facets[order], edge_keys(np.sort(sides.reshape(-1, 2), axis=1), n)).reshape(-1, 3)
        facet = np.where(place < 0, -1, order[place])
        length = np.hypot(*np.moveaxis(x[sides[:, :, 1]] - x[sides[:, :, 0]], 2, 0))
        length = np.where((facet < 0) | net.two_sided[facet], length, 0)
        rows, longest = np.arange(len(corners)), length.argmax(axis=1)
        facet, length = facet[rows, longest], length[rows, longest]
        points = np.where(length[:, None] > 0, x[sides[rows, longest]].mean(axis=1), x[corners].mean(axis=1))
        order = np.argsort(-length, kind="stable")
        order = order[(length[order] == 0) | (length[order] / 2 > self._least_half(points[order]))]
        chosen = order[_apart(points[order], length[order] / 2)]
        on_line = (facet[chosen] >= 0) & (length[chosen] > 0)
        return Additions(np.unique(facet[chosen[on_line]]), points[chosen[~on_line]])

    def _additions(self, net: Net, faults: Faults) -> Additions:
        """Nodes that mend the triangles: near their circumcentres, or in facets that these are too near to.

        Of nodes that are near to each other only the one for the worst triangle is taken.
        """
        a, b = np.moveaxis(net.bubbles.x[net.facets], 1, 0)
        points, room = self._centres(net, faults)
        number, facet, blind = self._hindering(net, faults.triangles, points)
        free = others(len(points), np.append(number, blind))
        facet = facet[np.sort(np.unique(facet, return_index=True)[1])]
        middles, half = (a[facet] + b[facet]) / 2, np.hypot(*(b[facet] - a[facet]).T) / 2
        long = half > self._least_half(middles)
        facet, middles, half = (some[long] for some in (facet, middles, half))
        chosen = _apart(np.vstack([middles, points[free]]), np.append(half, room[free]))
        split = facet[chosen[chosen < len(facet)]]
        return Additions(split, points[free[chosen[chosen >= len(facet)] - len(facet)]])

    def _least_half(self, points: Floats) -> Floats:
        """Half (n,) of the length of edges around points (n, 2) that are not split any more."""
        return np.maximum(SHORTEST * self.domain.size, SHORTEST_IN_SPACINGS * self.spacing.extended(points))

    def _centres(self, net: Net, faults: Faults) -> tuple[Floats, Floats]:
        """Points (k, 2) at which nodes mend the triangles, and their distances (k,) from the triangles' nodes.

        They are circumcentres, or nearer to the shortest side of sharp triangles, where the angle is as wanted.
        """
        corners = net.bubbles.x[net.triangles[faults.triangles]]
        centre, _ = circumcircles(corners.reshape(-1, 2), np.arange(3 * len(corners)).reshape(-1, 3))
        sides = np.hypot(*np.moveaxis(corners - np.roll(corners, -1, axis=1), 2, 0))
        rows, short = np.arange(len(corners)), sides.argmin(axis=1)
        p, q, other = (corners[rows, (short + k) % 3] for k in range(3))
        middle, along = (p + q) / 2, q - p
        inward = np.column_stack([-along[:, 1], along[:, 0]]) / np.maximum(np.hypot(*along.T), 1e-300)[:, None]
        length = np.hypot(*along.T)
        height = np.einsum("ij,ij->i", centre - middle, inward)
        if self.demands.angle > 0:
            wanted = ALMOST * length / (2 * np.tan(np.radians(self.demands.angle) / 2))
            nearer = faults.sharp & ~(height <= wanted)  # a flat triangle's is no number
            height = np.where(nearer, wanted, height)
        points = middle + height[:, None] * inward
        astray = ~np.isfinite(points).all(axis=1)
        points[astray] = other[astray]
        return points, np.hypot(*(points - p).T)

    def _hindering(self, net: Net, triangles: Integers, points: Floats) -> tuple[Integers, Integers, Integers]:
        """Numbers (m,) of points (k, 2) that are hindered, the facets (m,) that hinder them, and points past all help.

        A point, seen from its triangle, is hindered by the first facet in its way, or else by those in whose diametral
        circles it lies. Nothing helps behind a facet that is not split any more, or has its bubbles set beforehand.
        """
        x = net.bubbles.x
        a, b = np.moveaxis(x[net.facets], 1, 0)
        tree = shapely.STRtree(shapely.linestrings(np.stack([a, b], axis=1)))
        start = x[net.triangles[triangles]].mean(axis=1)
        number, facet = tree.query(shapely.linestrings(np.stack([start, points], axis=1)), predicate="intersects")
        way, side = points[number] - start[number], b[facet] - a[facet]
        gap = a[facet] - start[number]
        with np.errstate(divide="ignore", invalid="ignore"):
            share = _cross(gap, side) / _cross(way, side)
        share = np.where(np.isfinite(share), share, 0.0)
        order = np.lexsort((share, number))
        first = order[np.diff(number[order], prepend=-1) != 0]
        number, facet = number[first], facet[first]
        seen = others(len(points), number)
        middle, half = (a + b) / 2, np.hypot(*(b - a).T) / 2
        circles = shapely.STRtree(shapely.box(*(middle - half[:, None]).T, *(middle + half[:, None]).T))
        at, near = circles.query(shapely.points(points[seen]))
        at = seen[at]
        within = np.hypot(*(points[at] - middle[near]).T) < (1 - ROUNDING) * half[near]
        within &= net.two_sided[near] | (_cross(b[near] - a[near], points[at] - a[near]) > 0)
        kept = self._corners.unsplit(net) | np.isin(net.facet_piece, self.domain.held.pieces)
        blind, near, at = number[kept[facet]], near[within], at[within]
        number, facet = np.append(number, at), np.append(facet, near)
        return number[~kept[facet]], facet[~kept[facet]], blind

    def _grown(self, net: Net, additions: Additions) -> Net | None:
        """The net with these nodes, or with the first of them only if edges would cross; None if there is none."""
        for some in (additions, Additions(additions.facets[:1], additions.points[: len(additions.facets) == 0])):
            if len(some.facets) + len(some.points) == 0:
                return None
            try:
                return self._connected(net, some)
            except GeometryError:
                continue
        return None

    def _connected(self, net: Net, additions: Additions) -> Net:
        """The net with these nodes; free ones that are too near to a facet that is split are left out."""
        facets, twins = self._with_twins(net, additions.facets)
        piece, s = self._places(net, facets)
        _, other, at = counterparts(self.domain.boundary, self.domain.periodic, piece, s)
        piece, s = np.append(piece, other), np.append(s, at)
        gone = self._beside(net, np.append(facets, twins))
        bubbles = net.bubbles.select(others(len(net.bubbles), gone))
        x = np.vstack([self.domain.boundary.points(piece, s), additions.points])
        bubbles = bubbles.append(x, np.ones(len(x)), piece, s)
        try:
            grown = connect(bubbles, self.domain)
        except GeometryError:  # a curve's new edge runs through another curve's: that is split as well
            grown = connect(split_cutting_edges(bubbles, self.domain, self.spacing), self.domain)
        outside = np.flatnonzero(grown.valence == 0)
        if len(outside) == 0:
            return grown
        return connect(grown.bubbles.select(others(len(grown.bubbles), outside)), self.domain)

    def _with_twins(self, net: Net, facets: Integers) -> tuple[Integers, Integers]:
        """The facets (j,), one of two that match on periodic sides, and those (i,) that match some of them."""
        pairs = matching_edges(self.domain.periodic, net.facet_piece)
        twin = np.full(len(net.facets), -1)
        twin[pairs[:, 0]], twin[pairs[:, 1]] = pairs[:, 1], pairs[:, 0]
        once = np.unique(np.where(twin[facets] >= 0, np.minimum(facets, twin[facets]), facets))
        return once, twin[once][twin[once] >= 0]

    def _places(self, net: Net, facets: Integers) -> tuple[Integers, Floats]:
        """Pieces (k,) and arc lengths (k,) at which facets are split.

        It is their middle, or beside a sharp corner a power of two from it, so that the edges there are equally long.
        """
        boundary, bubbles = self.domain.boundary, net.bubbles
        edges, piece = net.facets, net.facet_piece
        begin, end = (arc[facets] for arc in boundary.arcs(edges, piece, bubbles.s))
        piece = piece[facets]
        at_start, at_end = (self._corners.sharp_ends[k, piece] for k in (0, 1))
        at_start = at_start & (begin == 0)
        at_end = at_end & (end == boundary.lengths[piece]) & (edges[facets, 1] < bubbles.corners)
        shell = 2.0 ** np.rint(np.log2((end - begin) / 2))
        s = (begin + end) / 2
        s = np.where(at_start & ~at_end, begin + shell, np.where(at_end & ~at_start, end - shell, s))
        return piece, boundary.wrapped(piece, s)

    def _beside(self, net: Net, facets: Integers) -> Integers:
        """Interior bubbles (k,) in the diametral circles of the facets, on their inner side."""
        bubbles = net.bubbles
        a, b = np.moveaxis(bubbles.x[net.facets[facets]], 1, 0)
        middle, half = (a + b) / 2, np.hypot(*(b - a).T) / 2
        free = np.arange(bubbles.boundary_count, len(bubbles))
        tree = shapely.STRtree(shapely.points(bubbles.x[free]))
        facet, node = tree.query(shapely.box(*(middle - half[:, None]).T, *(middle + half[:, None]).T))
        x = bubbles.x[free[node]]
        within = np.hypot(*(x - middle[facet]).T) < (1 - ROUNDING) * half[facet]
        within &= net.two_sided[facets[facet]] | (_cross((b - a)[facet], x - a[facet]) > 0)
        return np.unique(free[node[within]])

    def _smoothed(self, net: Net) -> Net:
        """The net with bubbles around new ones moved to better shapes, as far as no demand is broken anew."""
        free = net.within(np.flatnonzero(net.bubbles.touched), AROUND)
        free[: net.bubbles.boundary_count] = False
        smoothing, allowed = Smoothing(), len(self._broken(net))
        for _ in range(ATTEMPTS if free.any() else 0):
            trial = net
            for _ in range(SMOOTHINGS):
                moved = smoothing.moved(_locally_spaced(trial), self.domain, free)
                trial = reconnect(trial, replace(trial.bubbles, x=moved.x))
            faults = self._broken(trial)
            if len(faults) <= allowed and (trial.valence > 0).all():
                return trial
            held = np.union1d(trial.triangles[faults].ravel(), np.flatnonzero(trial.valence == 0))
            free &= ~trial.within(held, 1) & ~net.within(held, 1)
        return net

    def _broken(self, net: Net) -> Integers:
        """Triangles (k,) that break any demand."""
        return np.union1d(self._faults(net).triangles, self._overconstrained(net))

    def _result(self, net: Net, added: int, stopped: str | None, out_of_nodes: bool) -> Refined:
        least, excusing = self._least_angles(net)
        corners = np.unique(excusing[excusing >= 0])
        excused = tuple(
            Excused((float(x), float(y)), float(least[excusing == corner].min()))
            for corner, (x, y) in zip(corners, net.bubbles.x[corners], strict=True)
        )
        angle, excess = float(least[excusing < 0].min(initial=60.0)), float(self._excess(net).max())
        if len(self._broken(net)) == 0:  # smoothing has mended the last ones
            stopped, out_of_nodes = None, False
        return Refined(net, added, angle, excess, len(self._overconstrained(net)), excused, stopped, out_of_nodes)


def _cross(a: Floats, b: Floats) -> Floats:
    """Cross products (m,) of vectors (m, 2)."""
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def _apart(points: Floats, room: Floats) -> Integers:
    """Numbers (k,) of points (m, 2) none of which is within the ``room`` (m,) of another one; the first are preferred.

    A point that only one that is not taken stands in the way of may be left out as well.
    """
    if len(points) == 0:
        return np.zeros(0, np.int64)
    tree = shapely.STRtree(shapely.points(points))
    one, other = tree.query(shapely.points(points), predicate="dwithin", distance=room)
    taken = np.ones(len(points), bool)
    taken[np.maximum(one, other)[one != other]] = False
    return np.flatnonzero(taken)


def _locally_spaced(net: Net) -> Net:
    """The net with the mean length of the edges at each bubble for its spacing."""
    bubbles, ends = net.bubbles, net.edges
    length = np.hypot(*(bubbles.x[ends[:, 1]] - bubbles.x[ends[:, 0]]).T)
    total = np.bincount(ends.ravel(), np.repeat(length, 2), minlength=len(bubbles))
    mean = np.where(net.valence > 0, total / np.maximum(net.valence, 1), bubbles.d)  # some may have left the domain
    return replace(net, bubbles=replace(bubbles, d=mean))
