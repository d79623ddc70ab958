"""Lines become pieces that meet at corners only: cut where they cross, touch, or where a corner is on one of them."""

from dataclasses import replace

import numpy as np
import shapely

from bubblemesh.arrays import Floats, Integers, concatenated, select
from bubblemesh.errors import GeometryError, Key, about
from bubblemesh.geometry.arrangement import CONTACT_LENGTH, NEARLY, TOUCHING
from bubblemesh.geometry.arrangement.bellies import NEWTON_STEPS
from bubblemesh.geometry.arrangement.crossings import (
    ChordBoxes,
    CutPoints,
    between_ends,
    chord_boxes,
    coincident,
    crossings,
    near_chords,
    openings,
    touches,
)
from bubblemesh.geometry.arrangement.regions import InnerParts
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.paths import as_point
from bubblemesh.messages import two_places

NO_CUTS = CutPoints(np.zeros(0, np.int64), np.zeros(0), np.zeros((0, 2)))


def noded(boundary: Boundary, size: float, fixed: int, parts: InnerParts) -> Boundary:
    """The boundary with corners wherever an inner piece meets another piece; tolerances are parts of the domain's size.

    The first ``fixed`` corners, those of the rings, stay separate, however near they are. GeometryError, about the part
    of the case that gives it, if a vertex is next to a line or to another vertex, or a curve next to another one, but
    not on it.
    """
    boundary = with_cuts(boundary, NO_CUTS, size, fixed)
    boundary = with_cuts(boundary, _meetings(boundary, size, parts), size, fixed)
    chords = chord_boxes(boundary, size)
    boundary = with_cuts(boundary, _corners_on_pieces(boundary, chords, size, fixed, parts), size, fixed)
    _require_apart(boundary.corners, size, fixed, parts)
    return boundary


def _meetings(boundary: Boundary, size: float, parts: InnerParts) -> CutPoints:
    """Cuts where inner pieces cross or touch other pieces or themselves, apart from their ends."""
    pairs = near_chords(boundary, chord_boxes(boundary, size))
    if len(pairs.p) == 0:
        return NO_CUTS
    same = coincident(boundary, pairs, size)
    along, pairs = select(pairs, same), select(pairs, ~same)
    cuts = openings(boundary, along), crossings(boundary, pairs, size), touches(boundary, pairs, along, size, parts)
    return concatenated(cuts)


def _corners_on_pieces(boundary: Boundary, chords: ChordBoxes, size: float, fixed: int, parts: InnerParts) -> CutPoints:
    """Cuts where corners are on pieces between their ends, one of the two being inner; GeometryError if one is near."""
    corner, chord = chords.boxes.query(shapely.points(boundary.corners), predicate="intersects")
    piece = chords.piece[chord]
    own = (corner == boundary.start[piece]) | (corner == boundary.end[piece])
    other = (~own | boundary.curved[piece]) & ((corner >= fixed) | boundary.inner[piece])
    corner, chord, piece = corner[other], chord[other], piece[other]
    s, target = chords.s[chord] + chords.step[chord] / 2, boundary.corners[corner]
    s = boundary.foot(target, piece, s, NEWTON_STEPS)
    foot = boundary.points(piece, s)
    distance = np.hypot(*(target - foot).T)
    found = (distance <= NEARLY * size) & between_ends(boundary, piece, s, TOUCHING * size)
    near = np.flatnonzero(found & (distance > TOUCHING * size))
    if len(near):
        k = near[0]
        vertex, beside = two_places(target[k], foot[k])
        with about(_key_at(parts, target[k]) if corner[k] >= fixed else parts.paths[-1 - boundary.ring[piece[k]]].key):
            raise GeometryError(
                f"the vertex at {vertex} is {distance[k]:.1g} away from the line at {beside}, next to it but not on "
                f"it{_point_at(parts, target[k : k + 1])}"
            )
    return CutPoints(piece[found], s[found], target[found])


def with_cuts(boundary: Boundary, cuts: CutPoints, size: float, fixed: int) -> Boundary:
    """The boundary with its pieces cut, at existing corners if there are any in these places."""
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
    """Distinct points (k, 2), and for each of the given points (n, 2) its number (n,) among them."""
    spots = shapely.points(points)
    i, j = shapely.STRtree(spots).query(spots, predicate="dwithin", distance=tolerance)
    known = np.arange(len(points))
    loose = (j < i) & (i >= fixed)
    np.minimum.at(known, i[loose], j[loose])
    while (known[known] != known).any():
        known = known[known]
    first = known == np.arange(len(points))
    return points[first], (np.cumsum(first) - 1)[known]


def _require_apart(corners: Floats, size: float, fixed: int, parts: InnerParts) -> None:
    """Check that no corner is next to another one, apart from two corners of rings."""
    spots = shapely.points(corners)
    i, j = shapely.STRtree(spots).query(spots, predicate="dwithin", distance=NEARLY * size)
    near = np.flatnonzero((j < i) & (i >= fixed))
    if len(near):
        first, second = corners[j[near[0]]], corners[i[near[0]]]
        one, other = two_places(first, second)
        with about(_key_at(parts, second)):
            raise GeometryError(
                f"the vertices at {one} and {other} are {np.hypot(*(first - second)):.1g} apart, next to each other "
                f"but not the same{_point_at(parts, np.stack([second, first]))}"
            )


def _point_at(parts: InnerParts, corners: Floats) -> str:
    """What to do with corners (k, 2) of an error, with the name and the remedy of an embedded point if one is there."""
    labels = {point.at: point.label for point in parts.points}
    label = next((labels[at] for at in map(as_point, corners) if at in labels), None)
    if label is None:
        return ": give them the same coordinates, or move them apart"
    return f": join beside the point {label!r} moves it there; else give them the same coordinates, or move them apart"


def _key_at(parts: InnerParts, corner: Floats) -> Key:
    """Key of the case that gives a corner (2,); an empty one for a corner that only a cut has made."""
    return parts.keys_at.get((float(corner[0]), float(corner[1])), Key())
