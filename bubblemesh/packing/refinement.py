"""Refinement: nodes are added until no angle is smaller, no triangle larger, and none less free than asked for.

Where they go is in `packing.sites`.

References
----------
J. Ruppert, "A Delaunay refinement algorithm for quality 2-dimensional mesh generation", J. Algorithms 18 (1995);
L. P. Chew, "Guaranteed-quality mesh generation for curved surfaces", SoCG 1993, for nodes that a split edge removes;
G. L. Miller, S. E. Pav, N. J. Walkington, "When and why Delaunay refinement algorithms work", Int. J. Comput. Geom.
Appl. 15 (2005), for sharp corners.
"""

from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import ROUNDING, Floats, Integers, all_of_rows, complement, cross
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.periodic import counterparts, matching_edges
from bubblemesh.meshes.quality import angles, signed_areas
from bubblemesh.meshes.triangulation import regions
from bubblemesh.messages import place
from bubblemesh.packing.boundary_edges import split_cutting_edges
from bubblemesh.packing.demands import Demands
from bubblemesh.packing.net import Net, connect, connect_inside, reconnect
from bubblemesh.packing.progress import TimeUp, Watch
from bubblemesh.packing.sharp_corners import SharpCorners
from bubblemesh.packing.sites import Additions, Faults, Sites
from bubblemesh.packing.smoothing import Smoothing
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing

ROUNDS = 1000
AROUND_NEW = 3  # rings of nodes around new ones that are smoothed
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
            grown = self._grown(net, self._sites.freeing(net, overconstrained))
            if grown is None and len(faults.triangles):
                grown = self._grown(net, self._sites.mending(net, faults))
            if grown is None:
                left = net.bubbles.x[net.triangles[np.append(faults.triangles, overconstrained)[0]]].mean(axis=0)
                stopped = f"where edges are too short or too near to each other to be split, as at {place(left)}"
                break
            out_of_nodes = len(grown.bubbles) > most
            if out_of_nodes:
                stopped = f"by limits.max_nodes: {most}"
                break
            net = grown
        if len(net.bubbles) == len(start.bubbles) and not net.bubbles.touched.any():
            return self._result(start, 0, stopped, out_of_nodes)
        net = connect_inside(self._smoothed(net).bubbles, self.domain, self.spacing)
        return self._result(net, len(net.bubbles) - len(start.bubbles), stopped, out_of_nodes)

    @cached_property
    def _corners(self) -> SharpCorners:
        return SharpCorners(self.domain.boundary, self.domain.corner_fans)

    @cached_property
    def _sites(self) -> Sites:
        return Sites(self.domain, self.spacing, self.demands.angle, self._corners)

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

    def _grown(self, net: Net, additions: Additions) -> Net | None:
        """The net with these nodes, or with the first of them only if edges would cross; None if there is none."""
        for some in (additions, additions.first):
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
        bubbles = net.bubbles.select(complement(len(net.bubbles), gone))
        x = np.vstack([self.domain.boundary.points(piece, s), additions.points])
        bubbles = bubbles.append(x, np.ones(len(x)), piece, s)
        try:
            grown = connect(bubbles, self.domain)
        except GeometryError:  # a curve's new edge runs through another curve's: that is split as well
            grown = connect(split_cutting_edges(bubbles, self.domain, self.spacing), self.domain)
        outside = np.flatnonzero(grown.valence == 0)
        if len(outside) == 0:
            return grown
        return connect(grown.bubbles.select(complement(len(grown.bubbles), outside)), self.domain)

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
        within &= net.two_sided[facets[facet]] | (cross((b - a)[facet], x - a[facet]) > 0)
        return np.unique(free[node[within]])

    def _smoothed(self, net: Net) -> Net:
        """The net with bubbles around new ones moved to better shapes, as far as no demand is broken anew."""
        free = net.within(np.flatnonzero(net.bubbles.touched), AROUND_NEW)
        free[: net.bubbles.boundary_count] = False
        smoothing, allowed = Smoothing(defect_weight=1.0), len(self._broken(net))
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


def _locally_spaced(net: Net) -> Net:
    """The net with the mean length of the edges at each bubble for its spacing."""
    bubbles, ends = net.bubbles, net.edges
    length = np.hypot(*(bubbles.x[ends[:, 1]] - bubbles.x[ends[:, 0]]).T)
    total = np.bincount(ends.ravel(), np.repeat(length, 2), minlength=len(bubbles))
    mean = np.where(net.valence > 0, total / np.maximum(net.valence, 1), bubbles.d)  # some may have left the domain
    return replace(net, bubbles=replace(bubbles, d=mean))
