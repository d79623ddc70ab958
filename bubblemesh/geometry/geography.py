"""Projection of coordinates on the earth to a local plane, and back; sizes in the plane are metres on the ground.

The plane is that of a stereographic projection about the middle of the domain, after one to a sphere. It keeps angles:
lengths in it are those on the ground times a factor that depends on the place only, and is known in closed form.

References
----------
J. P. Snyder, "Map Projections: A Working Manual", U.S. Geological Survey Professional Paper 1395 (1987), chapter 21.
"""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import replace
from functools import cache, cached_property
from typing import Any

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.errors import CaseError, FileError
from bubblemesh.geometry.arrangement import ROUNDINGS, TOUCHING
from bubblemesh.geometry.contacts_as_given import NO_CONTACTS, contacts_between
from bubblemesh.geometry.paths import Area, Line, Point, Polyline, Ring, Side, as_point, outlines
from bubblemesh.records import record

DEGREES = "EPSG:4326"
NEAREST_POLE = 89.0  # degrees of latitude
WIDEST = 180.0  # degrees of longitude
HALF_TURN = 180.0
LARGEST_PLACE = 1e9  # coordinates of any system, degrees, metres or feet: larger ones are no place on the earth
FARTHEST = 2 * HALF_TURN, 90.0  # degrees of longitude and latitude; maps across the date line go on beyond 180
LARGEST_SCALE = 1.05  # lengths in the plane in terms of those on the ground
BENT = 0.002  # of its length: a straight side in degrees that departs more from a line in the plane becomes a polyline
PIECES = 1000  # of one side, at most
STEP_IN_DEGREES, STEP_IN_METRES = 1e-5, 1.0  # by which directions are found
SAME_PLACE = 5.0  # metres, by which WGS 84, ETRS89 and NAD83 differ at most
DIGITS = 2  # of the middle of the plane, in degrees


def crs_library() -> Any:
    """The library of coordinate reference systems; FileError, with the command that installs it, if it is missing."""
    try:
        import pyproj
    except ModuleNotFoundError:
        raise FileError('crs: pyproj is needed: pip install "bubblemesh[geo]"') from None
    return pyproj


@cache
def known_system(name: str) -> Any:
    """A coordinate reference system by its name, such as EPSG:4326; CaseError if it has no places on the earth."""
    pyproj = crs_library()
    try:
        system = pyproj.CRS.from_user_input(name)
    except pyproj.exceptions.CRSError:
        raise CaseError(f"{name!r} is no known coordinate reference system: give one as EPSG:4326") from None
    if not (system.is_geographic or system.is_projected):
        raise CaseError(f"{name!r} is no system of longitude and latitude, nor a projection of these: give another one")
    return system


def same_system(first: str, second: str) -> bool:
    """Whether two names mean the same system, apart from the order of its axes."""
    return bool(known_system(first).equals(known_system(second), ignore_axis_order=True))


@cache
def _transformer(source: str, target: str) -> Any:
    return crs_library().Transformer.from_crs(known_system(source), known_system(target), always_xy=True)


def _transformed(source: str, target: str, points: Floats) -> Floats:
    if source == target:
        return points
    return np.column_stack(_transformer(source, target).transform(points[:, 0], points[:, 1]))


