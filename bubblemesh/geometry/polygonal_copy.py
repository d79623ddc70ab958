"""Fine polygonal copies of boundaries, whose chords keep apart where curves touch."""

from collections.abc import Sequence

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers, each_once
from bubblemesh.geometry.boundary import Boundary, Chords
from bubblemesh.geometry.paths import Line, Ring
from bubblemesh.records import record

CONTACT_GRADING = 0.8  # of chords beside a contact, from four of the longest
CONTACT_FINEST = 0.02  # down to this part of the shortest, where the curves are a tolerance apart
CONTACT_CHORDS = 2 * 256 / np.pi  # curves part by the square of the distance, divided by that many chords or less
CONTACT_ROUNDINGS = 16
MOST_GRADED = 100
CUSP = 0.01  # radians, about four times the turn of a quarter of a chord


@record
class PolygonalCopy:
    """Fine polygonal copy of the boundary, whose chords go from each point to its successor along the point's piece."""

    points: Floats  # (m, 2)
    piece: Integers  # (m,)
    s: Floats  # (m,), arc length of each point on its piece
    step: Floats  # (m,), arc length of the chord that starts there
    successor: Integers  # (m,), index of the next point of the same ring
    ring: Integers  # (m,)
    area_of_ring: tuple[int, ...]  # number of the area that each ring bounds; outer rings come first

    @classmethod
    def of(cls, boundary: Boundary) -> "PolygonalCopy":
        """The rings as chords, about 256 for a full turn, one for a straight line."""
        piece, s, step = boundary.stations()
        more_piece, more_s = _graded_to_contacts(boundary)
        if len(more_piece):
            piece, s, step = boundary.in_order(np.append(piece, more_piece), np.append(s, more_s))
        mine = ~boundary.inner[piece]
        piece, s, step = piece[mine], s[mine], step[mine]
        points = boundary.chord_starts(piece, s)
        ring = boundary.ring[piece]
        successor = np.arange(1, len(piece) + 1)
        ends = np.flatnonzero(np.diff(ring, append=-1))
        successor[ends] = np.concatenate([[0], ends[:-1] + 1])
        return cls(points, piece, s, step, successor, ring, boundary.area_of_ring)

    def rings(self) -> list[Floats]:
        """Points (k, 2) of each ring, outer ones first."""
        order = np.argsort(self.ring, kind="stable")
        return np.split(self.points[order], np.cumsum(np.bincount(self.ring))[:-1])

    def polygon(self) -> shapely.Polygon | shapely.MultiPolygon:
        """The domain that the rings bound, as several polygons if it has several areas."""
        rings_of: dict[int, list[Floats]] = {}
        for points, area in zip(self.rings(), self.area_of_ring, strict=True):
            rings_of.setdefault(area, []).append(points)
        polygons = [shapely.Polygon(outer, holes) for outer, *holes in rings_of.values()]
        polygon = polygons[0] if len(polygons) == 1 else shapely.MultiPolygon(polygons)
        shapely.prepare(polygon)
        return polygon

    @property
    def chords(self) -> Chords:
        """Chord from each point to its successor."""
        return Chords(self.piece, self.s, self.step, self.points, self.points[self.successor])


def outlines_of(rings: Sequence[Ring]) -> list[Floats]:
    """Polygonal copies (m, 2) of rings, each as it is without the others but for rounding."""
    curved = [k for k, ring in enumerate(rings) if not all(isinstance(side.curve, Line) for side in ring.sides)]
    found = [np.array(ring.vertices, float) for ring in rings]
    if not curved:
        return found
    boundary = Boundary.of([rings[k] for k in curved])
    piece, s, _ = boundary.stations()
    ends = np.flatnonzero(np.diff(boundary.ring[piece])) + 1
    for k, points in zip(curved, np.split(boundary.chord_starts(piece, s), ends), strict=True):
        found[k] = points
    for k in each_once(boundary.ring[_at_contacts(boundary).any(axis=0)]).tolist():
        found[curved[k]] = PolygonalCopy.of(Boundary.of([rings[curved[k]]])).points
    return found


def _graded_to_contacts(boundary: Boundary) -> tuple[Integers, Floats]:
    """Piece and arc length of more points beside corners that join two rings, and beside cusps.

    Two curves may touch there with a common tangent: only chords that shrink towards the contact keep apart.
    """
    none = np.zeros(0, np.int64), np.zeros(0)
    forward, backward = map(np.flatnonzero, _at_contacts(boundary))
    if len(forward) + len(backward) == 0:
        return none
    # Equal lengths on both curves: the sharper curve's chords then turn away faster.
    first, last = boundary.end_steps()
    beside = np.concatenate([first[forward], last[backward]])
    # Far from the origin the curves must part by more than their points are rounded.
    rounding = CONTACT_ROUNDINGS * np.spacing(np.abs(boundary.corners).max())
    finest = max(CONTACT_FINEST * beside.min(), float(np.sqrt(CONTACT_CHORDS * beside.min() * rounding)))
    levels = np.ceil(np.log(4 * beside.max() / finest) / -np.log(CONTACT_GRADING))
    s = 4 * beside.max() * 0.999 * CONTACT_GRADING ** np.arange(1, min(levels, MOST_GRADED) + 1)
    ends = [(forward, np.tile(s, (len(forward), 1))), (backward, boundary.lengths[backward, None] - s)]
    pieces = np.concatenate([np.repeat(k, len(s)) for k, _ in ends])
    along = np.concatenate([at.ravel() for _, at in ends])
    within = (along > 0) & (along < boundary.lengths[pieces])
    return pieces[within], along[within]


def _at_contacts(boundary: Boundary) -> Booleans:
    """Whether pieces of rings that are curved start, and whether they end, at a contact (2, p)."""
    curved = boundary.approximated & ~boundary.inner
    if not curved.any():
        return np.zeros((2, len(curved)), bool)
    rings_at = np.bincount(boundary.ring_corners()[0], minlength=len(boundary.corners))
    contact = np.append((rings_at > 1) | _cusps(boundary), False)  # the last entry answers for start = -1
    return contact[np.stack([boundary.start, boundary.end])] & curved


def _cusps(boundary: Boundary) -> Booleans:
    """Corners (k,) of the rings at which a piece goes back along the one that ends there, or nearly so."""
    open_ = np.flatnonzero(~boundary.closed & ~boundary.inner)
    ahead = np.full((len(boundary.corners), 2), np.nan)
    ahead[boundary.start[open_]] = boundary.tangents(open_, np.zeros(len(open_)))
    behind = ahead[boundary.end[open_]] + boundary.tangents(open_, boundary.lengths[open_])
    cusps = np.zeros(len(boundary.corners), bool)
    cusps[boundary.end[open_][np.hypot(*behind.T) < CUSP]] = True
    return cusps
