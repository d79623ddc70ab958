"""Lines become pieces that meet at corners only: cut where they cross, touch, or where a corner is on one of them."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.curves import turning
from bubblemesh.wording import place

__all__ = ["TOUCHING", "noded"]

TOUCHING = 1e-9  # of the domain's size: nearer is the same
NEARLY = 1e-6  # of the domain's size: nearer, but not the same, is a slip of the user's
NEWTON_STEPS = 12
PARALLEL = 1e-6  # sine of the angle between two lines, below which they follow each other rather than cross
SAGITTA = 0.02  # of a chord's length, which its curve stays closer to
SAME_BEND = 1e-3  # relative difference of two curvatures, below which curves follow each other rather than touch
CONTACT_LENGTH = 1e5  # curves of radius R touch over a length of sqrt(8 R tolerance), not in a point


class Chords(NamedTuple):
    """Chords of a fine polygonal copy: piece (m,), arc length (m,) and its step (m,), and boxes around the curve."""

    piece: Integers
    s: Floats
    step: Floats
    boxes: shapely.STRtree


class Cuts(NamedTuple):
    """Points (m, 2) at arc length s (m,) of pieces (m,)."""

    piece: Integers
    s: Floats
    points: Floats


class Pairs(NamedTuple):
    """Chords near each other: their pieces p and q (m,), the arc lengths a and b of their middles, their steps."""

    p: Integers
    q: Integers
    a: Floats
    b: Floats
    step_a: Floats
    step_b: Floats


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
    boundary = _cut(boundary, Cuts(none, np.zeros(0), np.zeros((0, 2))), size, fixed)
    boundary = _cut(boundary, _meetings(boundary, _chords(boundary, size), size), size, fixed)
    boundary = _cut(boundary, _corners_on_pieces(boundary, _chords(boundary, size), size, fixed), size, fixed)
    _require_apart(boundary.corners, size, fixed)
    return boundary


def _cut(boundary: Boundary, cuts: Cuts, size: float, fixed: int) -> Boundary:
    """The boundary with its pieces cut, at corners that it has already where there are any."""
    count = len(boundary.corners)
    corners, number = _clustered(np.vstack([boundary.corners, cuts.points]), TOUCHING * size, fixed)
    ends = [np.where(end >= 0, number[end], -1) for end in (boundary.start, boundary.end)]
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


def _chords(boundary: Boundary, size: float) -> Chords:
    piece, s, step = boundary.panels()
    ends = np.stack([boundary.points(piece, s), boundary.points(piece, s + step)], axis=1)
    around = np.where(boundary.curved[piece], SAGITTA * step, 0) + NEARLY * size
    low, high = ends.min(axis=1) - around[:, None], ends.max(axis=1) + around[:, None]
    return Chords(piece, s, step, shapely.STRtree(shapely.box(*low.T, *high.T)))


def _meetings(boundary: Boundary, chords: Chords, size: float) -> Cuts:
    """Where inner pieces cross or touch others, each other or themselves, but for their ends."""
    piece, s, step, boxes = chords
    mine = np.flatnonzero(boundary.inner[piece])
    i, j = boxes.query(boxes.geometries[mine], predicate="intersects")
    i = mine[i]
    i, j = (column[(i < j) | ~boundary.inner[piece[j]]] for column in (i, j))
    start, end, curved = boundary.start, boundary.end, boundary.curved
    p, q = piece[i], piece[j]
    joined = (start[p] == start[q]) | (start[p] == end[q]) | (end[p] == start[q]) | (end[p] == end[q])
    gap = np.abs(s[i] - s[j])  # neighbours on one curve are no crossing
    gap = np.where(boundary.closed[p] | (start[p] == end[p]), np.minimum(gap, boundary.lengths[p] - gap), gap)
    wanted = np.where(p == q, gap > 1.5 * step[i], curved[p] | curved[q] | ~joined)
    i, j = i[wanted], j[wanted]
    pairs = Pairs(piece[i], piece[j], s[i] + step[i] / 2, s[j] + step[j] / 2, step[i], step[j])
    crossing, touching = _crossings(boundary, pairs, size), _touches(boundary, pairs, size)
    return Cuts(*(np.concatenate(columns) for columns in zip(crossing, touching, strict=True)))


def _limited(ahead: Floats, step: Floats) -> Floats:
    """Steps (m,) of an iteration, not far beyond a chord."""
    return np.clip(ahead, -2 * step, 2 * step)


def _bend(boundary: Boundary, piece: Integers, middle: Floats, step: Floats) -> Floats:
    """Mean curvature (m,) along chords."""
    before, after = (boundary.tangents(piece, middle + t * step) for t in (-0.5, 0.5))
    return np.where(boundary.curved[piece], turning(before, after) / step, 0)


def _crossings(boundary: Boundary, pairs: Pairs, size: float) -> Cuts:
    """Cuts where the curves of chords cross."""
    p, q, a, b, step_a, step_b = pairs
    tolerance = TOUCHING * size
    for _ in range(NEWTON_STEPS):
        # Both curves as their tangents: where these meet.
        (ux, uy), (vx, vy) = boundary.tangents(p, a).T, boundary.tangents(q, b).T
        gx, gy = (boundary.points(q, b) - boundary.points(p, a)).T
        across = ux * vy - uy * vx
        slope = np.where(across == 0, np.inf, across)
        ahead = _limited((gx * vy - gy * vx) / slope, step_a)
        a = boundary.wrapped(p, a + ahead)
        b = boundary.wrapped(q, b + _limited((gx * uy - gy * ux) / slope, step_b))
    points = boundary.points(p, a)
    met = (np.hypot(*(points - boundary.points(q, b)).T) <= tolerance) & (np.abs(across) > PARALLEL)
    met &= np.abs(ahead) <= tolerance  # where curves touch, the steps halve only
    met &= _between_ends(boundary, p, a, tolerance) & _between_ends(boundary, q, b, tolerance)
    met &= (p != q) | (np.abs(a - b) > CONTACT_LENGTH * tolerance)
    return Cuts(np.concatenate([p[met], q[met]]), np.concatenate([a[met], b[met]]), np.tile(points[met], (2, 1)))


def _touches(boundary: Boundary, pairs: Pairs, size: float) -> Cuts:
    """Cuts where the curves of chords touch with a common tangent.

    Of two closed curves that are the same, one point is a cut of both.

    Raises
    ------
    GeometryError
        If one passes the other next to it.
    """
    tolerance = TOUCHING * size
    curved = (boundary.curved[pairs.p] | boundary.curved[pairs.q]) & (pairs.p != pairs.q)
    p, q, a, b, step_a, step_b = (column[curved] for column in pairs)
    bends = np.column_stack([_bend(boundary, p, a, step_a), _bend(boundary, q, b, step_b)])
    for _ in range(NEWTON_STEPS):
        # Where the tangents are parallel, and each point is opposite of the other.
        ahead = np.einsum("ij,ij->i", boundary.points(p, a) - boundary.points(q, b), boundary.tangents(q, b))
        b = boundary.wrapped(q, b + ahead)
        t, v = boundary.tangents(p, a), boundary.tangents(q, b)
        sense = np.where(np.einsum("ij,ij->i", t, v) < 0, -1.0, 1.0)
        angle, bend = turning(t, sense[:, None] * v), bends[:, 0] - sense * bends[:, 1]
        alike = np.abs(bend) <= SAME_BEND * np.abs(bends).max(axis=1, initial=0)
        off = np.where(alike, 0, angle / np.where(alike, 1, bend))
        a = boundary.wrapped(p, a + _limited(off, step_a))
    offset, v = boundary.points(p, a) - boundary.points(q, b), boundary.tangents(q, b)
    distance = np.hypot(*offset.T)
    opposite = (np.abs(np.einsum("ij,ij->i", offset, v)) <= tolerance) & (np.abs(off) <= tolerance)
    opposite &= ~alike | (np.abs(angle) <= PARALLEL)
    around = CONTACT_LENGTH * tolerance
    opposite &= _between_ends(boundary, p, a, around) & _between_ends(boundary, q, b, around)
    near = np.flatnonzero(opposite & (distance > tolerance) & (distance <= NEARLY * size))
    if len(near):
        k = near[0]
        raise GeometryError(
            f"two curves pass each other at {place(boundary.points(p[[k]], a[[k]])[0])} at a distance of "
            f"{distance[k]:.1g}, next to each other but not touching: let them touch, or move them apart"
        )
    same = np.flatnonzero(opposite & (distance <= tolerance) & ~alike)
    equal = np.flatnonzero(opposite & (distance <= tolerance) & alike & boundary.closed[p] & boundary.closed[q])
    equal = equal[np.unique(np.column_stack([p, q])[equal], axis=0, return_index=True)[1]]
    k = np.concatenate([same, equal])
    points = boundary.points(p[k], a[k])
    return Cuts(np.concatenate([p[k], q[k]]), np.concatenate([a[k], b[k]]), np.tile(points, (2, 1)))


def _between_ends(boundary: Boundary, piece: Integers, s: Floats, margin: float) -> Booleans:
    """Whether places (m,) on pieces are not next to the pieces' ends."""
    return boundary.closed[piece] | ((s > margin) & (s < boundary.lengths[piece] - margin))


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
    found = (distance <= NEARLY * size) & _between_ends(boundary, piece, s, TOUCHING * size)
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
