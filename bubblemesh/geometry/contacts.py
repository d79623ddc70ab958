"""Rings that touch in a point: the point becomes a corner of both, so that the mesh has one node there."""

from collections import Counter
from typing import NamedTuple

import numpy as np
import shapely
from scipy.optimize import minimize_scalar

from bubblemesh.arrays import Floats
from bubblemesh.geometry.boundary import Boundary, Polyline

__all__ = ["joined"]

TOUCHING = 1e-9  # of the domain's size
CONTACT_LENGTH = 1e5  # curves of radius R touch over a length of sqrt(8 R tolerance), not in a point
GAP_OF_CHORDS = 0.02  # two curves that touch are nearer to each other's chords than this part of the chords' lengths
MOST_SPLITS = 4  # of two rings: both at two points. Such rings bound no domain, least of all if a curve is common


class Contact(NamedTuple):
    """Point (2,) at arc length ``s`` of ``piece`` where the two ``rings`` touch."""

    piece: int
    s: float
    point: Floats
    rings: frozenset[int]


def joined(boundary: Boundary) -> Boundary:
    """The boundary with a corner wherever a ring touches another one between its corners."""
    tolerance = TOUCHING * float(np.ptp(boundary.polyline().points, axis=0).max())
    splits: Counter[frozenset[int]] = Counter()
    while (contact := _contact(boundary, tolerance, splits)) is not None:
        boundary = boundary.split(contact.piece, contact.s, contact.point)
        splits[contact.rings] += 1
    return boundary


def _contact(boundary: Boundary, tolerance: float, splits: Counter[frozenset[int]]) -> Contact | None:
    """A contact that is not yet a corner of its piece, between rings that have not been split too often."""
    line = boundary.polyline()
    for probe, chord in _neighbours(line, tolerance):
        rings = frozenset([int(line.ring[probe]), int(line.ring[chord])])
        if splits[rings] == MOST_SPLITS:
            continue
        piece = int(line.piece[chord])
        point = _closest(boundary, line, probe, chord)
        s, foot = _foot(boundary, line, chord, point)
        at_end = not boundary.closed[piece] and min(s, boundary.lengths[piece] - s) <= CONTACT_LENGTH * tolerance
        if np.hypot(*(point - foot)) <= tolerance and not at_end:
            return Contact(piece, s, point, rings)
    return None


def _neighbours(line: Polyline, tolerance: float) -> list[tuple[int, int]]:
    """Points of the polyline, and chords of other rings so near that their curves may touch."""
    points, ends = shapely.points(line.points), line.points[line.successor]
    chords = shapely.linestrings(np.stack([line.points, ends], axis=1))
    length = np.hypot(*(ends - line.points).T)
    curved = np.bincount(line.piece)[line.piece] > 1
    reach = np.maximum(tolerance, GAP_OF_CHORDS * length * curved)
    probe, chord = shapely.STRtree(chords).query(points, predicate="dwithin", distance=reach.max())
    near = shapely.distance(points[probe], chords[chord]) <= np.maximum(reach[probe], reach[chord])
    other = line.ring[probe] != line.ring[chord]
    return list(zip(probe[near & other].tolist(), chord[near & other].tolist(), strict=True))


def _closest(boundary: Boundary, line: Polyline, probe: int, chord: int) -> Floats:
    """The point next to ``probe`` on its own piece that is nearest to the curve of ``chord``."""
    piece, s, step = line.piece[probe], line.s[probe], line.step[probe]
    if boundary.start[piece] >= 0 and s == 0:
        return line.points[probe]

    def point(at: float) -> Floats:
        return boundary.points(np.array([piece]), np.array([at % boundary.lengths[piece]]))[0]

    def gap(at: float) -> float:
        return float(np.hypot(*(point(at) - _foot(boundary, line, chord, point(at))[1])))

    return point(minimize_scalar(gap, bounds=(s - step, s + step), method="bounded", options={"xatol": 0.0}).x)


def _foot(boundary: Boundary, line: Polyline, chord: int, point: Floats) -> tuple[float, Floats]:
    """Arc length and place of the point nearest to ``point`` on the curve of ``chord``."""
    piece = np.array([line.piece[chord]])
    a, b = line.points[chord], line.points[line.successor[chord]]
    s = line.s[chord : chord + 1] + np.clip((point - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1) * line.step[chord]
    for _ in range(4):  # the curves are next to each other
        ahead = (point - boundary.points(piece, s)) * boundary.tangents(piece, s)
        s = boundary.wrapped(piece, s + ahead.sum())
    return float(s[0]), boundary.points(piece, s)[0]
