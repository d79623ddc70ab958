"""Corners: the directions of the pieces around them, in order, and whether there is room for triangles between."""

from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.curves import turning
from bubblemesh.messages import place

PINCH_OUT = 5.0  # degrees: in sharper corners nodes on both sides have to be opposite to each other
GLANCE = 1e-3  # of a chord's length: distance from a corner at which curves with a common tangent are compared


class CornerFans(NamedTuple):
    """Ends of pieces, counter-clockwise around their corners."""

    corner: Integers  # (m,)
    piece: Integers  # (m,)
    forward: Booleans  # (m,), whether the piece starts here, rather than ends
    direction: Floats  # (m,), in which it leaves the corner, in radians
    curvature: Floats  # (m,), of the leaving curve, positive where it turns left
    following: Integers  # (m,), number of the next one at the same corner; its own if it is the only one

    def angle_to(self, other: Integers) -> Floats:
        """Angles (m,) in radians, counter-clockwise from each direction to that of the one numbered ``other`` (m,).

        A difference that is due to rounding counts as 0, not as a full turn.
        """
        return np.mod(self.direction[other] - self.direction + ANGLE_ROUNDING, 2 * np.pi) - ANGLE_ROUNDING

    def within(self, boundary: Boundary) -> Booleans:
        """Mask (m,) of the ends with the domain between them and the next one.

        The domain is on the left of all pieces, and on both sides of inner pieces.
        """
        return (self.forward | boundary.inner[self.piece]) & (self.following != np.arange(len(self.piece)))


ANGLE_ROUNDING = 1e-6  # radians


def corner_fans(boundary: Boundary) -> CornerFans:
    """Fans of both ends of all pieces that are not closed."""
    piece = np.flatnonzero(~boundary.closed)
    ahead, back = (step[piece] for step in boundary.end_steps())
    length = boundary.lengths[piece]
    start = np.zeros(len(piece))
    tangents = boundary.tracks(piece).tangents
    leaving = np.vstack([tangents(start), -tangents(length)])
    later = np.vstack([tangents(ahead), -tangents(length - back)])
    direction = np.arctan2(leaving[:, 1], leaving[:, 0])
    (ax, ay), (bx, by) = leaving.T, later.T
    turn = np.arctan2(ax * by - ay * bx, ax * bx + ay * by)
    corner, step = np.concatenate([boundary.start[piece], boundary.end[piece]]), np.concatenate([ahead, back])
    forward, curvature = np.repeat([True, False], len(piece)), turn / step
    common = np.full(len(boundary.corners), np.inf)  # the same glance for all curves at a corner
    np.minimum.at(common, corner, step)
    order = np.lexsort((direction + GLANCE * curvature * common[corner], corner))
    corner = corner[order]
    begins = np.diff(corner, prepend=-1) != 0
    group = np.flatnonzero(begins)[np.cumsum(begins) - 1]
    following = np.arange(1, len(corner) + 1)
    ends = np.append(begins[1:], True)[: len(corner)]
    following[ends] = group[ends]
    return CornerFans(
        corner,
        np.tile(piece, 2)[order],
        forward[order],
        direction[order],
        curvature[order],
        following,
    )


def turns(boundary: Boundary, walls: Booleans) -> Floats:
    """Angles (k,) in radians by which directions to the nearest of some pieces (p,) turn around each corner.

    Only directions from places in the domain count: around the end of an embedded line they turn by half a turn, around
    a corner of 90 degrees of a hole by a quarter, and around one of a convex domain not at all.
    """
    looked_at = walls | ~boundary.inner
    chosen, wall = boundary.select(np.flatnonzero(looked_at)), walls[looked_at]
    ends = corner_fans(chosen)
    alone = ends.following == np.arange(len(ends.piece))
    between = np.where(alone, 2 * np.pi, ends.angle_to(ends.following))
    # For a quarter of a turn beside a wall the nearest place is on it.
    walled = wall[ends.piece].astype(int) + wall[ends.piece[ends.following]]
    inside = (ends.within(chosen) | (alone & chosen.inner[ends.piece])) & (walled > 0)
    found = np.zeros(len(boundary.corners))
    np.maximum.at(found, ends.corner[inside], (between - np.pi / 2 * walled)[inside])
    return found


def bends_of(boundary: Boundary, walls: Booleans, most: float) -> tuple[Floats, Floats]:
    """Centres (k, 2) and radii (k,) of the circles along which some pieces (p,) of rings bend into the domain.

    The circles are those through three points in a row of the polygonal copy, which turns there by at most so many
    radians: of an arc its own, and the same of a polygon with its corners on the arc.
    """
    chords = boundary.chords()
    ring = boundary.ring[chords.piece]
    of_rings = np.flatnonzero(ring >= 0)
    before = of_rings - 1
    first, last = (np.flatnonzero(np.diff(ring[of_rings], **beyond)) for beyond in ({"prepend": -1}, {"append": -1}))
    before[first] = of_rings[last]
    back, ahead = chords.start[before] - chords.start[of_rings], chords.end[of_rings] - chords.start[of_rings]
    turn = turning(-back, ahead)
    wall = walls[chords.piece]
    bends = wall[of_rings] & wall[before] & (turn < -STRAIGHT) & (turn >= -most)
    (bx, by), (cx, cy) = back[bends].T, ahead[bends].T
    half, bb, cc = 0.5 / (bx * cy - by * cx), bx * bx + by * by, cx * cx + cy * cy
    centre = np.column_stack([(cy * bb - by * cc) * half, (bx * cc - cx * bb) * half])
    return np.asarray(chords.start[of_rings][bends] + centre), np.hypot(*centre.T)


TANGENT = 1e-5  # radians between two directions that are the same
LEAST_BEND = 0.06  # relative difference of the curvatures below which edges of one curve would cross the other
STRAIGHT = 1e-9  # radians over the length of the shorter piece


def require_separation(boundary: Boundary, ends: CornerFans) -> None:
    """Check that curves with a common tangent, at the ``ends`` of pieces, separate fast enough for edges along both.

    GeometryError, with the corner and the radii, if their curvatures are nearly the same.
    """
    one = np.arange(len(ends.corner))
    other = ends.following
    k, m = ends.curvature, ends.curvature[other]
    sharper = np.maximum(np.abs(k), np.abs(m))
    length = np.minimum(boundary.lengths[ends.piece], boundary.lengths[ends.piece[other]])
    tight = (one != other) & (np.abs(ends.angle_to(other)) <= TANGENT)
    tight &= (np.abs(k - m) <= LEAST_BEND * sharper) & (sharper * length > STRAIGHT)
    if tight.any():
        first = np.flatnonzero(tight)[0]
        radii = 1 / np.abs([k[first], m[first]])
        raise GeometryError(
            f"two curves part at {place(boundary.corners[ends.corner[first]])} with a common tangent and with radii "
            f"of {radii[0]:.4g} and {radii[1]:.4g}, too near to each other for edges between them: let them "
            "share the curve, or not touch"
        )
