"""Places where curves cross, touch with a common tangent, or run along each other."""

from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers, contained, select
from bubblemesh.errors import GeometryError, about
from bubblemesh.geometry.arrangement import CONTACT_LENGTH, NEARLY, TOUCHING
from bubblemesh.geometry.arrangement.bellies import NEWTON_STEPS, SAGITTA
from bubblemesh.geometry.arrangement.regions import InnerParts
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.curves import turning
from bubblemesh.messages import place

PARALLEL = 1e-6  # sine of the angle between two lines, below which they follow each other rather than cross
SAME_BEND = 1e-3  # relative difference of two curvatures, below which curves run beside each other
BESIDE_ANGLE = 2e-5  # radians between them: `SAME_BEND` of the turn along a chord, which is 0.025
AHEAD = 0.25  # of a chord: places beside a crossing
ENDS = -0.5, 0.5  # of a chord, in its length from the middle


class CutPoints(NamedTuple):
    """Points (m, 2) at arc length s (m,) of pieces (m,)."""

    piece: Integers
    s: Floats
    points: Floats


class ChordBoxes(NamedTuple):
    """Chords of pieces: piece (m,), arc length (m,) and its step (m,), and boxes around the curve."""

    piece: Integers
    s: Floats
    step: Floats
    boxes: shapely.STRtree


class NearChords(NamedTuple):
    """Chords near each other: their pieces p and q (m,), the arc lengths a and b of their middles, their steps."""

    p: Integers
    q: Integers
    a: Floats
    b: Floats
    step_a: Floats
    step_b: Floats


def chord_boxes(boundary: Boundary, size: float) -> ChordBoxes:
    """Chords of all pieces, with boxes that hold the curves and a margin within which others are near."""
    piece, s, step = boundary.stations()
    ends = np.stack([boundary.points(piece, s), boundary.points(piece, s + step)], axis=1)
    around = np.where(boundary.curved[piece], SAGITTA * step, 0) + NEARLY * size
    low, high = ends.min(axis=1) - around[:, None], ends.max(axis=1) + around[:, None]
    return ChordBoxes(piece, s, step, shapely.STRtree(shapely.box(*low.T, *high.T)))


def near_chords(boundary: Boundary, chords: ChordBoxes) -> NearChords:
    """Chords of inner pieces beside those of others, or of the same piece, where they may cross or touch."""
    piece, s, step, boxes = chords
    mine = np.flatnonzero(boundary.inner[piece])
    i, j = boxes.query(boxes.geometries[mine], predicate="intersects")
    i = mine[i]
    i, j = (column[(i < j) | ~boundary.inner[piece[j]]] for column in (i, j))
    start, end, curved = boundary.start, boundary.end, boundary.curved
    p, q = piece[i], piece[j]
    joined = (start[p] == start[q]) | (start[p] == end[q]) | (end[p] == start[q]) | (end[p] == end[q])
    gap = np.abs(s[i] - s[j])  # neighbours on one curve are not a crossing
    gap = np.where(boundary.closed[p] | (start[p] == end[p]), np.minimum(gap, boundary.lengths[p] - gap), gap)
    kept = np.where(p == q, gap > 1.5 * step[i], curved[p] | curved[q] | ~joined)
    i, j = i[kept], j[kept]
    return NearChords(piece[i], piece[j], s[i] + step[i] / 2, s[j] + step[j] / 2, step[i], step[j])


