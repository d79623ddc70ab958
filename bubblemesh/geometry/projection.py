"""Nearest points on curves: the nearest chord, then Newton's method on the curve that it follows."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.chord_runs import ChordRuns
from bubblemesh.geometry.curves import turning
from bubblemesh.geometry.nearest_chord import nearest_chord

__all__ = ["Nearest", "Projection"]

STEPS = 8
AT_A_TIME = 1 << 13  # points, so that the arrays stay in the processor's caches
FLATTEST = 0.05  # least slope in a projection: towards the centre of curvature it vanishes


class Nearest(NamedTuple):
    """Nearest boundary points of m points: piece (m,), arc length (m,), the point (m, 2) and its distance (m,)."""

    piece: Integers
    s: Floats
    foot: Floats
    distance: Floats


@dataclass(frozen=True)
class Projection:
    """Projection of points onto pieces of a boundary.

    Attributes
    ----------
    boundary : Boundary
    piece, s, step : (m,)
        Piece, arc length and its step of the chords that follow the pieces.
    start, end : (m, 2)
        Ends of these chords.
    """

    boundary: Boundary
    piece: Integers
    s: Floats
    step: Floats
    start: Floats
    end: Floats

    def __call__(self, points: Floats) -> Nearest:
        """Nearest points of ``points`` (k, 2), on the true curves."""
        boundary = self.boundary
        chord = nearest_chord(self._runs, points)
        share, foot = self._runs.feet(points, chord)
        piece, s = self.piece[chord], self.s[chord] + share * self.step[chord]
        curved = np.flatnonzero(boundary.approximated[piece])
        for begin in range(0, len(curved), AT_A_TIME):
            mine = curved[begin : begin + AT_A_TIME]
            s[mine] = self._projected(points[mine], piece[mine], s[mine], self._curvature[chord[mine]])
            foot[mine] = boundary.points(piece[mine], s[mine])
        return Nearest(piece, s, foot, np.hypot(*(points - foot).T))

    @cached_property
    def _runs(self) -> ChordRuns:
        return ChordRuns.of(self.start, self.end)

    @cached_property
    def _curvature(self) -> Floats:
        """Mean curvature (m,) of the curve along each chord, positive where it turns left."""
        tangents = self.boundary.tangents
        return turning(tangents(self.piece, self.s), tangents(self.piece, self.s + self.step)) / self.step

    def _projected(self, points: Floats, piece: Integers, s: Floats, curvature: Floats) -> Floats:
        """Arc length (k,) of the nearest point on each curve, from a start close to it.

        Newton's method for a foot where the tangent is square to the way to the point. Without the curvature the
        steps would diverge for a point farther from a convex curve than its radius.
        """
        s, moving = s.copy(), np.arange(len(s))  # most come to rest before the last step
        for _ in range(STEPS):
            mine, before = piece[moving], s[moving]
            here, (tx, ty) = self.boundary.points(mine, before), self.boundary.tangents(mine, before).T
            rx, ry = (points[moving] - here).T
            slope = 1 - curvature[moving] * (tx * ry - ty * rx)
            s[moving] = self.boundary.wrapped(mine, before + (rx * tx + ry * ty) / np.maximum(slope, FLATTEST))
            moving = moving[s[moving] != before]
        return s
