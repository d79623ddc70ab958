"""Rings that touch in a point: the point becomes a corner of both, so that the mesh has one node there."""

from collections import Counter
from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import (
    Booleans,
    Floats,
    Integers,
    contained,
    each_once,
    first_rows,
    members,
    pairs_of_groups,
    select,
)
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.arrangement import CONTACT_LENGTH, ROUNDINGS, TOUCHING
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.curves import shares_before
from bubblemesh.geometry.polygonal_copy import PolygonalCopy
from bubblemesh.messages import place

GAP_OF_CHORDS = 0.02  # two curves that touch are nearer to each other's chords than this part of the chords' lengths
MARGIN = 2.0  # times the reach of rings' points: for rounding
SETTLED = 6.0  # chords from a known contact, within which two rings do not touch again
REFINED, REFINEMENTS = 8, 9  # a place of contact is looked for at 8 places to each side, then 8 times as finely
FITTED = 4  # of these refinements, where distances of curves that touch are still far above rounding
FLAT = 1e-3  # of the distances around it: at the vertex of a parabola it is no larger than at the place found
MOST_SPLITS = 4  # of two rings, both at two points; more have a curve in common and bound no domain


class Touches(NamedTuple):
    """Points (k, 2) at arc lengths ``s`` (k,) of the pieces (k,), where the rings of the pairs (k,) touch."""

    piece: Integers
    s: Floats
    points: Floats
    pair: Integers  # number of the first ring, times the number of rings, plus that of the second one


def split_at_contacts(boundary: Boundary) -> Boundary:
    """The boundary with a corner wherever a ring touches another one between its corners.

    GeometryError if corners of two rings are nearer to each other than touching curves may be, but not the same.
    """
    if (boundary.ring == boundary.ring[0]).all():
        return boundary
    line = PolygonalCopy.of(boundary)
    rounding = ROUNDINGS * float(np.spacing(np.abs(line.points).max()))
    tolerance = max(TOUCHING * float(np.ptp(line.points, axis=0).max()), rounding)
    splits: Counter[int] = Counter()  # of each pair
    while len((contacts := _contacts(boundary, line, tolerance, splits)).piece):
        boundary = boundary.split(contacts.piece, contacts.s, contacts.points)
        line = PolygonalCopy.of(boundary)
        splits.update(contacts.pair.tolist())
    return boundary


def _contacts(boundary: Boundary, line: PolygonalCopy, tolerance: float, splits: Counter[int]) -> Touches:
    """Contacts that are not yet corners of their pieces, between rings that have not been split too often.

    They are searched along a ``line``, the copy of the boundary. Only one contact is returned for each pair of rings,
    and for each place: the next search must know its corner.
    """
    probe, chord = _candidates(boundary, line, tolerance)
    rings = np.sort(np.column_stack([line.ring[probe], line.ring[chord]]), axis=1)
    pair = rings @ (len(line.area_of_ring), 1)
    often = np.array(sorted(pair for pair, times in splits.items() if times >= MOST_SPLITS), np.int64)
    probe, chord, pair = (column[~contained(pair, often)] for column in (probe, chord, pair))
    piece, points = line.piece[chord], _closest(boundary, line, probe, chord)
    s, feet = _feet(boundary, line, chord, points)
    touching = np.hypot(*(points - feet).T) <= tolerance
    straight = ~(boundary.curved[line.piece[probe]] | boundary.curved[piece])
    to_end = np.where(boundary.closed[piece], np.inf, np.minimum(s, boundary.lengths[piece] - s))
    for point in points[touching & straight & (to_end <= tolerance)]:
        raise _beside(point, min(np.hypot(*(boundary.corners - point).T), key=lambda away: away or np.inf))
    inside = to_end > np.where(straight, tolerance, CONTACT_LENGTH * tolerance)
    found = select(Touches(piece, s, points, pair), touching & inside)
    found = select(found, first_rows(found.pair[:, None]))
    return select(found, _first_of_places(found.points, CONTACT_LENGTH * tolerance))


