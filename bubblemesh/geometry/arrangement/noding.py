"""Lines become pieces that meet at corners only: cut where they cross, touch, or where a corner is on one of them."""

import numpy as np
import shapely

from bubblemesh.arrays import Floats
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.arrangement.coincidence import following, openings
from bubblemesh.geometry.arrangement.crossings import NEWTON_STEPS, Chords, chords_of, crossings, near_pairs, touches
from bubblemesh.geometry.arrangement.cuts import NEARLY, TOUCHING, Cuts, between_ends, cut
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.messages import place


def noded(boundary: Boundary, size: float, fixed: int) -> Boundary:
    """The boundary with corners wherever an inner piece meets another piece.

    Parameters
    ----------
    boundary : Boundary
    size : float
        Of the domain, for tolerances.
    fixed : int
        Number of corners that come first and stay apart, however near they are: those of the rings.

    Raises
    ------
    GeometryError
        If a vertex is next to a line or to another vertex, or a curve next to another one, but not on it.
    """
    none = np.zeros(0, np.int64)
    boundary = cut(boundary, Cuts(none, np.zeros(0), np.zeros((0, 2))), size, fixed)
    boundary = cut(boundary, _meetings(boundary, size), size, fixed)
    boundary = cut(boundary, _corners_on_pieces(boundary, chords_of(boundary, size), size, fixed), size, fixed)
    _require_apart(boundary.corners, size, fixed)
    return boundary


def _meetings(boundary: Boundary, size: float) -> Cuts:
    """Where inner pieces cross or touch others, each other or themselves, but for their ends."""
    pairs = near_pairs(boundary, chords_of(boundary, size))
    same = following(boundary, pairs, size)
    along, pairs = pairs.kept(same), pairs.kept(~same)
    cuts = openings(boundary, along), crossings(boundary, pairs, size), touches(boundary, pairs, size)
    return Cuts(*(np.concatenate(columns) for columns in zip(*cuts, strict=True)))


def _corners_on_pieces(boundary: Boundary, chords: Chords, size: float, fixed: int) -> Cuts:
    """Where corners are on pieces between their ends, one of the two being inner.

    Raises
    ------
    GeometryError
        If one is next to a piece but not on it.
    """
    corner, chord = chords.boxes.query(shapely.points(boundary.corners), predicate="intersects")
    piece = chords.piece[chord]
    own = (corner == boundary.start[piece]) | (corner == boundary.end[piece])
    other = (~own | boundary.curved[piece]) & ((corner >= fixed) | boundary.inner[piece])
    corner, chord, piece = corner[other], chord[other], piece[other]
    s, target = chords.s[chord] + chords.step[chord] / 2, boundary.corners[corner]
    for _ in range(NEWTON_STEPS):
        ahead = np.einsum("ij,ij->i", target - boundary.points(piece, s), boundary.tangents(piece, s))
        s = boundary.wrapped(piece, s + ahead)
    foot = boundary.points(piece, s)
    distance = np.hypot(*(target - foot).T)
    found = (distance <= NEARLY * size) & between_ends(boundary, piece, s, TOUCHING * size)
    near = np.flatnonzero(found & (distance > TOUCHING * size))
    if len(near):
        k = near[0]
        raise GeometryError(
            f"the vertex at {place(target[k])} is {distance[k]:.1g} away from the line at {place(foot[k])}, next to "
            "it but not on it: give them the same coordinates, or move them apart"
        )
    return Cuts(piece[found], s[found], target[found])


def _require_apart(corners: Floats, size: float, fixed: int) -> None:
    """Check that no corner is next to another one, but for those of the rings."""
    spots = shapely.points(corners)
    i, j = shapely.STRtree(spots).query(spots, predicate="dwithin", distance=NEARLY * size)
    near = np.flatnonzero((j < i) & (i >= fixed))
    if len(near):
        first, second = corners[j[near[0]]], corners[i[near[0]]]
        raise GeometryError(
            f"the vertices at {place(first)} and {place(second)} are {np.hypot(*(first - second)):.1g} apart, next to "
            "each other but not the same: give them the same coordinates, or move them apart"
        )
