"""How pieces leave the corners at their ends, in order around each corner."""

from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.boundary import Boundary

__all__ = ["Departures", "departures"]

GLANCE = 1e-3  # of a chord's length: so far ahead curves with a common tangent are told apart


class Departures(NamedTuple):
    """Ends of pieces, counter-clockwise around their corners.

    Attributes
    ----------
    corner : (m,)
    piece : (m,)
    forward : (m,)
        Whether the piece starts here, rather than ends.
    direction : (m,)
        In which it leaves the corner, in radians.
    curvature : (m,)
        Of the leaving curve, positive where it turns left.
    following : (m,)
        Number of the next one at the same corner; its own where there is no other.
    """

    corner: Integers
    piece: Integers
    forward: Booleans
    direction: Floats
    curvature: Floats
    following: Integers

    def angle_to(self, other: Integers) -> Floats:
        """Angles (m,) in radians, counter-clockwise from each direction to that of the one numbered ``other`` (m,).

        A difference by rounding is none, rather than a full turn.
        """
        return np.mod(self.direction[other] - self.direction + ROUNDING, 2 * np.pi) - ROUNDING


ROUNDING = 1e-6  # radians


def departures(boundary: Boundary) -> Departures:
    """Both ends of all pieces that are not closed."""
    of_chord, _, step = boundary.panels()
    first, last = np.flatnonzero(np.diff(of_chord, prepend=-1)), np.flatnonzero(np.diff(of_chord, append=-1))
    piece = np.flatnonzero(~boundary.closed)
    ahead, back = step[first[piece]], step[last[piece]]
    length, start = boundary.lengths[piece], np.zeros(len(piece))
    leaving = np.vstack([boundary.tangents(piece, start), -boundary.tangents(piece, length)])
    later = np.vstack([boundary.tangents(piece, ahead), -boundary.tangents(piece, length - back)])
    direction = np.arctan2(leaving[:, 1], leaving[:, 0])
    (ax, ay), (bx, by) = leaving.T, later.T
    turn = np.arctan2(ax * by - ay * bx, ax * bx + ay * by)
    corner = np.concatenate([boundary.start[piece], boundary.end[piece]])
    forward = np.repeat([True, False], len(piece))
    order = np.lexsort((direction + GLANCE * turn, corner))
    corner = corner[order]
    begins = np.diff(corner, prepend=-1) != 0
    group = np.flatnonzero(begins)[np.cumsum(begins) - 1]
    following = np.arange(1, len(corner) + 1)
    ends = np.append(begins[1:], True)[: len(corner)]
    following[ends] = group[ends]
    return Departures(
        corner,
        np.tile(piece, 2)[order],
        forward[order],
        direction[order],
        (turn / np.concatenate([ahead, back]))[order],
        following,
    )
