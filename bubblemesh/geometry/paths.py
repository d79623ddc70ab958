"""Curves one after the other: closed rings and open paths."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import field, replace
from functools import cached_property
from typing import Any, NamedTuple, cast

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import Key
from bubblemesh.geometry import curves
from bubblemesh.geometry.beziers import Beziers
from bubblemesh.geometry.cubic_splines import CubicSpline
from bubblemesh.geometry.similarity import UNMOVED, Similarity
from bubblemesh.records import record

Point = tuple[float, float]


def as_point(values: Sequence[float] | Floats) -> Point:
    """Pair of Python's numbers."""
    return float(values[0]), float(values[1])


class Line(NamedTuple):
    """A straight side; the fields of this and the next records are those of the curve family."""

    start: Point
    end: Point

    def reversed(self) -> "Line":
        return Line(self.end, self.start)

    def moved(self, by: Similarity) -> "Line":
        return Line(by.point(self.start), by.point(self.end))


class Arc(NamedTuple):
    """A circular side, or a whole circle."""

    center: Point
    radius: float
    angle: float
    sweep: float

    def reversed(self) -> "Arc":
        return self._replace(angle=self.angle + self.sweep, sweep=-self.sweep)

    def moved(self, by: Similarity) -> "Arc":
        return Arc(by.point(self.center), self.radius * by.scale, by.angle_of(self.angle), self.sweep * by.turn)


class Ellipse(NamedTuple):
    """A whole ellipse, ``angle`` in radians."""

    center: Point
    radii: Point
    angle: float
    turn: float

    def reversed(self) -> "Ellipse":
        return self._replace(turn=-self.turn)

    def moved(self, by: Similarity) -> "Ellipse":
        radii = self.radii[0] * by.scale, self.radii[1] * by.scale
        return Ellipse(by.point(self.center), radii, by.angle_of(self.angle), self.turn * by.turn)


class Bezier(NamedTuple):
    """A regular cubic Bézier curve by its control points: its speed is nowhere 0, as it would be at a cusp."""

    start: Point
    first: Point
    second: Point
    end: Point

    def reversed(self) -> "Bezier":
        return Bezier(*reversed(self))

    def moved(self, by: Similarity) -> "Bezier":
        return Bezier(*map(by.point, self))


@record(eq=False)
class Spline:
    """A cubic spline through ``knots`` (k, 2), with given ``slopes`` (2, 2) at its ends or natural ones.

    The ends are "not-a-knot"; a spline whose last point is its first is periodic. A part of a longer spline keeps its
    shape by its slopes, the derivatives by the length along the chords.
    """

    knots: Floats
    slopes: Floats | None = None

    @cached_property
    def fitted(self) -> CubicSpline:
        """The polynomials between the knots."""
        return CubicSpline.through(self.knots, self.slopes)

    def reversed(self) -> "Spline":
        return Spline(self.knots[::-1], None if self.slopes is None else -self.slopes[::-1])

    def moved(self, by: Similarity) -> "Spline":
        return Spline(by.points(self.knots), None if self.slopes is None else by.directions(self.slopes))


class Polyline(NamedTuple):
    """A polyline through ``points`` (k, 2) that nodes may slide along; closed if the last point is the first."""

    points: Floats

    def reversed(self) -> "Polyline":
        return Polyline(self.points[::-1])

    def moved(self, by: Similarity) -> "Polyline":
        return Polyline(by.points(self.points))


WholeCurve = Line | Arc | Ellipse | Bezier | Spline | Polyline


class CurveSection(NamedTuple):
    """The part of a curve that begins after ``offset`` of its whole length ``total`` and is ``length`` long.

    A section of a closed curve may run past its start.
    """

    curve: WholeCurve
    offset: float
    length: float
    total: float

    def reversed(self) -> "CurveSection":
        return self._replace(curve=self.curve.reversed(), offset=(self.total - self.offset - self.length) % self.total)

    def moved(self, by: Similarity) -> "CurveSection":
        lengths = (length * by.scale for length in self[1:])
        return CurveSection(self.curve.moved(by), *lengths)


Curve = WholeCurve | CurveSection


def family(members: Sequence[WholeCurve]) -> curves.Family:
    """The family that evaluates ``members``, which are of one kind."""
    if isinstance(members[0], Spline):
        return curves.Splines([one.fitted for one in members if isinstance(one, Spline)])
    columns: Iterable[Any] = zip(*cast(Sequence[NamedTuple], members), strict=True)
    if isinstance(members[0], Polyline):  # of any number of points each
        return curves.Polylines(*columns)
    kinds = {Line: curves.Lines, Arc: curves.Arcs, Ellipse: curves.Ellipses, Bezier: Beziers}
    return kinds[type(members[0])](*(np.array(column, float) for column in columns))