def crossings(boundary: Boundary, pairs: NearChords, size: float) -> CutPoints:
    """Cuts where the curves of chords cross."""
    p, q, a, b, step_a, step_b = pairs
    tolerance = TOUCHING * size
    for _ in range(NEWTON_STEPS):
        # Both curves as their tangents: where these meet.
        (ux, uy), (vx, vy) = boundary.tangents(p, a).T, boundary.tangents(q, b).T
        gx, gy = (boundary.points(q, b) - boundary.points(p, a)).T
        across = ux * vy - uy * vx
        slope = np.where(across == 0, np.inf, across)
        ahead = np.clip((gx * vy - gy * vx) / slope, -2 * step_a, 2 * step_a)
        a = boundary.wrapped(p, a + ahead)
        b = boundary.wrapped(q, b + np.clip((gx * uy - gy * ux) / slope, -2 * step_b, 2 * step_b))
    points = boundary.points(p, a)
    met = (np.hypot(*(points - boundary.points(q, b)).T) <= tolerance) & (np.abs(across) > PARALLEL)
    met &= np.abs(ahead) <= tolerance  # where curves touch, the steps halve only
    met &= between_ends(boundary, p, a, tolerance) & between_ends(boundary, q, b, tolerance)
    met &= (p != q) | (np.abs(a - b) > CONTACT_LENGTH * tolerance)
    met &= ~_both_go_on(boundary, NearChords(p, q, a, b, step_a, step_b), tolerance)
    return CutPoints(np.concatenate([p[met], q[met]]), np.concatenate([a[met], b[met]]), np.tile(points[met], (2, 1)))


def _both_go_on(boundary: Boundary, pairs: NearChords, tolerance: float) -> Booleans:
    """Whether curves are the same on both sides of places a and b (m,), as at a kink of a stretch in common."""
    p, q, a, b, step_a, step_b = pairs
    near = AHEAD * np.minimum(step_a, step_b)
    ahead, behind = (boundary.points(p, boundary.wrapped(p, a + way)) for way in (near, -near))
    others = [boundary.points(q, boundary.wrapped(q, b + way)) for way in (near, -near)]
    return np.logical_or.reduce(
        [_same(ahead, u, tolerance) & _same(behind, v, tolerance) for u, v in (others, others[::-1])]
    )


def _same(some: Floats, others: Floats, tolerance: float) -> Booleans:
    return np.asarray(np.hypot(*(some - others).T) <= tolerance)


def touches(boundary: Boundary, pairs: NearChords, along: NearChords, size: float, parts: InnerParts) -> CutPoints:
    """Cuts where the curves of chords touch with a common tangent; GeometryError where one passes the other next to it.

    Curves of the pairs ``along`` have stretches in common. An error is about the part of the case that gives the first
    such place.
    """
    tolerance = TOUCHING * size
    curved = (boundary.curved[pairs.p] | boundary.curved[pairs.q]) & (pairs.p != pairs.q)
    p, q, a, b, step_a, step_b = (column[curved] for column in pairs)
    bends = np.column_stack([_bend(boundary, p, a, step_a), _bend(boundary, q, b, step_b)])
    for _ in range(NEWTON_STEPS):
        # Where the tangents are parallel, and each point is opposite of the other.
        b = boundary.foot(boundary.points(p, a), q, b, steps=1)
        t, v = boundary.tangents(p, a), boundary.tangents(q, b)
        sense = np.where(np.einsum("ij,ij->i", t, v) < 0, -1.0, 1.0)
        angle, bend = turning(t, sense[:, None] * v), bends[:, 0] - sense * bends[:, 1]
        alike = np.abs(bend) <= SAME_BEND * np.abs(bends).max(axis=1, initial=0)
        off = np.where(alike, 0, angle / np.where(alike, 1, bend))
        a = boundary.wrapped(p, a + np.clip(off, -2 * step_a, 2 * step_a))
    offset, v = boundary.points(p, a) - boundary.points(q, b), boundary.tangents(q, b)
    distance = np.hypot(*offset.T)
    opposite = (np.abs(np.einsum("ij,ij->i", offset, v)) <= tolerance) & (np.abs(off) <= tolerance)
    opposite &= ~alike | (np.abs(angle) <= BESIDE_ANGLE)
    around = CONTACT_LENGTH * tolerance
    opposite &= between_ends(boundary, p, a, around) & between_ends(boundary, q, b, around)
    # From the chords beside a kink one comes to a stretch in common: there curves do not pass each other.
    common = (distance <= tolerance) & _belong(p, q, along)
    near = np.flatnonzero(opposite & ~common & (alike | (distance > tolerance)) & (distance <= NEARLY * size))
    if len(near):
        k = near[0]
        with about(parts.paths[-1 - boundary.ring[p[k]]].key):
            raise GeometryError(
                f"two curves pass each other at {place(boundary.points(p[[k]], a[[k]])[0])} at a distance of "
                f"{distance[k]:.1g}, next to each other but not the same and not touching in a point: let them touch, "
                "or move them apart"
            )
    k = np.flatnonzero(opposite & (distance <= tolerance) & ~alike)
    points = boundary.points(p[k], a[k])
    return CutPoints(np.concatenate([p[k], q[k]]), np.concatenate([a[k], b[k]]), np.tile(points, (2, 1)))


