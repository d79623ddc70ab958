"""Rings that touch in a point: the point becomes a corner of both, so that the mesh has one node there."""

import numpy as np
import shapely
from scipy.optimize import minimize_scalar

from bubblemesh.arrays import Floats
from bubblemesh.geometry.boundary import Boundary, Polyline

__all__ = ["joined"]

TOUCHING = 1e-9  # of the domain's size
CONTACT_LENGTH = 1e5  # curves of radius R touch over a length of sqrt(8 R tolerance), not in a point
GAP_OF_CHORDS = 0.02  # two curves that touch are nearer to each other's chords than this part of the chords' lengths


def joined(boundary: Boundary) -> Boundary:
    """The boundary with a corner wherever a ring touches another one between its corners."""
    tolerance = TOUCHING * float(np.ptp(boundary.polyline().points, axis=0).max())
    while (contact := _contact(boundary, tolerance)) is not None:
        boundary = boundary.split(*contact)
    return boundary


def _contact(boundary: Boundary, tolerance: float) -> tuple[int, float, Floats] | None:
    """Piece, arc length and point (2,) of a contact that is not yet a corner of its piece."""
    line = boundary.polyline()
    for probe, chord in _neighbours(line, tolerance):
        piece = int(line.piece[chord])
        point = _closest(boundary, line, probe, chord)
        s, foot = _foot(boundary, line, chord, point)
        at_end = not boundary.closed[piece] and min(s, boundary.lengths[piece] - s) <= CONTACT_LENGTH * tolerance
        if np.hypot(*(point - foot)) <= tolerance and not at_end:
            return piece, s, point
    return None


def _neighbours(line: Polyline, tolerance: float) -> list[tuple[int, int]]:
    """Points of the polyline, and chords of other rings so near that their curves may touch."""
    ends = line.points[line.successor]
    chords = shapely.linestrings(np.stack([line.points, ends], axis=1))
    tree = shapely.STRtree(chords)
    length = np.hypot(*(ends - line.points).T)
    curved = np.bincount(line.piece)[line.piece] > 1
    reach = np.maximum(tolerance, GAP_OF_CHORDS * length * curved)
    probe, chord = tree.query(shapely.points(line.points), predicate="dwithin", distance=reach)
    other = line.ring[probe] != line.ring[chord]
    return list(zip(probe[other].tolist(), chord[other].tolist(), strict=True))


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
    for _ in range(8):
        ahead = (point - boundary.points(piece, s)) * boundary.tangents(piece, s)
        s = boundary.wrapped(piece, s + ahead.sum())
    return float(s[0]), boundary.points(piece, s)[0]
