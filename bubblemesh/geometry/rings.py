"""Closed rings of smooth sides, made from the shapes that a case file offers."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import GeometryError
from bubblemesh.geometry import curves
from bubblemesh.geometry.traces import Polylines
from bubblemesh.messages import place

# Relative difference of an arc's two radii: numbers typed with few digits are mended, other ones are mistakes.
ARC_MISMATCH = 1e-3
FLATTEST = 1e-7  # distance of an arc's ends in terms of its radius, below which rounding hides the arc
MOST_NAMED = 3  # duplicate points that are told one by one

Point = tuple[float, float]


class Line(NamedTuple):
    """A straight side; the fields of this and the next records are those of the curve family."""

    start: Point
    end: Point

    def reversed(self) -> "Line":
        return Line(self.end, self.start)

    def scaled(self, factor: float) -> "Line":
        return Line(_times(self.start, factor), _times(self.end, factor))


class Arc(NamedTuple):
    """A circular side, or a whole circle."""

    center: Point
    radius: float
    angle: float
    sweep: float

    def reversed(self) -> "Arc":
        return self._replace(angle=self.angle + self.sweep, sweep=-self.sweep)

    def scaled(self, factor: float) -> "Arc":
        return self._replace(center=_times(self.center, factor), radius=self.radius * factor)


class Ellipse(NamedTuple):
    """A whole ellipse, ``angle`` in radians."""

    center: Point
    radii: Point
    angle: float
    turn: float

    def reversed(self) -> "Ellipse":
        return self._replace(turn=-self.turn)

    def scaled(self, factor: float) -> "Ellipse":
        return self._replace(center=_times(self.center, factor), radii=_times(self.radii, factor))


class Spline(NamedTuple):
    """A cubic spline through ``knots`` (k, 2), with given ``slopes`` (2, 2) at its ends or natural ones."""

    knots: Floats
    slopes: Floats | None = None

    def reversed(self) -> "Spline":
        return Spline(self.knots[::-1], None if self.slopes is None else -self.slopes[::-1])

    def scaled(self, factor: float) -> "Spline":
        return self._replace(knots=self.knots * factor)


class Polyline(NamedTuple):
    """A polyline through ``points`` (k, 2) that nodes may slide along; closed if the last point is the first."""

    points: Floats

    def reversed(self) -> "Polyline":
        return Polyline(self.points[::-1])

    def scaled(self, factor: float) -> "Polyline":
        return Polyline(self.points * factor)


Curve = Line | Arc | Ellipse | Spline | Polyline


def family(members: Sequence[Curve]) -> curves.Family:
    """The family that evaluates ``members``, which are of one kind."""
    if isinstance(members[0], Spline):
        splines = [member for member in members if isinstance(member, Spline)]
        return curves.Splines([spline.knots for spline in splines], [spline.slopes for spline in splines])
    if isinstance(members[0], Polyline):
        return Polylines([member.points for member in members if isinstance(member, Polyline)])
    kind = {Line: curves.Lines, Arc: curves.Arcs, Ellipse: curves.Ellipses}[type(members[0])]
    return kind(*(np.array(column, float) for column in zip(*members, strict=True)))


@dataclass(frozen=True)
class Side:
    """One smooth side of a ring; ``label`` is None where the case gives none."""

    curve: Curve
    label: str | None = None


@dataclass(frozen=True)
class Ring:
    """A closed ring.

    Attributes
    ----------
    sides : tuple of Side
    vertices : tuple of (x, y)
        Start of each side; empty for a whole circle or ellipse, which has no fixed node.
    notes : tuple of str
        What was changed on reading, for the user to know.
    given : (m, 2), optional
        Outline of the ring as it was given, where it is followed as a curve.
    origin : str, optional
        File and place in it that the ring comes from, for messages.
    """

    sides: tuple[Side, ...]
    vertices: tuple[Point, ...]
    notes: tuple[str, ...] = ()
    given: Floats | None = field(default=None, compare=False)
    origin: str | None = field(default=None, compare=False)

    def reversed(self) -> "Ring":
        """The same ring run the other way."""
        sides = tuple(replace(side, curve=side.curve.reversed()) for side in reversed(self.sides))
        return replace(self, sides=sides, vertices=self.vertices[:1] + self.vertices[:0:-1])

    def labelled(self, label: str | None) -> "Ring":
        """The same ring with all its sides called ``label``, if that is given."""
        return self if label is None else replace(self, sides=tuple(replace(side, label=label) for side in self.sides))

    def renamed(self, old: str, new: str) -> "Ring":
        """The same ring with the sides that are called ``old`` called ``new``."""
        return replace(self, sides=tuple(replace(s, label=new) if s.label == old else s for s in self.sides))

    def scaled(self, factor: float) -> "Ring":
        """The same ring in another unit of length."""
        sides = tuple(replace(side, curve=side.curve.scaled(factor)) for side in self.sides)
        return replace(self, sides=sides, vertices=tuple(_times(vertex, factor) for vertex in self.vertices))


@dataclass(frozen=True)
class OpenPath:
    """Inner sides one after the other.

    Attributes
    ----------
    sides : tuple of Side
    vertices : tuple of (x, y)
        Start of each side and end of the last one; empty for a whole circle or ellipse.
    label : str
        For sides that have none.
    notes : tuple of str
        What was changed on reading, for the user to know.
    """

    sides: tuple[Side, ...]
    vertices: tuple[Point, ...]
    label: str
    notes: tuple[str, ...] = ()

    @classmethod
    def around(cls, ring: Ring, label: str) -> "OpenPath":
        """The sides of a ring."""
        return cls(ring.sides, ring.vertices + ring.vertices[:1], label, ring.notes)


class LineTo(NamedTuple):
    """The straight line to the point ``to``."""

    to: Point
    label: str | None = None


class ArcTo(NamedTuple):
    """The circular arc about ``center`` to the point ``to``, counter-clockwise if ``left``."""

    to: Point
    center: Point
    left: bool
    label: str | None = None


class SplineTo(NamedTuple):
    """The cubic spline through the points ``through``, whose last is its end."""

    through: Sequence[Point]
    label: str | None = None


Piece = LineTo | ArcTo | SplineTo


def end_of(piece: Piece) -> Point:
    """The point at which a piece ends."""
    return _point(piece.through[-1] if isinstance(piece, SplineTo) else piece.to)


def polygon(points: Sequence[Sequence[float]], labels: Sequence[str] | None = None, label: str | None = None) -> Ring:
    """Polygon through ``points`` (n, 2); ``labels`` name the sides, the first from point 0 to point 1."""
    if len(points) == 0:
        raise GeometryError("a polygon has no points: give at least three")
    corners = [_point(point) for point in points]
    if len(corners) > 1 and corners[0] == corners[-1]:
        corners.pop()
    names = list(labels) if labels is not None else [label] * len(corners)
    pieces = [LineTo(corner, name) for corner, name in zip(corners[1:] + corners[:1], names, strict=False)]
    return path(corners[0], pieces, label)


def rectangle(
    x0: float, y0: float, x1: float, y1: float, labels: Sequence[str] | None = None, label: str | None = None
) -> Ring:
    """Rectangle with opposite corners (x0, y0) and (x1, y1); sides in the order bottom, right, top, left."""
    (x0, x1), (y0, y1) = sorted([x0, x1]), sorted([y0, y1])
    return polygon([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], labels, label)


def circle(center: Sequence[float], radius: float, label: str | None = None) -> Ring:
    """Whole circle."""
    return Ring((Side(Arc(_point(center), float(radius), 0.0, 2 * np.pi), label),), ())


def ellipse(center: Sequence[float], radii: Sequence[float], angle: float = 0.0, label: str | None = None) -> Ring:
    """Whole ellipse whose first axis is turned by ``angle`` degrees."""
    return Ring((Side(Ellipse(_point(center), _point(radii), float(np.radians(angle)), 1.0), label),), ())


def path(start: Sequence[float], pieces: Sequence[Piece], label: str | None = None) -> Ring:
    """Ring from ``start`` along ``pieces``, closed by a straight line where it does not end at its start.

    Consecutive points that coincide are merged, with a note.

    Raises
    ------
    GeometryError
        If an arc's ends are not equally far from its centre, or fewer than three points remain.
    """
    first = here = _point(start)
    tolerance = 1e-13 * _extent([first, *(end_of(piece) for piece in pieces)])
    if not _same(end_of(pieces[-1]) if pieces else first, first, tolerance):
        pieces = [*pieces, LineTo(first, label)]
    sides, vertices, notes, doubles = [], [], [], []
    for number, piece in enumerate(pieces, start=1):
        end = first if number == len(pieces) else end_of(piece)
        if isinstance(piece, LineTo) and _same(here, end, tolerance):
            doubles.append(end)
            continue
        curve, curve_notes = _curve(here, piece, end)
        sides.append(Side(curve, piece.label or label))
        vertices.append(here)
        notes += curve_notes
        here = end
    if all(isinstance(side.curve, Line) for side in sides) and len(set(vertices)) < 3:
        raise GeometryError(f"the ring at {place(first)} has fewer than three different points: give at least three")
    return Ring(tuple(sides), tuple(vertices), (*_merged(doubles), *notes))


def open_path(start: Sequence[float], pieces: Sequence[Piece], label: str) -> OpenPath:
    """Open line from ``start`` along ``pieces``.

    Raises
    ------
    GeometryError
        If an arc's ends are not equally far from its centre, or the line has no length.
    """
    here, sides, vertices = _point(start), [], [_point(start)]
    notes, doubles = [], []
    for piece in pieces:
        end = end_of(piece)
        if isinstance(piece, LineTo) and here == end:
            doubles.append(end)
            continue
        curve, curve_notes = _curve(here, piece, end)
        notes += curve_notes
        sides.append(Side(curve, piece.label))
        vertices.append(end)
        here = end
    if not sides:
        raise GeometryError(f"the line at {place(here)} has no length: give it two different points")
    return OpenPath(tuple(sides), tuple(vertices), label, (*_merged(doubles), *notes))


def _merged(doubles: Sequence[Point]) -> list[str]:
    """Notes on points that were given twice in a row."""
    if len(doubles) > MOST_NAMED:
        return [f"{len(doubles)} duplicate points merged, the first at {place(doubles[0])}"]
    return [f"duplicate point {place(point)} merged" for point in doubles]


def _curve(start: Point, piece: Piece, end: Point) -> tuple[Curve, list[str]]:
    """The curve of ``piece`` between two vertices, and notes on what was mended."""
    if isinstance(piece, LineTo):
        return Line(start, end), []
    if isinstance(piece, ArcTo):
        return _arc(start, piece, end)
    knots = np.array([start, *piece.through[:-1], end], float)
    repeated = np.flatnonzero((np.diff(knots, axis=0) == 0).all(axis=1))
    notes = [f"duplicate spline point {place(knots[i])} merged" for i in repeated]
    knots = np.delete(knots, repeated, axis=0)
    if len(knots) < 2 or (len(knots) < 4 and start == end):
        raise GeometryError(f"the spline at {place(start)} has too few different points to be a curve")
    return Spline(knots), notes


def _arc(start: Point, piece: ArcTo, end: Point) -> tuple[Arc, list[str]]:
    """Arc between two vertices; its centre is moved to the nearest point that is equally far from both."""
    p, q, center = np.array(start), np.array(end), np.array(piece.center, float)
    radii = np.hypot(*(p - center)), np.hypot(*(q - center))
    if max(radii) == 0:
        raise GeometryError(f"the arc at {place(start)} has its center and both ends in one point: move its center")
    mismatch = abs(radii[0] - radii[1]) / max(radii)
    if mismatch > ARC_MISMATCH:
        raise GeometryError(
            f"the arc from {place(start)} to {place(end)} is {radii[0]:.6g} from its center {place(piece.center)} at "
            f"one end and {radii[1]:.6g} at the other: correct the center or an end"
        )
    if start != end:
        chord = q - p
        if np.hypot(*chord) <= FLATTEST * max(radii):
            raise GeometryError(
                f"the arc from {place(start)} to {place(end)} has a radius of {max(radii):.3g}, too large for ends so "
                "near to each other: use a straight line, or the same point at both ends for a whole circle"
            )
        center = center - chord * (((center - p) @ chord) / (chord @ chord) - 0.5)
    notes = []
    if mismatch > 1e-9:
        notes.append(f"center of the arc from {place(start)} to {place(end)} moved by {mismatch:.1e} of its radius")
    (ux, uy), (wx, wy) = p - center, q - center
    first, turned = np.arctan2(uy, ux), np.arctan2(ux * wy - uy * wx, ux * wx + uy * wy)
    if piece.left and turned <= 0:
        turned += 2 * np.pi
    elif not piece.left and turned >= 0:
        turned -= 2 * np.pi
    return Arc(_point(center), float(np.hypot(ux, uy)), float(first), float(turned)), notes


def _extent(points: Sequence[Sequence[float]]) -> float:
    return float(np.ptp(np.array(points, float), axis=0).max())


def _same(a: Sequence[float], b: Sequence[float], tolerance: float) -> bool:
    return max(abs(a[0] - b[0]), abs(a[1] - b[1])) <= tolerance


def _point(values: Sequence[float] | Floats) -> Point:
    return float(values[0]), float(values[1])


def _times(point: Point, factor: float) -> Point:
    return point[0] * factor, point[1] * factor