def _first_of_places(points: Floats, reach: float) -> Booleans:
    """Which points (k,) have none before them within reach."""
    places = shapely.points(points)
    one, other = shapely.STRtree(places).query(places, predicate="dwithin", distance=reach)
    first = np.ones(len(points), bool)
    first[other[one < other]] = False
    return first


def _beside(point: Floats, away: float) -> GeometryError:
    """Error for a corner of a ring that is next to a corner of another ring."""
    return GeometryError(
        f"two rings have corners at {place(point)} that are {away:.1g} apart, next to each other but not the same: "
        "give them the same coordinates, or move them apart"
    )


def _candidates(boundary: Boundary, line: PolygonalCopy, tolerance: float) -> tuple[Integers, Integers]:
    """Points (k,) of the polyline and chords (k,) of other rings where curves may touch: the nearest of two pieces.

    Corners come first: a place that one ring has a corner at already gets no other one beside it.
    """
    start, end = line.points, line.points[line.successor]
    length = np.hypot(*(end - start).T)
    curved = boundary.approximated[line.piece]
    reach = np.maximum(tolerance, GAP_OF_CHORDS * length * curved)
    probe, chord = _near(line, reach)
    around = SETTLED * np.maximum(length[probe] * curved[probe], length[chord] * curved[chord])
    unsettled = _to_shared_corner(boundary, line, probe, chord) > around
    probe, chord = probe[unsettled], chord[unsettled]
    gap = np.hypot(*(line.points[probe] - _feet(boundary, line, chord, line.points[probe])[1]).T)
    order = np.lexsort((gap, line.piece[chord], line.piece[probe]))
    pairs = np.column_stack([line.piece[probe], line.piece[chord]])[order]
    nearest = order[np.flatnonzero((np.diff(pairs, axis=0, prepend=-1) != 0).any(axis=1))]
    nearest = nearest[np.argsort(~_at_corner(boundary, line, probe[nearest]), kind="stable")]
    return probe[nearest], chord[nearest]


def _near(line: PolygonalCopy, reach: Floats) -> tuple[Integers, Integers]:
    """Points (k,) and chords (k,) of other rings that are within the reach (m,) of either, in order."""
    some = _of_near_rings(line, reach)
    points = shapely.points(line.points[some])
    chords = shapely.linestrings(np.stack(line.chords[3:], axis=1)[some])
    reach = reach[some]
    # A search for each of the two reaches: with one reach, long chords would find far too many points for short ones.
    probe, chord = shapely.STRtree(chords).query(points, predicate="dwithin", distance=reach)
    other, found = shapely.STRtree(points).query(chords, predicate="dwithin", distance=reach)
    probe, chord = some[np.append(probe, found)], some[np.append(chord, other)]
    apart = line.ring[probe] != line.ring[chord]
    return np.divmod(each_once(probe[apart] * len(line.points) + chord[apart]), len(line.points))


def _of_near_rings(line: PolygonalCopy, reach: Floats) -> Integers:
    """Numbers (k,) of the points and chords of rings that are near to another ring, beside which no other counts.

    Of thousands of rings most are far from all others, which is found much faster ring by ring than chord by chord.
    """
    begin = np.flatnonzero(np.diff(line.ring, prepend=line.ring[0] - 1))
    count = np.diff(begin, append=len(line.ring))
    closed = np.insert(np.arange(len(line.ring)), begin + count, begin)
    row = np.repeat(np.arange(len(begin)), count + 1)
    rings = shapely.linestrings(line.points[closed], indices=row)
    far = MARGIN * np.maximum.reduceat(reach, begin)
    low, high = (
        np.minimum.reduceat(line.points, begin) - far[:, None],
        np.maximum.reduceat(line.points, begin) + far[:, None],
    )
    boxes = shapely.box(*low.T, *high.T)
    one, other = shapely.STRtree(boxes).query(boxes)
    larger = (count[one] > count[other]) | ((count[one] == count[other]) & (one < other))
    one, other = one[larger], other[larger]
    shapely.prepare(rings)
    near = shapely.dwithin(rings[one], rings[other], far[one] + far[other])
    chosen = np.zeros(len(begin), bool)
    chosen[one[near]] = chosen[other[near]] = True
    return np.flatnonzero(np.repeat(chosen, count))


