"""Sites: where a refinement adds nodes, inside triangles or in the boundary edges that these are too near to.

References
----------
A. Ungor, "Off-centers", Comput. Geom. 42 (2009).
"""

from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import ROUNDING, Booleans, Floats, Integers, complement, cross, turned_left
from bubblemesh.geometry.domain import Domain
from bubblemesh.meshes.edges import edge_keys, find_keys
from bubblemesh.meshes.triangulation import circumcircles
from bubblemesh.packing.net import Net
from bubblemesh.packing.sharp_corners import SharpCorners
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing

SHORTEST = 1e-10  # of the domain's size: edges that are not split any more
SHORTEST_IN_SPACINGS = 1e-4  # the same, in spacings: so short is no edge but where corners ask each other for nodes
ALMOST = 0.99  # of the way to where the angle would be exactly as wanted


class Faults(NamedTuple):
    """Triangles that are not as they have to be."""

    triangles: Integers  # (k,), the worst first
    sharp: Booleans  # (k,), whether an angle is too small, rather than the area too large


class Additions(NamedTuple):
    """Nodes to add: one in each of some facets (j,), and free ones at points (k, 2)."""

    facets: Integers
    points: Floats

    @property
    def first(self) -> "Additions":
        """One of them: in a facet if there is any."""
        return Additions(self.facets[:1], self.points[:0] if len(self.facets) else self.points[:1])


@record
class Sites:
    """Sites of new nodes in nets of a domain."""

    domain: Domain
    spacing: Spacing
    angle: float  # degrees: the least one that is asked for
    corners: SharpCorners

    def freeing(self, net: Net, triangles: Integers) -> Additions:
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

    def mending(self, net: Net, faults: Faults) -> Additions:
        """Nodes that mend the triangles: near their circumcentres, or in facets that these are too near to.

        Of nodes that are near to each other only the one for the worst triangle is taken.
        """
        a, b = np.moveaxis(net.bubbles.x[net.facets], 1, 0)
        points, room = self._centres(net, faults)
        number, facet, blind = self._hindering(net, faults.triangles, points)
        free = complement(len(points), np.append(number, blind))
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
        inward = turned_left(along) / np.maximum(np.hypot(*along.T), 1e-300)[:, None]
        length = np.hypot(*along.T)
        height = np.einsum("ij,ij->i", centre - middle, inward)
        if self.angle > 0:
            highest = ALMOST * length / (2 * np.tan(np.radians(self.angle) / 2))
            nearer = faults.sharp & ~(height <= highest)  # a flat triangle's is no number
            height = np.where(nearer, highest, height)
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
            share = cross(gap, side) / cross(way, side)
        share = np.where(np.isfinite(share), share, 0.0)
        order = np.lexsort((share, number))
        first = order[np.diff(number[order], prepend=-1) != 0]
        number, facet = number[first], facet[first]
        seen = complement(len(points), number)
        middle, half = (a + b) / 2, np.hypot(*(b - a).T) / 2
        circles = shapely.STRtree(shapely.box(*(middle - half[:, None]).T, *(middle + half[:, None]).T))
        at, near = circles.query(shapely.points(points[seen]))
        at = seen[at]
        within = np.hypot(*(points[at] - middle[near]).T) < (1 - ROUNDING) * half[near]
        within &= net.two_sided[near] | (cross(b[near] - a[near], points[at] - a[near]) > 0)
        kept = self.corners.unsplit(net) | np.isin(net.facet_piece, self.domain.held.pieces)
        blind, near, at = number[kept[facet]], near[within], at[within]
        number, facet = np.append(number, at), np.append(facet, near)
        return number[~kept[facet]], facet[~kept[facet]], blind


def _apart(points: Floats, room: Floats) -> Integers:
    """Numbers (k,) of points (m, 2) none of which is within the ``room`` (m,) of another one; the first are preferred.

    A point may also be left out for another one near it that is left out itself.
    """
    if len(points) == 0:
        return np.zeros(0, np.int64)
    tree = shapely.STRtree(shapely.points(points))
    one, other = tree.query(shapely.points(points), predicate="dwithin", distance=room)
    alone = np.ones(len(points), bool)
    alone[np.maximum(one, other)[one != other]] = False
    return np.flatnonzero(alone)
