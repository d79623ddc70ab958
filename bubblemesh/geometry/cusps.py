"""Curves that part from a corner with a common tangent, and must leave room for triangles between them."""

import numpy as np

from bubblemesh.errors import GeometryError
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.departures import departures
from bubblemesh.wording import place

__all__ = ["require_room"]

TANGENT = 1e-5  # radians between two directions that are the same
LEAST_BEND = 0.06  # relative difference of the curvatures: the edges of one curve reach across the other below it
STRAIGHT = 1e-9  # radians over the length of the shorter piece


def require_room(boundary: Boundary) -> None:
    """Check that curves with a common tangent part fast enough for edges to follow both of them.

    Raises
    ------
    GeometryError
        If their curvatures are nearly the same; with the corner and the radii.
    """
    ends = departures(boundary)
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