def _belong(p: Integers, q: Integers, pairs: NearChords) -> Booleans:
    """Whether two pieces p and q (m,) are, in either order, those of one of some pairs of chords."""
    n = max(int(np.max(part, initial=0)) for part in (p, q, pairs.p, pairs.q)) + 1
    keys, known = (np.minimum(one, other) * n + np.maximum(one, other) for one, other in ((p, q), (pairs.p, pairs.q)))
    return contained(keys, np.sort(known))


def _bend(boundary: Boundary, piece: Integers, middle: Floats, step: Floats) -> Floats:
    """Mean curvature (m,) along chords; those of polylines have kinks at their ends only."""
    before, after = (boundary.tangents(piece, boundary.wrapped(piece, middle + t * step)) for t in (-0.5, 0.5))
    return np.where(boundary.approximated[piece], turning(before, after) / step, 0)


def coincident(boundary: Boundary, pairs: NearChords, size: float) -> Booleans:
    """Mask (m,) of the pairs of two curves that have a stretch in common, however each of them is made.

    The test is whether the middle and an end of the first chord are on the second curve. Curves that only touch
    separate within half a chord, or are so similar that `require_separation` refuses them.
    """
    result = np.zeros(len(pairs.p), bool)
    curved = (boundary.curved[pairs.p] | boundary.curved[pairs.q]) & (pairs.p != pairs.q)
    found = np.flatnonzero(curved)
    found = found[_is_on(boundary, select(pairs, found), 0.0, size)]
    rest = select(pairs, found)
    result[found] = _is_on(boundary, rest, ENDS[0], size) | _is_on(boundary, rest, ENDS[1], size)
    return result


def openings(boundary: Boundary, pairs: NearChords) -> CutPoints:
    """A cut of both curves for each two closed ones that are the same, given by pairs of their chords."""
    closed = np.flatnonzero(boundary.closed[pairs.p] & boundary.closed[pairs.q])
    first = closed[np.unique(np.column_stack([pairs.p, pairs.q])[closed], axis=0, return_index=True)[1]]
    p, q, a = pairs.p[first], pairs.q[first], pairs.a[first]
    points = boundary.points(p, a)
    b = boundary.foot(points, q, pairs.b[first], NEWTON_STEPS, longest=2 * pairs.step_b[first])
    return CutPoints(np.concatenate([p, q]), np.concatenate([a, b]), np.tile(points, (2, 1)))


def _is_on(boundary: Boundary, pairs: NearChords, share: float, size: float) -> Booleans:
    """Whether a place on the first chord, given from its middle in its length, is on the second curve."""
    p, q, a, b, step_a, step_b = pairs
    points = boundary.points(p, boundary.wrapped(p, a + share * step_a))
    foot = boundary.points(q, boundary.foot(points, q, b, NEWTON_STEPS, longest=2 * step_b))
    return np.hypot(*(points - foot).T) <= TOUCHING * size


def between_ends(boundary: Boundary, piece: Integers, s: Floats, margin: float) -> Booleans:
    """Whether places (m,) on pieces are not next to the pieces' ends."""
    return boundary.closed[piece] | ((s > margin) & (s < boundary.lengths[piece] - margin))
