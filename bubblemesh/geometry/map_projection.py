"""Projection of what is read or drawn to one plane, in which vertices stay on the sides that they lie on as given."""

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.geometry.contacts_as_given import NO_CONTACTS, Contacts
from bubblemesh.geometry.paths import Point, Ring, as_point
from bubblemesh.geometry.plane import Plane
from bubblemesh.records import record


@record
class MapProjection:
    """From given coordinates to those of a plane, with the same errors as `Plane`; without a plane they stay."""

    plane: Plane | None = None
    contacts: Contacts = NO_CONTACTS  # which sides get as vertices

    @property
    def system(self) -> str | None:
        """System of the given coordinates; None without a plane."""
        return None if self.plane is None else self.plane.source

    def points(self, points: Floats) -> Floats:
        """Places (n, 2) of given points (n, 2)."""
        return points if self.plane is None else self.plane.to(points)

    def point(self, point: Point) -> Point:
        """Place of one given point."""
        return as_point(self.points(np.array([point], float))[0])

    def near(self, point: Point) -> Point | None:
        """Place of a given point; None without an error if the plane does not reach there."""
        given = np.array([point], float)
        found = given if self.plane is None else self.plane.near(given)
        return as_point(found[0]) if len(found) else None

    def ring(self, ring: Ring) -> Ring:
        """A ring of straight sides, with its contacts."""
        return ring if self.plane is None else self.plane.ring(self.contacts.ring(ring))

    def side(self, start: Point, end: Point) -> list[Point]:
        """Places to which a given side goes, one after the other, from its start: contacts, and its end."""
        return list(map(self.point, self.contacts.along(start, end)[1:]))

    def line(self, points: Floats) -> tuple[Floats, Integers]:
        """Places (m, 2) of a line, more of them on long parts, and the given side (m - 1,) of each of its sides."""
        cut, side = self.contacts.line(points)
        if self.plane is None:
            return cut, side
        found, part = self.plane.line(cut)
        return found, side[part]

    def length(self, length: float, at: Point) -> float:
        """Length in the plane of some metres at a given point."""
        if self.plane is None:
            return length
        return length * float(self.plane.scale(*self.plane.to(np.array([at], float)).T)[0])


UNPROJECTED = MapProjection()
