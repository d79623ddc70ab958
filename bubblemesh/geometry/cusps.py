"""Curves that part from a corner with a common tangent, and must leave room for triangles between them."""

from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.curves import turning
from bubblemesh.wording import place

__all__ = ["require_room"]

TANGENT = 1e-5  # radians between two directions that are the same
LEAST_BEND = 0.06  # relative difference of the curvatures: the edges of one curve reach across the other below it
STRAIGHT = 1e-9  # radians over the length of the shorter piece


class Departures(NamedTuple):
    """How pieces leave their corners: corner (m,), direction (m,) in radians, curvature (m,) and length (m,)."""

    corner: Integers
    direction: Floats
    curvature: Floats
    length: Floats


def require_room(boundary: Boundary) -> None:
    """Check that curves with a common tangent part fast enough for edges to follow both of them.

    Raises
    ------
    GeometryError
        If their curvatures are nearly the same; with the corner and the radii.
    """
    corner, direction, curvature, length = _departures(boundary)
    for shift in range(1, 4):  # more than four curves with one tangent have a worse fault among the first four
        i, j = np.arange(len(corner) - shift), np.arange(shift, len(corner))
        k, m = curvature[i], curvature[j]
        sharper = np.maximum(np.abs(k), np.abs(m))
        tight = (corner[i] == corner[j]) & (direction[j] - direction[i] <= TANGENT)
        tight &= (np.abs(k - m) <= LEAST_BEND * sharper) & (sharper * np.minimum(length[i], length[j]) > STRAIGHT)
        if tight.any():
            first = np.flatnonzero(tight)[0]
            radii = 1 / np.abs([k[first], m[first]])
            raise GeometryError(
                f"two curves part at {place(boundary.corners[corner[i[first]]])} with a common tangent and with radii "
                f"of {radii[0]:.4g} and {radii[1]:.4g}, too near to each other for edges between them: let them "
                "share the curve, or not touch"
            )


def _departures(boundary: Boundary) -> Departures:
    """Both ends of all curves and lines, by corner and direction; directions near -pi come again near pi."""
    piece, _, step = boundary.panels()
    first, last = np.flatnonzero(np.diff(piece, prepend=-1)), np.flatnonzero(np.diff(piece, append=-1))
    open_ = np.flatnonzero(~boundary.closed)
    ahead, back = step[first[open_]], step[last[open_]]
    zero, length = np.zeros(len(open_)), boundary.lengths[open_]
    t, u = boundary.tangents(open_, zero), boundary.tangents(open_, ahead)
    v, w = -boundary.tangents(open_, length), -boundary.tangents(open_, length - back)
    corner = np.concatenate([boundary.start[open_], boundary.end[open_]])
    direction = np.arctan2(*np.vstack([t, v]).T[::-1])
    curvature = np.concatenate([turning(t, u) / ahead, turning(v, w) / back])
    again = np.flatnonzero(direction < TANGENT - np.pi)
    columns = [np.concatenate([column, column[again]]) for column in (corner, direction, curvature, np.tile(length, 2))]
    columns[1][len(direction) :] += 2 * np.pi
    order = np.lexsort((columns[1], columns[0]))
    return Departures(*(column[order] for column in columns))