@record
class Plane:
    """A plane about a place on the earth, in metres, for coordinates read in one system and written in another."""

    source: str  # system of the given coordinates
    target: str | None  # system of the written coordinates; None for the plane
    middle: Point  # longitude and latitude

    @classmethod
    def about(cls, source: str, target: str | None, points: Floats) -> "Plane":
        """The plane about the middle of points (n, 2)."""
        low, high = points.min(axis=0), points.max(axis=0)
        (longitude, latitude), *_ = _transformed(source, DEGREES, (low + high)[None] / 2).tolist()
        return cls(source, target, (round(longitude, DIGITS), round(latitude, DIGITS)))

    @cached_property
    def definition(self) -> str:
        """The system of the plane, as PROJ writes it."""
        return "+proj=sterea +lat_0={1:g} +lon_0={0:g} +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m +no_defs".format(
            *self.middle
        )

    @cached_property
    def radius(self) -> float:
        """Radius of the sphere that is the earth near the middle, in metres."""
        ellipsoid = crs_library().CRS(DEGREES).ellipsoid
        a, b = ellipsoid.semi_major_metre, ellipsoid.semi_minor_metre
        e2 = 1 - (b / a) ** 2
        return float(a * math.sqrt(1 - e2) / (1 - e2 * math.sin(math.radians(self.middle[1])) ** 2))

    def to(self, points: Floats) -> Floats:
        """Places (n, 2) in the plane of given points (n, 2); CaseError if one is too far away, or not a place."""
        if len(points) == 0:
            return points
        if known_system(self.source).is_geographic:
            _require_degrees(points)
        found = _transformed(self.source, self.definition, points)
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
        found = _transformed(self.source, self.definition, points)
        return found[np.isfinite(found).all(axis=1)]

    def given(self, points: Floats) -> Floats:
        """Coordinates (n, 2) in the given system of places (n, 2) in the plane."""
        return self._continuous(self.source, _transformed(self.definition, self.source, points))

    def given_place(self, point: Point) -> Point:
        """Coordinates in the given system of one place in the plane."""
        return as_point(self.given(np.array([point], float))[0])

    def written(self, points: Floats) -> Floats:
        """Coordinates (n, 2) in the written system of places (n, 2) in the plane."""
        if self.target is None:
            return points
        return self._continuous(self.target, _transformed(self.definition, self.target, points))

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
        along = _transformed(self.source, self.definition, given + np.array([step, 0.0])) - points
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
        starts = np.array(ring.vertices, float)
        points, pieces = self._along(starts, np.roll(starts, -1, axis=0))
        first = np.cumsum([0, *pieces])
        vertices = list(map(as_point, points[first[:-1]]))
        curves: list[Line | Polyline] = list(map(Line, vertices, [*vertices[1:], vertices[0]]))
        around = np.vstack([points, points[:1]])
        for k in np.flatnonzero(np.array(pieces) > 1).tolist():
            curves[k] = Polyline(around[first[k] : first[k + 1] + 1])
        labels = [side.label for side in ring.sides]
        return replace(ring, sides=tuple(map(Side, curves, labels)), vertices=tuple(vertices), given=None)

    def line(self, points: Floats) -> tuple[Floats, Integers]:
        """Points (m, 2) in the plane of a line by given points (n, 2), with more of them on long parts.

        And the given side (m - 1,) that each of its sides is a part of.
        """
        along, pieces = self._along(points[:-1], points[1:])
        return np.vstack([along, self.to(points[-1:])]), np.repeat(np.arange(len(pieces)), pieces)

    def bows(self, starts: Floats, ends: Floats) -> Floats:
        """How far (n,) the middles of straight sides from starts (n, 2) to ends (n, 2) are from chords in the plane."""
        first, last, middle = (self.to(points) for points in (starts, ends, (starts + ends) / 2))
        return np.hypot(*(middle - (first + last) / 2).T)

    def _along(self, starts: Floats, ends: Floats) -> tuple[Floats, list[int]]:
        """Places in the plane of the starts (n, 2) of sides and of points that cut them, and pieces of each side."""
        first, last, middle = (self.to(points) for points in (starts, ends, (starts + ends) / 2))
        length = np.hypot(*(last - first).T)
        off = np.hypot(*(middle - (first + last) / 2).T)
        share = np.divide(off, length, out=np.zeros(len(off)), where=length > 0)
        pieces = np.clip(np.ceil(share / BENT), 1, PIECES).astype(np.int64)
        side = np.repeat(np.arange(len(starts)), pieces)
        number = np.arange(len(side)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
        t = (number / pieces[side])[:, None]
        points = first[side]
        within = number > 0
        points[within] = self.to((1 - t[within]) * starts[side[within]] + t[within] * ends[side[within]])
        return points, pieces.tolist()


def are_off_the_earth(points: Floats) -> Booleans:
    """Mask (n,) of the points (n, 2) that are no longitudes and latitudes, in degrees, of any map."""
    x, y = np.abs(points).T
    return ~((x <= FARTHEST[0]) & (y <= FARTHEST[1]))


def _require_degrees(points: Floats) -> None:
    """Check that points (n, 2) are longitudes and latitudes of one part of the earth; CaseError if not."""
    x, y = points.T
    bad = np.flatnonzero(are_off_the_earth(points))
    if len(bad):
        px, py = points[bad[0]].tolist()
        raise CaseError(f"({px:g}, {py:g}) is no longitude and latitude: correct it, or crs.from")
    if np.abs(y).max() > NEAREST_POLE:
        raise CaseError(
            f"reaches within {90 - NEAREST_POLE:g} degree of a pole, where no box and no coast is: cut it off"
        )
    if np.ptp(x) > WIDEST:
        raise CaseError(
            f"spans {np.ptp(x):.0f} degrees of longitude: if it crosses the date line, add 360 to those that are "
            "negative; else choose a part of it"
        )


class Projecting:
    """Projection of coordinates while a domain is read: to a plane about the first of them.

    It notes straight sides and vertices, in the given coordinates, so that those which meet there meet in the plane.
    """

    def __init__(self, source: str, target: str | None) -> None:
        self.source, self.target = source, target
        self.plane: Plane | None = None
        self.contacts = NO_CONTACTS
        self._vertices = list[Floats]()
        self._sides = list[tuple[Floats, Floats]]()

    def plane_for(self, points: Floats) -> Plane:
        """The plane, which points (n, 2) decide on if they are the first."""
        if self.plane is None:
            if known_system(self.source).is_geographic:
                _require_degrees(points)
            self.plane = Plane.about(self.source, self.target, points)
        return self.plane

    def given_place(self, point: Point) -> Point:
        """Coordinates in the given system of a place in the plane; the point itself if there is no plane yet."""
        return point if self.plane is None else self.plane.given_place(point)

    def note_vertices(self, points: Floats) -> None:
        """Note vertices (n, 2), as given."""
        self._vertices.append(points)

    def note_sides(self, starts: Floats, ends: Floats) -> None:
        """Note straight sides from starts (n, 2) to ends (n, 2), as given, which are vertices as well."""
        self._sides.append((starts, ends))
        self._vertices += [starts, ends]

    def find_contacts(self, domain: Floats | None) -> bool:
        """Look for vertices on noted sides that are bent in the plane; whether there are others than known before.

        What is near enough depends on the size of the domain, by points (n, 2) in the plane around it; of all sides, if
        that is None. The notes are forgotten.
        """
        sides, vertices = self._sides, self._vertices
        self._sides, self._vertices = [], []
        if self.plane is None or not sides:
            return False
        starts, ends = (np.vstack(column) for column in zip(*sides, strict=True))
        around = self.plane.to(starts) if domain is None else domain
        low, high = around.min(axis=0), around.max(axis=0)
        bent = self.plane.bows(starts, ends) > TOUCHING / 2 * (high - low).max()
        if not bent.any():
            return False
        given = self.plane.given(np.array([low, high, [low[0], high[1]], [high[0], low[1]]]))
        rounding = ROUNDINGS * float(np.spacing(np.abs(given).max()))
        tolerance = max(TOUCHING * float(np.ptp(given, axis=0).max()), rounding)
        found = contacts_between(starts[bent], ends[bent], np.vstack(vertices), tolerance)
        known, self.contacts = self.contacts, found
        return found != known


_projecting: ContextVar[Projecting | None] = ContextVar("projecting", default=None)


@contextmanager
def projecting(by: Projecting | None) -> Iterator[None]:
    """Within the block, project everything that is read or drawn to a plane; None for a case without projection."""
    token = _projecting.set(by)
    try:
        yield
    finally:
        _projecting.reset(token)


def is_projecting() -> bool:
    """Whether everything that is read or drawn is projected to a plane."""
    return _projecting.get() is not None


def given_plane() -> Plane | None:
    """The plane to which coordinates are projected; None without projection, or if it is not known yet."""
    by = _projecting.get()
    return None if by is None else by.plane


def has_new_contacts(areas: Sequence[Area]) -> bool:
    """Whether vertices that were read lie on sides, as given, that did not get them; False without projection.

    The areas are those of the domain, as far as they are known: the same as `Projecting.find_contacts`.
    """
    by = _projecting.get()
    if by is None:
        return False
    return by.find_contacts(np.vstack(outlines(area.outer for area in areas)) if areas else None)


def full_turn() -> float | None:
    """A full turn in degrees, if the given coordinates are longitudes and latitudes; else None."""
    by = _projecting.get()
    return 2 * HALF_TURN if by is not None and known_system(by.source).is_geographic else None


def require_system(named: str | None, degrees: bool | None, points: Floats) -> None:
    """Check that points (n, 2) of a file are in the system of the case; CaseError if they are in another one.

    The file may have ``named`` its system, as a name or as well-known text, and its coordinates may be ``degrees``;
    None if unknown. A name that the library does not know is ignored.
    """
    by = _projecting.get()
    if by is None or len(points) == 0:
        return
    if degrees and not known_system(by.source).is_geographic:
        raise CaseError(f"crs.from: {by.source} is in metres, and the file says that its coordinates are degrees")
    try:
        other = named and known_system(named)
    except CaseError:
        return
    if named and other and not same_places(by.source, named, points):
        code = ":".join(other.to_authority() or ())
        system = other.name if code in ("", other.name) else f"{other.name} ({code})"
        raise CaseError(
            f"its coordinates are in {system}, and crs.from is {by.source}: give that of the file, or take the file to "
            f"the other by ogr2ogr -t_srs {by.source}"
        )
    if degrees is None and not named and _are_surely_degrees(by.source, points):
        raise CaseError(
            f"crs.from: {by.source} is in metres, and all coordinates of the file are in the range of degrees: say "
            "crs: {from: EPSG:4326} if they are, else write their system into the file"
        )


def same_places(first: str, second: str, points: Floats) -> bool:
    """Whether points (n, 2) are the same places in two systems, within the differences of variants of a system."""
    if same_system(first, second):
        return True
    low, high = points.min(axis=0), points.max(axis=0)
    some = np.array([low, (low + high) / 2, high])
    places = [_transformed(each, DEGREES, some) for each in (first, second)]
    _, _, apart = crs_library().Geod(ellps="WGS84").inv(*places[0].T, *places[1].T)
    return bool((np.asarray(apart) <= SAME_PLACE).all())


def _are_surely_degrees(source: str, points: Floats) -> bool:
    """Whether points (n, 2) of a map are degrees, though the system, a public one and not local to them, has metres."""
    system = known_system(source)
    return bool(
        not system.is_geographic and system.area_of_use is not None and (np.abs(points) <= [2 * HALF_TURN, 90.0]).all()
    )


def projected_ring(ring: Ring) -> Ring:
    """The ring in the plane, if coordinates are projected; the same errors as `Plane.ring`."""
    by = _projecting.get()
    if by is None:
        return ring
    starts = np.array(ring.vertices, float).reshape(-1, 2)
    by.note_sides(starts, np.roll(starts, -1, axis=0))
    return by.plane_for(starts).ring(by.contacts.ring(ring))


def projected(points: Floats) -> Floats:
    """Points (n, 2) in the plane, if coordinates are projected; the same errors as `Plane.to`."""
    by = _projecting.get()
    return points if by is None or len(points) == 0 else by.plane_for(points).to(points)


def projected_point(point: Point) -> Point:
    """Place of a point in the plane; the same errors as `Plane.to`."""
    return as_point(projected(np.array([point], float))[0])


def projected_if_near(point: Point) -> Point | None:
    """Place of a point in the plane, as far as this is known; None without an error if it does not reach there."""
    plane = given_plane()
    found = np.array([point], float) if plane is None else plane.near(np.array([point], float))
    return as_point(found[0]) if len(found) else None


def projected_vertices(points: Floats) -> Floats:
    """Points (n, 2) in the plane that are nodes, also of sides that they lie on; the same errors as `Plane.to`."""
    if by := _projecting.get():
        by.note_vertices(points)
    return projected(points)


def projected_vertex(point: Point) -> Point:
    """Place in the plane of a point that is a node, also of sides that it lies on; the same errors as `Plane.to`."""
    return as_point(projected_vertices(np.array([point], float))[0])


def projected_side(start: Point, end: Point) -> list[Point]:
    """Points in the plane to which a side goes, one after the other, from its start: vertices on it, and its end."""
    by = _projecting.get()
    if by is None:
        return [end]
    by.note_sides(np.array([start], float), np.array([end], float))
    return list(map(projected_point, by.contacts.along(start, end)[1:]))


def projected_line(points: Floats) -> tuple[Floats, Integers]:
    """Points (m, 2) of a line in the plane, more of them on long parts, and the given side (m - 1,) of each side.

    The same errors as `Plane.to`.
    """
    by = _projecting.get()
    if by is None:
        return points, np.arange(len(points) - 1)
    by.note_sides(points[:-1], points[1:])
    cut, side = by.contacts.line(points)
    found, part = by.plane_for(points).line(cut)
    return found, side[part]


def projected_length(length: float, at: Point) -> float:
    """Length in the plane of some metres at a given point."""
    by = _projecting.get()
    if by is None:
        return length
    plane = by.plane_for(np.array([at], float))
    return length * float(plane.scale(*plane.to(np.array([at], float)).T)[0])
