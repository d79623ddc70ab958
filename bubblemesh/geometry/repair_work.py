"""The rings that a repair begins with, and what it changes."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray

from bubblemesh.arrays import Floats, Integers
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.paths import Area, Line, Point, Polyline, Ring, RingChange, Side, as_point
from bubblemesh.geometry.polygonal_copy import PolygonalCopy


@dataclass
class Work:
    """The rings that a repair begins with, and the changes so far."""

    rings: tuple[Ring, ...]
    changes: list[RingChange] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def told(self, areas: Sequence[Area]) -> list[Area]:
        """The areas, the first of which has the changes and the notes."""
        first, *others = areas
        notes = tuple(dict.fromkeys([*(note for ring in self.rings for note in ring.notes), *self.notes]))
        changes = (*(change for ring in self.rings for change in ring.changes), *self.changes)
        return [replace(first, outer=replace(first.outer, notes=notes, changes=changes)), *others]

    @cached_property
    def outlines(self) -> list[Floats]:
        return [ring.outline for ring in self.rings]

    @cached_property
    def size(self) -> float:
        """The longer side of the box around all rings."""
        return float(np.ptp(np.concatenate(self.outlines), axis=0).max())

    def note(self, what: str, at: Floats, area: float, before: Iterable[Floats]) -> None:
        """Note a change of the area, and the lines (k, 2) as they were before."""
        self.changes.append(RingChange(what, as_point(at), float(area), tuple(before)))

    def area(self, shape: shapely.Polygon, name: str | None) -> Area:
        """The area that a polygon bounds."""
        outer, *holes = (self._ring(shapely.get_coordinates(loop)[:-1]) for loop in (shape.exterior, *shape.interiors))
        return Area(outer, tuple(holes), name)

    def _ring(self, points: Floats) -> Ring:
        """The ring along points (n, 2): one of those at the begin, if it has the same ones."""
        known = self._known.get(_fingerprint(points))
        if known is not None:
            return replace(known, notes=(), changes=())
        ahead = np.roll(points, -1, axis=0)
        near = self._chords.nearest(shapely.points((points + ahead) / 2))
        side, (number, _) = self._sides[near], self._numbers[near].T
        owner = self.rings[np.bincount(number).argmax()]
        curved = np.array([not isinstance(one.curve, Line) for one in side])
        corners = [as_point(point) for point in points]
        kept = np.array([corner in self.vertices for corner in corners])
        # Nodes may slide where one curve goes on, through a vertex of its copy; a cut leaves a corner.
        on = curved & np.roll(curved, 1) & (self._numbers[near] == self._numbers[np.roll(near, 1)]).all(axis=1) & kept
        if on.all():
            closed = Polyline(np.vstack([points, points[:1]]))
            return Ring((Side(closed, side[0].label),), (), origin=owner.origin, key=owner.key)
        stops = np.flatnonzero(~on).tolist()
        runs = [[k % len(points) for k in range(a, b + 1)] for a, b in pairwise([*stops, stops[0] + len(points)])]
        sides = tuple(Side(_along(points[run]), side[run[0]].label) for run in runs)
        return Ring(sides, tuple(corners[run[0]] for run in runs), origin=owner.origin, key=owner.key)

    def labels(self, points: Floats) -> list[str | None]:
        """Labels (n,) of the sides of the ring along points (n, 2)."""
        ahead = np.roll(points, -1, axis=0)
        near = self._chords.nearest(shapely.points((points + ahead) / 2))
        return [self._sides[k].label for k in near.tolist()]

    def is_curved(self, points: Floats) -> bool:
        """Whether the ring along points (n, 2) is one of those at the begin and has curves."""
        known = self._known.get(_fingerprint(points))
        return known is not None and not all(isinstance(side.curve, Line) for side in known.sides)

    @cached_property
    def _known(self) -> dict[bytes, Ring]:
        return {_fingerprint(points): ring for points, ring in zip(self.outlines, self.rings, strict=True)}

    @cached_property
    def vertices(self) -> set[Point]:
        return {as_point(point) for points in self.outlines for point in points}

    @cached_property
    def _copies(self) -> list[tuple[Floats, Integers]]:
        """Points (m, 2) of the polygonal copy of each ring, and the side (m,) of the chord that starts there."""
        return [_copy(ring) for ring in self.rings]

    @cached_property
    def _chords(self) -> shapely.STRtree:
        """The chords of all rings, in order."""
        chords = [np.stack([points, np.roll(points, -1, axis=0)], axis=1) for points, _ in self._copies]
        return shapely.STRtree(shapely.linestrings(np.concatenate(chords)))

    @cached_property
    def _numbers(self) -> Integers:
        """Numbers (c, 2) of the ring and its side of each of these chords."""
        owner = np.repeat(np.arange(len(self._copies)), [len(side) for _, side in self._copies])
        return np.column_stack([owner, np.concatenate([side for _, side in self._copies])])

    @cached_property
    def _sides(self) -> NDArray[np.object_]:
        """Sides (c,) of these chords."""
        found = np.empty(len(self._numbers), dtype=object)
        found[:] = [self.rings[ring].sides[side] for ring, side in self._numbers.tolist()]
        return found


def _copy(ring: Ring) -> tuple[Floats, Integers]:
    if all(isinstance(side.curve, Line) for side in ring.sides):  # a boundary of each of thousands takes long
        return np.array(ring.vertices, float), np.arange(len(ring.vertices))
    copy = PolygonalCopy.of(Boundary.of([ring]))
    return copy.points, copy.piece


def _along(points: Floats) -> Line | Polyline:
    """The straight line between two points, or the polyline along more (k, 2)."""
    return Polyline(points) if len(points) > 2 else Line(as_point(points[0]), as_point(points[1]))


def _fingerprint(points: Floats) -> bytes:
    """Bytes that are the same for rings with the same points (n, 2), wherever they start."""
    return np.ascontiguousarray(points[np.lexsort(points.T)] + 0.0).tobytes()


def outer_points(polygon: shapely.Polygon) -> Floats:
    """Points (n, 2) of the outer ring of a polygon, each once."""
    points: Floats = shapely.get_coordinates(polygon.exterior)[:-1]
    return points
