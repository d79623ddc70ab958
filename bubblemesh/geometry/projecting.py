"""Projection of all that is read or drawn while a domain is made, to one plane about the first of it."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.geometry.arrangement import ROUNDINGS, TOUCHING
from bubblemesh.geometry.contacts_as_given import NO_CONTACTS, contacts_between
from bubblemesh.geometry.paths import Area, Point, Ring, as_point, outlines
from bubblemesh.geometry.plane import Plane
from bubblemesh.geometry.systems import known_system, require_degrees


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
                require_degrees(points)
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


def projected_system() -> str | None:
    """System of everything that is read or drawn, from which it is projected to a plane; None without projection."""
    by = _projecting.get()
    return None if by is None else by.source


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