class Side(NamedTuple):
    """A smooth side of a ring; ``label`` is None where the case gives none."""

    curve: Curve
    label: str | None = None


@record
class RingChange:
    """A change of rings that a case asks for: its kind, its place, and by how much it made the area larger."""

    what: str
    at: Point
    area: float
    before: tuple[Floats, ...] = field(default=(), compare=False)  # the rings (m, 2) as they were, for pictures

    def moved(self, by: Similarity) -> "RingChange":
        """The change where a similarity takes it."""
        return RingChange(self.what, by.point(self.at), self.area * by.scale**2, tuple(map(by.points, self.before)))


@record
class Ring:
    """A closed ring. Errors are about its key in the case."""

    sides: tuple[Side, ...]
    vertices: tuple[Point, ...]  # start of each side; empty for a whole circle or ellipse, which has no fixed node
    notes: tuple[str, ...] = ()  # on what was changed on reading, for the user to know
    changes: tuple[RingChange, ...] = ()  # those that the case asks for
    given: Floats | None = field(default=None, compare=False)  # its outline (m, 2), if it is followed as a curve
    origin: str | None = field(default=None, compare=False)  # file and place in it, for messages
    key: Key = field(default=Key(), compare=False)
    lost: tuple[str, ...] = ()  # labels that only sides without length had, which are merged
    optional: bool = field(default=False, compare=False)  # whether it is left out where it lies outside of the domain

    @cached_property
    def outline(self) -> Floats:
        """Polygonal copy (m, 2), computed once: to read and check a file takes it several times. It is read-only."""
        (points,) = _outlined([self])
        return points

    def reversed(self) -> "Ring":
        """The ring run the other way."""
        sides = tuple(Side(side.curve.reversed(), side.label) for side in reversed(self.sides))
        turned = replace(self, sides=sides, vertices=self.vertices[:1] + self.vertices[:0:-1])
        if "outline" in vars(self):
            turned._keep_outline(np.roll(self.outline[::-1], 1, axis=0))  # from the same point on
        return turned

    def _keep_outline(self, points: Floats) -> None:
        """Keep a known outline (m, 2) where the cached property would."""
        points.setflags(write=False)
        vars(self)["outline"] = points

    def labelled(self, label: str | None) -> "Ring":
        """The ring with all its sides called ``label``, if that is given."""
        return self if label is None else replace(self, sides=tuple(side._replace(label=label) for side in self.sides))

    def without_label(self, label: str) -> "Ring":
        """The ring without the ``label`` on its sides."""
        return replace(self, sides=tuple(s._replace(label=None) if s.label == label else s for s in self.sides))

    def relabelled(self, name: Callable[[str | None], str]) -> "Ring":
        """The ring with the labels of its sides replaced by what the function makes of them."""
        return replace(self, sides=tuple(side._replace(label=name(side.label)) for side in self.sides))

    def as_optional(self) -> "Ring":
        """The ring, which may lie outside of the domain."""
        return replace(self, optional=True)

    def moved(self, by: Similarity) -> "Ring":
        """The ring where a similarity takes it, its labels with their sides."""
        if by == UNMOVED:  # as most files are, with very many sides
            return self
        given = None if self.given is None else by.points(self.given)
        changes = tuple(change.moved(by) for change in self.changes)
        vertices = tuple(map(by.point, self.vertices))
        return replace(self, sides=_moved(self.sides, by), vertices=vertices, changes=changes, given=given)


def outlines(rings: Iterable[Ring]) -> list[Floats]:
    """The outlines of rings; of many they are computed together, in a small part of the time that one by one takes."""
    rings = list(rings)
    new = [ring for ring in rings if "outline" not in vars(ring)]
    for ring, points in zip(new, _outlined(new), strict=True):
        ring._keep_outline(points)
    return [ring.outline for ring in rings]


def _outlined(rings: Sequence[Ring]) -> list[Floats]:
    from bubblemesh.geometry.polygonal_copy import outlines_of  # of boundaries, which are made of rings

    found = outlines_of(rings)
    for points in found:
        points.setflags(write=False)
    return found


