"""Rings that touch in a point: the point becomes a corner of both, so that the mesh has one node there."""

from collections import Counter
from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Floats, Integers, different_rows, each_once
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.arrangement import CONTACT_LENGTH, ROUNDINGS, TOUCHING
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.curves import shares_before
from bubblemesh.geometry.polygonal_copy import PolygonalCopy
from bubblemesh.messages import place

GAP_OF_CHORDS = 0.02  # two curves that touch are nearer to each other's chords than this part of the chords' lengths
MARGIN = 2.0  # times the reach of rings' points: for rounding
SETTLED = 6.0  # chords from a known contact, within which two rings do not touch again
MOST_SPLITS = 4  # of two rings, both at two points; more have a curve in common and bound no domain


class Contact(NamedTuple):
    """Point (2,) at arc length ``s`` of ``piece`` where the two ``rings`` touch."""

    piece: int
    s: float
    point: Floats
    rings: frozenset[int]


def split_at_contacts(boundary: Boundary) -> Boundary:
    """The boundary with a corner wherever a ring touches another one between its corners.

    GeometryError if corners of two rings are nearer to each other than touching curves may be, but not the same.
    """
    if (boundary.ring == boundary.ring[0]).all():
        return boundary
    line = PolygonalCopy.of(boundary)
    rounding = ROUNDINGS * float(np.spacing(np.abs(line.points).max()))
    tolerance = max(TOUCHING * float(np.ptp(line.points, axis=0).max()), rounding)
    splits: Counter[frozenset[int]] = Counter()
    while contacts := _contacts(boundary, line, tolerance, splits):
        boundary = boundary.split(*(np.array(column) for column in zip(*(c[:3] for c in contacts), strict=True)))
        line = PolygonalCopy.of(boundary)
        splits.update(contact.rings for contact in contacts)
    return boundary


def _contacts(
    boundary: Boundary, line: PolygonalCopy, tolerance: float, splits: Counter[frozenset[int]]
) -> list[Contact]:
    """Contacts that are not yet corners of their pieces, between rings that have not been split too often.

    They are searched along a ``line``, the copy of the boundary. Only one contact is returned for each pair of rings,
    and for each place: the next search must know its corner.
    """
    found = list[Contact]()
    for probe, chord in _candidates(boundary, line, tolerance):
        rings = frozenset([int(line.ring[probe]), int(line.ring[chord])])
        if splits[rings] >= MOST_SPLITS or any(rings == other.rings for other in found):
            continue
        piece = int(line.piece[chord])
        point = _closest(boundary, line, probe, chord)
        (s,), (foot,) = _feet(boundary, line, np.array([chord]), point[None])
        straight = not boundary.curved[[line.piece[probe], piece]].any()
        to_end = np.inf if boundary.closed[piece] else min(s, boundary.lengths[piece] - s)
        if straight and max(to_end, np.hypot(*(point - foot))) <= tolerance:
            raise _beside(point, min(np.hypot(*(boundary.corners - point).T), key=lambda away: away or np.inf))
        at_end = to_end <= (tolerance if straight else CONTACT_LENGTH * tolerance)
        alone = all(np.hypot(*(point - other.point)) > CONTACT_LENGTH * tolerance for other in found)
        if np.hypot(*(point - foot)) <= tolerance and not at_end and alone:
            found.append(Contact(piece, float(s), point, rings))
    return found


def _beside(point: Floats, away: float) -> GeometryError:
    """Error for a corner of a ring that is next to a corner of another ring."""
    return GeometryError(
        f"two rings have corners at {place(point)} that are {away:.1g} apart, next to each other but not the same: "
        "give them the same coordinates, or move them apart"
    )


def _candidates(boundary: Boundary, line: PolygonalCopy, tolerance: float) -> list[tuple[int, int]]:
    """Points of the polyline, and chords of other rings, where curves may touch: the nearest of each two pieces."""
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
    return list(zip(probe[nearest].tolist(), chord[nearest].tolist(), strict=True))


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
    distance = np.full(len(probe), np.inf)
    rings = np.column_stack([line.ring[probe], line.ring[chord]])
    for a, b in different_rows(rings)[0].tolist():
        shared = np.intersect1d(corner[ring == a], corner[ring == b])
        if len(shared):
            mine = (rings == (a, b)).all(axis=1)
            offset = line.points[probe[mine]][:, None] - boundary.corners[shared]
            distance[mine] = np.hypot(offset[..., 0], offset[..., 1]).min(axis=1)
    return distance


def _closest(boundary: Boundary, line: PolygonalCopy, probe: int, chord: int) -> Floats:
    """The point next to ``probe`` on its own piece that is nearest to the curve of ``chord``."""
    from scipy.optimize import minimize_scalar  # takes longer to load than most cases take to mesh

    piece, s, step = line.piece[probe], line.s[probe], line.step[probe]
    if boundary.start[piece] >= 0 and s == 0:
        return line.points[probe]

    def point(at: float) -> Floats:
        return boundary.points(np.array([piece]), np.array([at % boundary.lengths[piece]]))[0]

    def gap(at: float) -> float:
        foot = _feet(boundary, line, np.array([chord]), point(at)[None])[1][0]
        return float(np.hypot(*(point(at) - foot)))

    return point(minimize_scalar(gap, bounds=(s - step, s + step), method="bounded", options={"xatol": 0.0}).x)


def _feet(boundary: Boundary, line: PolygonalCopy, chord: Integers, points: Floats) -> tuple[Floats, Floats]:
    """Arc lengths (m,) and places (m, 2) of the points next to ``points`` (m, 2) on the curves of the chords (m,)."""
    piece = line.piece[chord]
    share = shares_before(points, line.points[chord], line.points[line.successor[chord]])
    s = boundary.foot(points, piece, line.s[chord] + share * line.step[chord], steps=4)
    return s, boundary.points(piece, s)
