"""Cuts of pieces at corners, and how near is the same."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.boundary import Boundary

TOUCHING = 1e-9  # of the domain's size: nearer is the same
NEARLY = 1e-6  # of the domain's size: nearer, but not the same, is a slip of the user's
CONTACT_LENGTH = 1e5  # curves of radius R touch over a length of sqrt(8 R tolerance), not in a point


class Cuts(NamedTuple):
    """Points (m, 2) at arc length s (m,) of pieces (m,)."""

    piece: Integers
    s: Floats
    points: Floats


def cut(boundary: Boundary, cuts: Cuts, size: float, fixed: int) -> Boundary:
    """The boundary with its pieces cut, at corners that it has already where there are any."""
    count = len(boundary.corners)
    corners, number = _clustered(np.vstack([boundary.corners, cuts.points]), TOUCHING * size, fixed)
    ends = [np.append(number, -1)[end] for end in (boundary.start, boundary.end)]  # -1 stays: no corner
    corner, length = number[count:], boundary.lengths[cuts.piece]
    # At its own end a piece is cut already; the same cut may come from several lines, but a line may cross itself.
    at_end = (cuts.s <= TOUCHING * size) & (corner == ends[0][cuts.piece])
    at_end |= (cuts.s >= length - TOUCHING * size) & (corner == ends[1][cuts.piece])
    order = np.flatnonzero(~at_end | boundary.closed[cuts.piece])
    around, closed = CONTACT_LENGTH * TOUCHING * size, boundary.closed[cuts.piece]
    s = np.where(
        closed & (cuts.s >= length - around), cuts.s - length, cuts.s
    )  # the start of a closed piece is its end
    order = order[np.lexsort((s[order], corner[order], cuts.piece[order]))]
    piece, s, corner = cuts.piece[order], s[order], corner[order]
    again = (np.diff(piece, prepend=-1) == 0) & (np.diff(corner, prepend=-1) == 0)
    again &= np.diff(s, prepend=-np.inf) <= around
    s = np.where(s < 0, s + boundary.lengths[piece], s)
    boundary = replace(boundary, start=ends[0], end=ends[1], corners=corners)
    return boundary.cut(piece[~again], s[~again], corner[~again])


def _clustered(points: Floats, tolerance: float, fixed: int) -> tuple[Floats, Integers]:
    """Points (k, 2) of which no two are the same, and the number (n,) among them of each of the given (n, 2)."""
    spots = shapely.points(points)
    i, j = shapely.STRtree(spots).query(spots, predicate="dwithin", distance=tolerance)
    known = np.arange(len(points))
    loose = (j < i) & (i >= fixed)
    np.minimum.at(known, i[loose], j[loose])
    while (known[known] != known).any():
        known = known[known]
    first = known == np.arange(len(points))
    return points[first], (np.cumsum(first) - 1)[known]


def between_ends(boundary: Boundary, piece: Integers, s: Floats, margin: float) -> Booleans:
    """Whether places (m,) on pieces are not next to the pieces' ends."""
    return boundary.closed[piece] | ((s > margin) & (s < boundary.lengths[piece] - margin))
