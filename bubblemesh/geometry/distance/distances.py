"""Distances from lines, arcs and points; from few of them by formulas."""

from collections.abc import Sequence
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.curves import Arcs, Lines
from bubblemesh.geometry.distance.chord_runs import ChordRuns
from bubblemesh.geometry.distance.nearest_chord import nearest_chord
from bubblemesh.records import record

MOST_FORMULAS = 16  # lines and arcs; for more, a search for the nearest one is faster
POINTS_AT_A_TIME = 1 << 14  # points, so that the arrays stay in the processor's caches
ANYWHERE = -2.0  # below the cosine of any angle


class Distance(Protocol):
    """Distances (n,) of points (n, 2) from walls, points or lines."""

    @property
    def costly(self) -> bool:
        """True if a call takes much longer than a formula."""

    def __call__(self, points: Floats) -> Floats:
        """Distances (m,) of points (m, 2)."""


def distance_to_line(points: Sequence[tuple[float, float]]) -> Distance:
    """Distance from the straight lines between consecutive points; from the point itself if there is only one."""
    formula = ClosedForm.through(points)
    if formula is not None:
        return formula
    places = np.array(points, float)
    return FromChords(ChordRuns.of(places[:-1], places[1:]))


@record
class FromChords:
    """Distance from straight lines."""

    chords: ChordRuns

    costly = True

    def __call__(self, points: Floats) -> Floats:
        """Distances (m,) of points (m, 2)."""
        _, foot = self.chords.feet(points, nearest_chord(self.chords, points))
        return np.hypot(*(points - foot).T)


@record
class FromPoints:
    """Distance from the nearest of many points."""

    places: Floats  # (n, 2)

    costly = False

    @cached_property
    def _tree(self) -> Any:
        from scipy.spatial import cKDTree  # takes longer to load than to mesh a small case without it

        return cKDTree(self.places)

    def __call__(self, points: Floats) -> Floats:
        """Distances (m,) of points (m, 2)."""
        away = points - self.places[self._tree.query(points)[1]]
        return np.sqrt(away[:, 0] * away[:, 0] + away[:, 1] * away[:, 1])


@record
class ClosedForm:
    """Distance from the nearest of some lines and arcs."""

    start: Floats  # (n, 2), of each line
    end: Floats  # (n, 2), the same for a point
    center: Floats  # (m, 2), of each arc
    middle: Floats  # (m, 2), unit vector from the centre to the middle of the arc
    radius: Floats  # (m,)
    cosine: Floats  # (m,), of half the angle that the arc spans

    costly = False

    @classmethod
    def of(cls, boundary: Boundary, pieces: Integers, points: Sequence[Sequence[float]] = ()) -> "ClosedForm | None":
        """Distance from some pieces (p,) of a boundary and from points, if these are few, and no other curves."""
        kinds = [type(boundary.families[k]) for k in boundary.kind[pieces]]
        if len(kinds) + len(points) > MOST_FORMULAS or not set(kinds) <= {Lines, Arcs}:
            return None
        arcs = np.array([kind is Arcs for kind in kinds], bool)
        lines, rounds = pieces[~arcs], pieces[arcs]
        curves = ((boundary.families[boundary.kind[k]], boundary.index[k]) for k in rounds)
        circles = [(*family.center[k], family.radius[k]) for family, k in curves if isinstance(family, Arcs)]
        x, y, radius = np.array(circles).reshape(-1, 3).T
        center = np.column_stack([x, y])
        closed = boundary.closed[rounds]
        half = np.where(closed, 0, boundary.lengths[rounds] / 2)
        middle = (boundary.points(rounds, half) - center) / radius[:, None]
        # Outside of the angle that an arc spans, one of its ends is nearest.
        open_, places = rounds[~closed], np.array(points, float).reshape(-1, 2)
        ends = [boundary.corners[end[of]] for of in (lines, open_) for end in (boundary.start, boundary.end)]
        start, end = np.vstack([ends[0], ends[2], ends[3], places]), np.vstack([ends[1], ends[2], ends[3], places])
        return cls(start, end, center, middle, radius, np.where(closed, ANYWHERE, np.cos(half / radius)))

    @classmethod
    def through(cls, points: Sequence[tuple[float, float]]) -> "ClosedForm | None":
        """Distance from the straight lines between consecutive points, or from a single one, if these are few."""
        places = np.array(points, float)
        if len(places) > MOST_FORMULAS:
            return None
        end = places if len(places) == 1 else places[1:]
        return cls(places[: len(end)], end, np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0), np.zeros(0))

    def __call__(self, points: Floats) -> Floats:
        """Distances (k,) of points (k, 2)."""
        distance = np.empty(len(points))
        for begin in range(0, len(points), POINTS_AT_A_TIME):
            part = slice(begin, begin + POINTS_AT_A_TIME)
            distance[part] = self._from(*points[part].T)
        return distance

    def _from(self, x: Floats, y: Floats) -> Floats:
        """Distances (k,) of points at x, y (k,)."""
        squared = np.full(len(x), np.inf)
        for (ax, ay), (bx, by) in zip(self.start.tolist(), self.end.tolist(), strict=True):
            ux, uy, dx, dy = bx - ax, by - ay, x - ax, y - ay
            if ux or uy:
                along = np.clip((dx * ux + dy * uy) / (ux * ux + uy * uy), 0, 1)
                dx, dy = dx - along * ux, dy - along * uy
            squared = np.minimum(squared, dx * dx + dy * dy)
        arcs = (self.center.tolist(), self.middle.tolist(), self.radius.tolist(), self.cosine.tolist())
        for (cx, cy), (ux, uy), radius, cosine in zip(*arcs, strict=True):
            dx, dy = x - cx, y - cy
            away = np.sqrt(dx * dx + dy * dy)
            facing = dx * ux + dy * uy >= cosine * away
            squared = np.where(facing, np.minimum(squared, (away - radius) ** 2), squared)
        return np.sqrt(squared)
