"""Sharp corners of a domain: triangles that cannot have larger angles than these, or than what follows from them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.corners import CornerFans, corner_fans
from bubblemesh.meshes.quality import angles
from bubblemesh.packing.net import Net

SAME = 1e-6  # relative difference of two distances that are the same
SHARP = np.pi / 3  # edges that leave a corner at a smaller angle are split at the same distances from it


@dataclass(frozen=True)
class SharpCorners:
    """The corners of a boundary, with the angles between the pieces that leave them."""

    boundary: Boundary

    @cached_property
    def fans(self) -> CornerFans:
        """Ends of pieces around the corners."""
        return corner_fans(self.boundary)

    @cached_property
    def sectors(self) -> Floats:
        """Angles (m,) in radians from each end of a piece to the next one; a full turn outside the domain."""
        fans, turn = self.fans, 2 * np.pi
        angle = np.maximum(fans.angle_to(fans.following), 0)
        within = (fans.forward | self.boundary.inner[fans.piece]) & (fans.following != np.arange(len(angle)))
        return np.where(within, angle, turn)

    @cached_property
    def sharp_ends(self) -> Booleans:
        """Mask (2, p) of the pieces that begin, and end, in a sharp sector."""
        beside = self.sectors < SHARP
        beside[self.fans.following[beside]] = True
        result = np.zeros((2, len(self.boundary.kind)), bool)
        result[np.where(self.fans.forward[beside], 0, 1), self.fans.piece[beside]] = True
        return result

    def excusing(self, net: Net, triangles: Integers, angle: float) -> Integers:
        """Corner (k,) that excuses the smallest angle of each of the triangles (k, 3) of a net, or -1.

        It is one that encloses less than the ``angle``, in degrees, and either the triangle's own corner, or two of the
        triangle's nodes are at the same distance from it on the two sides that do.
        """
        bubbles, rows = net.bubbles, np.arange(len(triangles))
        first = angles(bubbles.x, triangles).argmin(axis=1)
        tip, a, b = (triangles[rows, (first + k) % 3] for k in range(3))
        result = np.full(len(triangles), -1)
        own = np.flatnonzero(tip < bubbles.corners)
        towards = bubbles.x[triangles[own]].mean(axis=1) - bubbles.x[tip[own]]
        narrow = self._enclosing(tip[own], np.arctan2(towards[:, 1], towards[:, 0])) < np.radians(angle)
        result[own[narrow]] = tip[own[narrow]]
        left = np.flatnonzero((result < 0) & (np.maximum(a, b) < bubbles.boundary_count))
        result[left] = self._between_legs(net, a[left], b[left], angle)
        return result

    def _enclosing(self, corner: Integers, direction: Floats) -> Floats:
        """Angles (k,) of the sectors at corners that directions (k,) lie in; a full turn where no piece ends."""
        fans = self.fans
        if len(fans.corner) == 0:
            return np.full(len(corner), 2 * np.pi)
        key = 8.0 * fans.corner + fans.direction + np.pi
        first, after = (np.searchsorted(fans.corner, corner, side) for side in ("left", "right"))
        row = np.searchsorted(key, 8.0 * corner + direction + np.pi, "right") - 1
        row = np.where(row < first, after - 1, row)
        return np.where(first < after, self.sectors[np.clip(row, 0, len(key) - 1)], 2 * np.pi)

    def _between_legs(self, net: Net, a: Integers, b: Integers, angle: float) -> Integers:
        """Corner (k,) from which nodes on the boundary are equally far, on sides that enclose less than the angle."""
        result = np.full(len(a), -1)
        (corners, far), (others, apart) = self._distances(net, a), self._distances(net, b)
        for i in range(2):
            for j in range(2):
                corner = corners[:, i]
                same = (corner >= 0) & (corner == others[:, j])
                same &= np.abs(far[:, i] - apart[:, j]) <= SAME * far[:, i]
                middle = (net.bubbles.x[a] + net.bubbles.x[b]) / 2 - net.bubbles.x[corner]
                same &= self._enclosing(corner, np.arctan2(middle[:, 1], middle[:, 0])) < np.radians(angle)
                result[same] = corner[same]
        return result

    def _distances(self, net: Net, nodes: Integers) -> tuple[Integers, Floats]:
        """Corners (k, 2) at the ends of the pieces that nodes (k,) lie on, or -1, and how far (k, 2) they are along."""
        bubbles, boundary = net.bubbles, self.boundary
        slides = nodes >= bubbles.corners
        if len(bubbles.piece) == 0:
            return np.full((len(nodes), 2), -1), np.zeros((len(nodes), 2))
        number = np.where(slides, nodes - bubbles.corners, 0)
        piece, s = bubbles.piece[number], bubbles.s[number]
        ends = np.column_stack([boundary.start[piece], boundary.end[piece]])
        return np.where(slides[:, None], ends, -1), np.column_stack([s, boundary.lengths[piece] - s])
