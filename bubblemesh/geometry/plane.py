"""The local plane of coordinates on the earth; sizes in it are metres on the ground.

The plane is that of a stereographic projection about the middle of the domain, after one to a sphere. It keeps angles:
lengths in it are those on the ground times a factor that depends on the place only, and is known in closed form.

References
----------
J. P. Snyder, "Map Projections: A Working Manual", U.S. Geological Survey Professional Paper 1395 (1987), chapter 21.
"""

import math
from dataclasses import replace
from functools import cached_property

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import CaseError
from bubblemesh.geometry.paths import Line, Point, Polyline, Ring, Side, as_point
from bubblemesh.geometry.systems import DEGREES, HALF_TURN, WIDEST, known_system, require_degrees, transformed
from bubblemesh.records import record

LARGEST_SCALE = 1.05  # lengths in the plane in terms of those on the ground
BENT = 0.002  # of its length: a straight side in degrees that departs more from a line in the plane becomes a polyline
PIECES = 1000  # of one side, at most
STEP_IN_DEGREES, STEP_IN_METRES = 1e-5, 1.0  # by which directions are found
DIGITS = 2  # of the middle of the plane, in degrees


@record
class Plane:
    """A plane about a place on the earth, in metres, for coordinates read in one system and written in another."""

    source: str  # system of the given coordinates
    target: str | None  # system of the written coordinates; None for the plane
    middle: Point  # longitude and latitude

    @classmethod
    def about(cls, source: str, target: str | None, points: Floats) -> "Plane":
        """The plane about the middle of points (n, 2), or about (0, 0) if that is no place: then `to` tells a point."""
        low, high = points.min(axis=0), points.max(axis=0)
        middle = transformed(source, DEGREES, (low + high)[None] / 2)[0]
        return cls(source, target, as_point(np.round(middle, DIGITS) if np.isfinite(middle).all() else np.zeros(2)))

    @cached_property
    def definition(self) -> str:
        """The system of the plane, as PROJ writes it."""
        return "+proj=sterea +lat_0={1:g} +lon_0={0:g} +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m +no_defs".format(
            *self.middle
        )

    @cached_property
    def radius(self) -> float:
        """Radius of the sphere that is the earth near the middle, in metres."""
        ellipsoid = known_system(DEGREES).ellipsoid
        a, b = ellipsoid.semi_major_metre, ellipsoid.semi_minor_metre
        e2 = 1 - (b / a) ** 2
        return float(a * math.sqrt(1 - e2) / (1 - e2 * math.sin(math.radians(self.middle[1])) ** 2))

    def to(self, points: Floats) -> Floats:
        """Places (n, 2) in the plane of given points (n, 2); CaseError if one is too far away, or not a place."""
        if len(points) == 0:
            return points
        if known_system(self.source).is_geographic:
            require_degrees(points)
        found = transformed(self.source, self.definition, points)
        bad = ~np.isfinite(found).all(axis=1)
        if bad.any():
            x, y = points[bad][0].tolist()
            raise CaseError(f"({x:g}, {y:g}) is no place of {self.source}: correct it, or crs.from")
        if self.scale(*found.T).max() > LARGEST_SCALE:
            x, y = points[np.argmax(np.hypot(*found.T))].tolist()
            raise CaseError(
                f"({x:g}, {y:g}) is {np.hypot(*found.T).max() / 1000:,.0f} km from the middle of the domain "
                f"{self.middle}: what is as large does not fit into one plane: choose a part of it"
            )
        return found

    def near(self, points: Floats) -> Floats:
        """Places (m, 2) of the given points (n, 2) that the plane reaches; the others are left out without an error."""
        if len(points) == 0:
            return points
        found = transformed(self.source, self.definition, points)
        return found[np.isfinite(found).all(axis=1)]

    def given(self, points: Floats) -> Floats:
        """Coordinates (n, 2) in the given system of places (n, 2) in the plane."""
        return self._continuous(self.source, transformed(self.definition, self.source, points))

    def given_place(self, point: Point) -> Point:
        """Coordinates in the given system of one place in the plane."""
        return as_point(self.given(np.array([point], float))[0])

    def written(self, points: Floats) -> Floats:
        """Coordinates (n, 2) in the written system of places (n, 2) in the plane."""
        if self.target is None:
            return points
        return self._continuous(self.target, transformed(self.definition, self.target, points))

    @property
    def writes_degrees(self) -> bool:
        """Whether the written coordinates are longitudes and latitudes."""
        return self.target is not None and bool(known_system(self.target).is_geographic)

    def _continuous(self, system: str, points: Floats) -> Floats:
        """Points (n, 2) in a system, whose longitudes go on across the date line."""
        if not known_system(system).is_geographic or abs(self.middle[0]) + WIDEST / 2 < HALF_TURN:
            return points
        turns = np.round((points[:, :1] - self.middle[0]) / (2 * HALF_TURN))
        return points - turns * [2 * HALF_TURN, 0.0]

    def first_axis(self, points: Floats) -> Floats:
        """Unit vectors (n, 2) in the plane, at places (n, 2), along the first axis of the given coordinates."""
        given = self.given(points)
        step = STEP_IN_DEGREES if known_system(self.source).is_geographic else STEP_IN_METRES
        along = transformed(self.source, self.definition, given + np.array([step, 0.0])) - points
        return along / np.hypot(*along.T)[:, None]

    def scale(self, x: Floats, y: Floats) -> Floats:
        """Length in the plane of a metre on the ground (n,) at x (n,) and y (n,)."""
        return 1 + (x**2 + y**2) / (2 * self.radius) ** 2

    def ring(self, ring: Ring) -> Ring:
        """A ring of straight sides, in the plane; long ones are polylines where they are not straight there.

        CaseError if a side is curved.
        """
        if not ring.sides or not all(isinstance(side.curve, Line) for side in ring.sides):
            raise CaseError("crs: a side is a curve, which cannot be projected: give straight sides")
        around, pieces = self._along(np.array([*ring.vertices, ring.vertices[0]], float))
        first = np.cumsum([0, *pieces])
        vertices = list(map(as_point, around[first[:-1]]))
        curves: list[Line | Polyline] = list(map(Line, vertices, [*vertices[1:], vertices[0]]))
        for k in np.flatnonzero(np.array(pieces) > 1).tolist():
            curves[k] = Polyline(around[first[k] : first[k + 1] + 1])
        labels = [side.label for side in ring.sides]
        return replace(ring, sides=tuple(map(Side, curves, labels)), vertices=tuple(vertices), given=None)

    def line(self, points: Floats) -> tuple[Floats, Integers]:
        """Points (m, 2) in the plane of a line by given points (n, 2), with more of them on long parts.

        And the given side (m - 1,) that each of its sides is a part of.
        """
        places, pieces = self._along(points)
        return places, np.repeat(np.arange(len(pieces)), pieces)

    def _along(self, given: Floats) -> tuple[Floats, list[int]]:
        """Places (m, 2) in the plane of points (n, 2) of a line and of those that cut its sides, and their pieces."""
        ends, middle = self.to(given), self.to((given[:-1] + given[1:]) / 2)
        first, last = ends[:-1], ends[1:]
        length = np.hypot(*(last - first).T)
        off = np.hypot(*(middle - (first + last) / 2).T)
        share = np.divide(off, length, out=np.zeros(len(off)), where=length > 0)
        pieces = np.clip(np.ceil(share / BENT), 1, PIECES).astype(np.int64)
        side = np.repeat(np.arange(len(pieces)), pieces)
        number = np.arange(len(side)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
        t = (number / pieces[side])[:, None]
        places = first[side]
        within = number > 0
        places[within] = self.to((1 - t[within]) * given[:-1][side[within]] + t[within] * given[1:][side[within]])
        return np.vstack([places, ends[-1:]]), pieces.tolist()