def _to_shared_corner(boundary: Boundary, line: PolygonalCopy, probe: Integers, chord: Integers) -> Floats:
    """Distances (m,) of the probes from the nearest corner that their ring shares with the chords' ring."""
    corner, ring = boundary.ring_corners()
    own, other = pairs_of_groups(corner)  # each ring at a corner with each one there
    rings = len(line.area_of_ring)
    pair = ring[own] * rings + ring[other]
    order = np.argsort(pair)
    wanted = line.ring[probe] * rings + line.ring[chord]
    begin, end = (np.searchsorted(pair, wanted, side, order) for side in ("left", "right"))
    row, rank = members(end - begin)
    shared = corner[own[order[begin[row] + rank]]]
    distance = np.full(len(probe), np.inf)
    np.minimum.at(distance, row, np.hypot(*(line.points[probe[row]] - boundary.corners[shared]).T))
    return distance


def _at_corner(boundary: Boundary, line: PolygonalCopy, probe: Integers) -> Booleans:
    """Which of the probes (m,) are corners."""
    return (line.s[probe] == 0) & ~boundary.closed[line.piece[probe]]


def _closest(boundary: Boundary, line: PolygonalCopy, probe: Integers, chord: Integers) -> Floats:
    """The points (k, 2) next to the probes on their own pieces that are nearest to the curves of the chords."""
    points = line.points[probe]
    moved = np.flatnonzero(~_at_corner(boundary, line, probe))
    piece, s, width = line.piece[probe[moved]], line.s[probe[moved]], line.step[probe[moved]]

    def away(at: Floats) -> Floats:
        """Distances (k, m) from the curves of the chords of places at arc lengths (k, m)."""
        count = at.shape[1]
        places = boundary.points(np.repeat(piece, count), boundary.wrapped(piece[:, None], at).ravel())
        feet = _feet(boundary, line, np.repeat(chord[moved], count), places)[1]
        return np.hypot(*(places - feet).T).reshape(at.shape)

    for finer in range(REFINEMENTS):
        at = s[:, None] + width[:, None] * np.linspace(-1, 1, 2 * REFINED + 1) / REFINED**finer
        s = np.take_along_axis(at, away(at).argmin(axis=1)[:, None], axis=1)[:, 0]
    # Where curves touch the distance is a parabola, whose vertex is known better than its values tell close to it.
    width = width / REFINED**FITTED
    before, least, after = away(s[:, None] + width[:, None] * [-1.0, 0.0, 1.0]).T
    bend = before - 2 * least + after
    slope = np.divide(before - after, bend, out=np.zeros(len(bend)), where=bend > 0)
    vertex = s + width / 2 * np.clip(slope, -1, 1)
    touching = away(vertex[:, None])[:, 0] <= least + FLAT * np.minimum(before, after)
    points[moved] = boundary.points(piece, boundary.wrapped(piece, np.where(touching, vertex, s)))
    return points


def _feet(boundary: Boundary, line: PolygonalCopy, chord: Integers, points: Floats) -> tuple[Floats, Floats]:
    """Arc lengths (m,) and places (m, 2) of the points next to ``points`` (m, 2) on the curves of the chords (m,)."""
    piece = line.piece[chord]
    share = shares_before(points, line.points[chord], line.points[line.successor[chord]])
    s = boundary.foot(points, piece, line.s[chord] + share * line.step[chord], steps=4)
    return s, boundary.points(piece, s)
