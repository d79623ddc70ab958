"""Sharp corners of a domain: triangles that cannot have larger angles than these, or than what follows from them."""

from functools import cached_property

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers, cross
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.corners import CornerFans
from bubblemesh.meshes.edges import edge_keys
from bubblemesh.meshes.quality import angles
from bubblemesh.packing.net import Net
from bubblemesh.records import record

SAME = 1e-6  # relative difference of two distances that are the same
CUSP = 0.02  # radians between curves that part so slowly that no edge there is ever short enough
SHORT_OF_CUSP = np.radians(10)  # between the first edges on both sides, below which these are split no more
BESIDE_CUSP = 2.0  # lengths of these edges: so far from it triangles are due to a cusp
SHARP = np.pi / 3  # edges that leave a corner at a smaller angle are split at the same distances from it


@record
class SharpCorners:
    """The corners of a boundary, with the angles between the pieces that leave them."""

    boundary: Boundary
    fans: CornerFans  # of it

    @cached_property
    def sectors(self) -> Floats:
        """Angles (m,) in radians from each end of a piece to the next one; a full turn outside the domain."""
        fans = self.fans
        return np.where(fans.within(self.boundary), np.maximum(fans.angle_to(fans.following), 0), 2 * np.pi)

    @cached_property
    def sharp_ends(self) -> Booleans:
        """Mask (2, p) of the pieces that begin, and end, in a sharp sector."""
        beside = self.sectors < SHARP
        beside[self.fans.following[beside]] = True
        result = np.zeros((2, len(self.boundary.kind)), bool)
        result[np.where(self.fans.forward[beside], 0, 1), self.fans.piece[beside]] = True
        return result

    @cached_property
    def rows(self) -> Integers:
        """Row (2, p) among the ends of pieces of each piece's start and end, or -1."""
        result = np.full((2, len(self.boundary.kind)), -1)
        result[np.where(self.fans.forward, 0, 1), self.fans.piece] = np.arange(len(self.fans.piece))
        return result

    def excusing(self, net: Net, triangles: Integers, angle: float) -> Integers:
        """Corner (k,) that excuses the smallest angle of each of the triangles (k, 3) of a net, or -1.

        It is one that encloses less than the ``angle``, in degrees, and either the triangle's own corner, or two of the
        triangle's nodes are at the same distance from it on the two sides that do. Beside a cusp all triangles are
        excused that are about as near as the first nodes on its sides.
        """
        bubbles, numbers = net.bubbles, np.arange(len(triangles))
        first = angles(bubbles.x, triangles).argmin(axis=1)
        tip, a, b = (triangles[numbers, (first + k) % 3] for k in range(3))
        result = np.full(len(triangles), -1)
        own = np.flatnonzero(tip < bubbles.corners)
        narrow = self._enclosing(net, tip[own], bubbles.x[triangles[own]].mean(axis=1)) < np.radians(angle)
        result[own[narrow]] = tip[own[narrow]]
        left = np.flatnonzero((result < 0) & (np.maximum(a, b) < bubbles.boundary_count))
        result[left] = self._between_legs(net, a[left], b[left], np.radians(angle))
        return np.where(result < 0, self._beside_cusps(net, triangles), result)

    def _next_nodes(self, net: Net) -> Integers:
        """First node (m,) along each end of a piece from its corner."""
        next_node = np.full((2, len(self.boundary.kind)), -1)
        for end in (0, 1):
            leaving = net.facets[:, end] < net.bubbles.corners
            next_node[end, net.facet_piece[leaving]] = net.facets[leaving, 1 - end]
        return next_node[np.where(self.fans.forward, 0, 1), self.fans.piece]

    def _cusps(self, net: Net) -> tuple[Integers, Integers]:
        """First nodes (c, 2) on both sides of each cusp whose edges there are split no more, and its corner (c,)."""
        x, rows = net.bubbles.x, np.flatnonzero(self.sectors < CUSP)
        corner = self.fans.corner[rows]
        nodes = self._next_nodes(net)[np.column_stack([rows, self.fans.following[rows]])]
        a, b = (x[nodes[:, k]] - x[corner] for k in (0, 1))
        narrow = np.abs(np.arctan2(cross(a, b), (a * b).sum(axis=1))) < SHORT_OF_CUSP
        return nodes[narrow], corner[narrow]

    def unsplit(self, net: Net) -> Booleans:
        """Mask (f,) of the facets at cusps that are split no more: alone, either would run through the other one."""
        nodes, corner = self._cusps(net)
        pairs = np.concatenate([np.column_stack([corner, nodes[:, k]]) for k in (0, 1)])
        known, n = np.sort(pairs, axis=1), len(net.bubbles)
        return np.isin(edge_keys(np.sort(net.facets, axis=1), n), edge_keys(known, n))

    def _beside_cusps(self, net: Net, triangles: Integers) -> Integers:
        """Corner (k,) that is a cusp and near to triangles (k, 3), or -1."""
        x, (nodes, corner) = net.bubbles.x, self._cusps(net)
        result, middles = np.full(len(triangles), -1), x[triangles].mean(axis=1)
        reach = BESIDE_CUSP * np.hypot(*np.moveaxis(x[nodes] - x[corner][:, None], 2, 0)).max(axis=1, initial=0.0)
        tree = shapely.STRtree(shapely.points(middles))
        cusp, near = tree.query(shapely.points(x[corner]), predicate="dwithin", distance=reach)
        result[near] = corner[cusp]
        return result

    def _enclosing(self, net: Net, corner: Integers, towards: Floats) -> Floats:
        """Angles (k,) of the sectors at corners in which points (k, 2) lie; a full turn where no piece ends.

        The points are in triangles there, whose sides are straight: what counts is between which of these they are.
        """
        fans, bubbles = self.fans, net.bubbles
        order, key = _by_direction(fans.corner, bubbles.x[self._next_nodes(net)] - bubbles.x[fans.corner])
        first, after = (np.searchsorted(fans.corner, corner, side) for side in ("left", "right"))
        row = np.searchsorted(key, _keys(corner, towards - bubbles.x[corner]), "right") - 1
        row = np.where(row < first, after - 1, row)
        some = first < after
        result = np.full(len(corner), 2 * np.pi)
        result[some] = self.sectors[order[row[some]]]
        return result

    def _between_legs(self, net: Net, a: Integers, b: Integers, angle: float) -> Integers:
        """Corner (k,) from which nodes on the boundary are equally far, on sides that enclose less than the angle."""
        result = np.full(len(a), -1)
        (ends, far), (others, apart) = self._distances(net, a), self._distances(net, b)
        following, sectors = self.fans.following, self.sectors
        for i in range(2):
            for j in range(2):
                one, other = ends[:, i], others[:, j]
                both = np.flatnonzero((one >= 0) & (other >= 0) & (np.abs(far[:, i] - apart[:, j]) <= SAME * far[:, i]))
                one, other = one[both], other[both]
                sharp = (following[one] == other) & (sectors[one] < angle)
                sharp |= (following[other] == one) & (sectors[other] < angle)
                result[both[sharp]] = self.fans.corner[one[sharp]]
        return result

    def _distances(self, net: Net, nodes: Integers) -> tuple[Integers, Floats]:
        """Rows (k, 2) of the ends of the pieces that nodes (k,) slide on, or -1, and how far (k, 2) these are along."""
        bubbles = net.bubbles
        if len(bubbles.piece) == 0:
            return np.full((len(nodes), 2), -1), np.zeros((len(nodes), 2))
        slides = nodes >= bubbles.corners
        number = np.where(slides, nodes - bubbles.corners, 0)
        piece, s = bubbles.piece[number], bubbles.s[number]
        rows = np.where(slides[:, None], self.rows[:, piece].T, -1)
        return rows, np.column_stack([s, self.boundary.lengths[piece] - s])


def _by_direction(corner: Integers, directions: Floats) -> tuple[Integers, Floats]:
    """Order (m,) of directions (m, 2) around their corners, and ascending keys (m,) of those in this order."""
    key = _keys(corner, directions)
    order = np.argsort(key)
    return order, key[order]


def _keys(corner: Integers, directions: Floats) -> Floats:
    """Keys (m,) that ascend with the corner, and then counter-clockwise with the direction (m, 2)."""
    return np.asarray(8.0 * corner + np.arctan2(directions[:, 1], directions[:, 0]) + np.pi)
