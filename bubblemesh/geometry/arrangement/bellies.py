"""Places between chords and their curves: on another side of the curve than of its polygonal copy."""

from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Floats, Integers, cross
from bubblemesh.geometry.boundary import Boundary

NEWTON_STEPS = 12
SAGITTA = 0.02  # of a chord's length: bound for the distance of its curve


class Bellies(NamedTuple):
    """Points between a chord and its curve, and what the curve adds to their winding numbers."""

    point: Integers  # (m,)
    piece: Integers  # (m,)
    turn: Integers  # (m,): +1 on the left of the curve, but on the right of its chord; -1 the other way round


def bellies(boundary: Boundary, points: Floats) -> Bellies:
    """The points (n, 2) that lie between a chord of the boundary's polygonal copy and its curve."""
    chords = boundary.chords()
    curved = np.flatnonzero(boundary.approximated[chords.piece])
    piece, s, step, start, end = (column[curved] for column in chords)
    around = SAGITTA * step[:, None]
    low, high = np.minimum(start, end) - around, np.maximum(start, end) + around
    point, k = shapely.STRtree(shapely.box(*low.T, *high.T)).query(shapely.points(points))
    seen, along = points[point] - start[k], end[k] - start[k]
    share = np.einsum("ij,ij->i", seen, along) / np.einsum("ij,ij->i", along, along)
    beside = (share > 0) & (share < 1)
    point, k, seen, along, share = (column[beside] for column in (point, k, seen, along, share))
    at = boundary.foot(points[point], piece[k], s[k] + share * step[k], NEWTON_STEPS, longest=step[k])
    above = points[point] - boundary.points(piece[k], at)
    left_of_curve = cross(boundary.tangents(piece[k], at), above) > 0
    left_of_chord = cross(along, seen) > 0
    between = left_of_curve != left_of_chord
    return Bellies(point[between], piece[k[between]], np.where(left_of_curve[between], 1, -1))
