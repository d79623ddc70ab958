"""Nearest points on curves, and distances from them: first the nearest chord, then the curve along it."""

from collections.abc import Collection
from functools import cached_property
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, concatenated, select, taken
from bubblemesh.geometry.boundary import Boundary, Chords
from bubblemesh.geometry.curves import turning
from bubblemesh.geometry.distance import bulges
from bubblemesh.geometry.distance.bulges import Bulges
from bubblemesh.geometry.distance.chord_runs import ChordRuns
from bubblemesh.geometry.distance.nearest_chord import distance_at_least, nearest_chord
from bubblemesh.kernels.bulges import bulge_distances
from bubblemesh.kernels.library import or_numpy
from bubblemesh.records import record

PROJECTION_STEPS = 8
REST = 1e-9  # of a piece's length: a shorter step changes the distance by its square
PROJECTED_AT_A_TIME = 1 << 13  # points, so that the arrays stay in the processor's caches


class Feet(NamedTuple):
    """Nearest points (m, 2) on curves, to about 1e-7 of their radius, and unit tangents (m, 2) there, 0 at points."""

    foot: Floats
    tangent: Floats


class Nearest(NamedTuple):
    """Nearest boundary points of m points: piece (m,), arc length (m,), the point (m, 2) and its distance (m,)."""

    piece: Integers
    s: Floats
    foot: Floats
    distance: Floats