@record
class Area:
    """A part of the plane inside an outer ring and outside its holes; ``name`` is its name in a file."""

    outer: Ring
    holes: tuple[Ring, ...] = ()
    name: str | None = None
    largest: float | None = None  # area of a triangle in it, where a file says so

    @property
    def rings(self) -> tuple[Ring, ...]:
        """The outer ring, then the holes."""
        return self.outer, *self.holes

    def mapped(self, function: Callable[[Ring], Ring]) -> "Area":
        """The area with its rings replaced by what the function makes of them."""
        return replace(self, outer=function(self.outer), holes=tuple(map(function, self.holes)))

    def relabelled(self, name: Callable[[str | None], str]) -> "Area":
        """The area with the labels of its rings replaced by what the function makes of them."""
        return self.mapped(lambda ring: ring.relabelled(name))

    def as_optional(self) -> "Area":
        """The area, which may lie outside of the domain."""
        return self.mapped(lambda ring: ring.as_optional())

    def noted(self, note: str) -> "Area":
        """The area with one more note on what was changed on reading."""
        return replace(self, outer=replace(self.outer, notes=(*self.outer.notes, note)))

    def about(self, key: Key) -> "Area":
        """The area with the key of the case that gives its rings."""
        return self.mapped(lambda ring: replace(ring, key=key))

    def moved(self, by: Similarity) -> "Area":
        """The area where a similarity takes it, its labels with their sides."""
        largest = None if self.largest is None else self.largest * by.scale**2
        return replace(self.mapped(lambda ring: ring.moved(by)), largest=largest)


@record
class OpenPath:
    """Inner sides one after the other. Errors are about its key in the case."""

    sides: tuple[Side, ...]
    vertices: tuple[Point, ...]  # start of each side and end of the last one; empty for a whole circle or ellipse
    label: str  # for sides that have none
    notes: tuple[str, ...] = ()  # on what was changed on reading, for the user to know
    key: Key = field(default=Key(), compare=False)
    optional: bool = False  # whether it is left out where it lies outside of the domain
    lost: tuple[str, ...] = ()  # labels that only sides without length had, which are merged
    origin: str | None = field(default=None, compare=False)  # file and place in it, for messages
    unit: float = 1.0  # length of what was 1 where the line is drawn, in the case or in its file
    named: bool = True  # whether the label was given, not made up
    joined: bool = False  # whether an end was moved to what it nearly met
    sides_named: bool = True  # whether those of the sides were
    turned: bool = False  # whether the right side is the one that its edges belong to, as of a region inside

    @property
    def name(self) -> str:
        """Name in messages: the label that all sides have, or that of the line, and where it comes from."""
        labels = {side.label or self.label for side in self.sides}
        label = labels.pop() if len(labels) == 1 else self.label
        return f"{label!r}" if self.origin is None else f"{label!r} ({self.origin})"

    def moved(self, by: Similarity) -> "OpenPath":
        """The line where a similarity takes it, its labels with their sides."""
        vertices = tuple(map(by.point, self.vertices))
        return replace(self, sides=_moved(self.sides, by), vertices=vertices, unit=self.unit * by.scale)

    def labelled(self, label: str | None) -> "OpenPath":
        """The line with all its sides called ``label``, if that is given."""
        if label is None:
            return self
        return replace(self, sides=tuple(side._replace(label=label) for side in self.sides), label=label)

    def relabelled(self, name: Callable[[str | None], str]) -> "OpenPath":
        """The line with its labels replaced by what the function makes of them."""
        sides = (side if side.label is None else side._replace(label=name(side.label)) for side in self.sides)
        return replace(self, sides=tuple(sides), label=name(self.label or None))

    def as_optional(self) -> "OpenPath":
        """The line, which may lie outside of the domain."""
        return replace(self, optional=True)

    @classmethod
    def around(cls, ring: Ring, label: str) -> "OpenPath":
        """The sides of a ring, with a label made up for those that have none."""
        vertices = ring.vertices + ring.vertices[:1]
        return cls(ring.sides, vertices, label, ring.notes, ring.key, lost=ring.lost, origin=ring.origin, named=False)


@record
class InnerPoint:
    """A point inside a domain that is a node, with the key of the case that gives it, which errors are about."""

    at: Point
    label: str
    key: Key = field(default=Key(), compare=False)
    optional: bool = False  # whether it is left out where it lies outside of the domain
    reach: float = 0.0  # how far it may be moved onto a line or a ring

    def moved(self, by: Similarity) -> "InnerPoint":
        """The point where a similarity takes it."""
        return replace(self, at=by.point(self.at), reach=self.reach * by.scale)

    def relabelled(self, name: Callable[[str | None], str]) -> "InnerPoint":
        """The point with its label replaced by what the function makes of it."""
        return replace(self, label=name(self.label or None))

    def as_optional(self) -> "InnerPoint":
        """The point, which may lie outside of the domain."""
        return replace(self, optional=True)


def _moved(sides: Sequence[Side], by: Similarity) -> tuple[Side, ...]:
    return tuple(side._replace(curve=side.curve.moved(by)) for side in sides)