@record
class Projection:
    """Projection of points onto pieces of a boundary, and onto points."""

    boundary: Boundary
    chords: Chords  # of the pieces; mere points have the piece -1

    def __call__(self, points: Floats) -> Nearest:
        """Nearest points of ``points`` (k, 2), on the true curves."""
        chord = nearest_chord(self._runs, points)
        share, foot = self._runs.feet(points, chord)
        piece, s = self.chords.piece[chord], self.chords.s[chord] + share * self.chords.step[chord]
        curved = np.flatnonzero(self._approximated[chord])
        for begin in range(0, len(curved), PROJECTED_AT_A_TIME):
            mine = curved[begin : begin + PROJECTED_AT_A_TIME]
            s[mine] = self._projected(points[mine], piece[mine], s[mine], self._curvature[chord[mine]])
            foot[mine] = self.boundary.points(piece[mine], s[mine])
        return Nearest(piece, s, foot, np.hypot(*(points - foot).T))

    def distances(self, points: Floats) -> Floats:
        """Distances (k,) of ``points`` (k, 2), on curves to about 1e-7 of their radius: quicker than the points."""
        return self._distances(points, nearest_chord(self._runs, points))

    def distances_beside_chords(self, points: Floats) -> tuple[Floats, Floats]:
        """Distances (k,) by `distances`, and bounds (k,) for the distance of the curve from the nearest chord."""
        chord = nearest_chord(self._runs, points)
        return self._distances(points, chord), self._bellies[chord]

    def _distances(self, points: Floats, chord: Integers) -> Floats:
        """Distances (k,) of points (k, 2) from the curves along the nearest chords (k,)."""
        curved = self._approximated[chord]
        if len(points) and curved.all():
            return self._from_curves(points, self._bulge[chord])
        distance = np.empty(len(points))
        if curved.any():
            mine = taken(points, curved)
            distance[curved] = self._from_curves(mine, self._bulge[chord[curved]])
        mine = taken(points, ~curved)
        _, foot = self._runs.feet(mine, chord[~curved])
        distance[~curved] = np.hypot(*(mine - foot).T)
        return distance

    def _from_curves_in_numpy(self, points: Floats, of: Integers) -> Floats:
        """The same as `_from_curves`, in NumPy."""
        return self._bulges.distances(points, of)

    @or_numpy(_from_curves_in_numpy)
    def _from_curves(self, points: Floats, of: Integers) -> Floats:
        """Distances (k,) of points (k, 2) from some of the curves (k,), which they are nearest to."""
        return bulge_distances(self._cubics, points, of, bulges.STEPS, bulges.LEAST_SLOPE)

    def feet(self, points: Floats) -> Feet:
        """Nearest points of ``points`` (k, 2), and how the curves run there: much quicker than with arc lengths."""
        chord = nearest_chord(self._runs, points)
        _, foot = self._runs.feet(points, chord)
        way = self.chords.end[chord] - self.chords.start[chord]
        length = np.hypot(*way.T)[:, None]
        tangent = way / np.where(length > 0, length, 1)
        curved = np.flatnonzero(self._approximated[chord])
        if len(curved):
            foot[curved], tangent[curved] = self._bulges.feet(points[curved], self._bulge[chord[curved]])
        return Feet(foot, tangent)

    def at_least(self, points: Floats) -> Floats:
        """Lower bounds (k,) of the distances of ``points`` (k, 2), much quicker than these; 0 next to the curves."""
        return np.maximum(distance_at_least(self._runs, points) - self._belly, 0)

    @property
    def _belly(self) -> float:
        """Bound for the distance of any curve from its chords."""
        return float(self._bellies.max())

    @cached_property
    def _bellies(self) -> Floats:
        """Bounds (m,) for the distance of the curve along each chord from it."""
        return np.abs(self._curvature) * self.chords.step**2 / 4

    @cached_property
    def _runs(self) -> ChordRuns:
        return ChordRuns.of(self.chords.start, self.chords.end)

    @cached_property
    def _approximated(self) -> Booleans:
        """Mask (m,) of the chords that are not the curve itself."""
        return (self.chords.piece >= 0) & self.boundary.approximated[self.chords.piece]

    @cached_property
    def _curved(self) -> Integers:
        """Numbers (c,) of these chords."""
        return np.flatnonzero(self._approximated)

    @cached_property
    def _bulge(self) -> Integers:
        """Place (m,) of each chord among these, if it is one."""
        return np.cumsum(self._approximated) - 1

    @cached_property
    def _tangents(self) -> tuple[Floats, Floats]:
        """Unit tangents (c, 2) of the curves where these chords begin, and where they end."""
        piece, s, step = self.chords.piece[self._curved], self.chords.s[self._curved], self.chords.step[self._curved]
        return self.boundary.tangents(piece, s), self.boundary.tangents(piece, s + step)

    @cached_property
    def _bulges(self) -> Bulges:
        chords, closed = select(self.chords, self._curved), self.boundary.closed
        first = np.diff(chords.piece, prepend=-1) != 0
        last = np.diff(chords.piece, append=-1) != 0
        ends = ~closed[chords.piece]
        return Bulges.of(chords.start, chords.end, *self._tangents, first & ends, last & ends)

    @cached_property
    def _cubics(self) -> Floats:
        """Rows (c, 9) of the bulges."""
        return self._bulges.rows

    @cached_property
    def _curvature(self) -> Floats:
        """Mean curvature (m,) of the curve along each chord, positive where it turns left."""
        curvature = np.zeros(len(self.chords.piece))
        curvature[self._curved] = turning(*self._tangents) / self.chords.step[self._curved]
        return curvature

    def _projected(self, points: Floats, piece: Integers, s: Floats, curvature: Floats) -> Floats:
        """Arc length (k,) of the nearest point on each curve, from a start close to it.

        Newton's method for a foot where the tangent is square to the way to the point. Without the curvature the
        steps would diverge for a point farther from a convex curve than its radius.
        """
        s, moving = s.copy(), np.arange(len(s))  # most come to rest before the last step
        for _ in range(PROJECTION_STEPS):
            if len(moving) == 0:
                break
            mine, before = piece[moving], s[moving]
            tracks = self.boundary.tracks(mine)
            here, tangents = tracks.places(before)
            (rx, ry), (tx, ty) = (points[moving] - here).T, tangents.T
            slope = 1 - curvature[moving] * (tx * ry - ty * rx)
            step = (rx * tx + ry * ty) / np.maximum(slope, bulges.LEAST_SLOPE)
            s[moving] = tracks.wrapped(before + step)
            moving = moving[np.abs(s[moving] - before) > REST * tracks.length]
        return s


def projection_onto(boundary: Boundary, labels: Collection[str], points: Floats) -> Projection:
    """Projection onto all sides and lines that have one of the labels, and onto points (k, 2)."""
    chords = boundary.chords()
    named = np.flatnonzero(np.isin(boundary.labels, list(labels))[boundary.label[chords.piece]])
    none, nowhere = np.full(len(points), -1), np.zeros(len(points))
    places = Chords(none, nowhere, nowhere, points, points)
    return Projection(boundary, concatenated([select(chords, named), places]))
