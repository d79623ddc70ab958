"""Rings and open paths, made from the shapes that a case file offers."""

from collections.abc import Sequence
from itertools import repeat
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import LARGEST_NUMBER, Floats, is_real
from bubblemesh.errors import CaseError, GeometryError
from bubblemesh.geometry.paths import Arc, Bezier, Curve, Ellipse, Line, Point, Side, Spline, as_point
from bubblemesh.geometry.paths import OpenPath as OpenPath  # what the functions here return
from bubblemesh.geometry.paths import Ring as Ring
from bubblemesh.messages import counted, listed, place, two_places

# Relative difference of an arc's two radii: numbers typed with few digits are mended, other ones are mistakes.
ARC_MISMATCH = 1e-3
FLATTEST_ARC = 1e-7  # distance of an arc's ends in terms of its radius, below which rounding hides the arc
MOST_NAMED = 3  # duplicate points that are listed one by one


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


class BezierTo(NamedTuple):
    """The cubic Bézier curve to the point ``to`` by its inner control points, which is regular: it stops nowhere."""

    to: Point
    first: Point
    second: Point
    label: str | None = None


class SplineTo(NamedTuple):
    """The cubic spline through the points ``through``, whose last is its end."""

    through: Sequence[Point]
    label: str | None = None


Piece = LineTo | ArcTo | BezierTo | SplineTo


def end_of(piece: Piece) -> Point:
    """The point at which a piece ends."""
    return as_point(piece.through[-1] if isinstance(piece, SplineTo) else piece.to)


def polygon(points: Sequence[Sequence[float]], labels: Sequence[str] | None = None, label: str | None = None) -> Ring:
    """Polygon through ``points`` (n, 2); ``labels`` name the sides, the first from point 0 to point 1.

    CaseError if there are not as many labels as sides, or a coordinate is not a number.
    """
    if len(points) == 0:
        raise GeometryError("a polygon has no points: give at least three")
    corners = [as_point(point) for point in points]
    if len(corners) > 1 and corners[0] == corners[-1]:
        corners.pop()
    names = list(labels) if labels is not None else [label] * len(corners)
    if len(names) != len(corners):
        raise CaseError(f"labels: must be one per side: {counted(len(names), 'label')} for {len(corners)} sides")
    pieces = [LineTo(corner, name) for corner, name in zip(corners[1:] + corners[:1], names, strict=True)]
    return path(corners[0], pieces, label)


def rectangle(
    x0: float, y0: float, x1: float, y1: float, labels: Sequence[str] | None = None, label: str | None = None
) -> Ring:
    """Rectangle with opposite corners (x0, y0) and (x1, y1); sides in the order bottom, right, top, left."""
    (x0, x1), (y0, y1) = sorted([x0, x1]), sorted([y0, y1])
    return polygon([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], labels, label)


def circle(center: Sequence[float], radius: float, label: str | None = None) -> Ring:
    """Whole circle. CaseError if ``center`` is not two numbers, or ``radius`` is not a number greater than 0."""
    whole = Arc(_pair(center, "circle: center"), _number(radius, "circle: radius", above=0), 0.0, 2 * np.pi)
    return Ring((Side(whole, label),), ())


def ellipse(center: Sequence[float], radii: Sequence[float], angle: float = 0.0, label: str | None = None) -> Ring:
    """Whole ellipse whose first axis is turned by ``angle`` degrees.

    CaseError if ``center`` is not two numbers, ``radii`` are not two greater than 0, or ``angle`` is not a number.
    """
    half_axes = _pair(radii, "ellipse: radii", above=0)
    turned = np.radians(_number(angle, "ellipse: angle"))
    whole = Ellipse(_pair(center, "ellipse: center"), half_axes, float(turned), 1.0)
    return Ring((Side(whole, label),), ())


def path(start: Sequence[float], pieces: Sequence[Piece], label: str | None = None) -> Ring:
    """Ring from ``start`` along ``pieces``, closed by a straight line where it does not end at its start.

    Consecutive points that coincide are merged, with a note. CaseError if a coordinate is not a number; GeometryError
    if an arc's ends are not equally far from its centre, or fewer than three points remain.
    """
    first = as_point(start)
    ends = [end_of(piece) for piece in pieces]
    corners = np.array([first, *ends])
    require_numbers(corners, "ring")
    tolerance = 1e-13 * float(np.ptp(corners, axis=0).max())
    if ends and _same(ends[-1], first, tolerance):
        ends[-1] = first
    else:
        pieces, ends = [*pieces, LineTo(first, label)], [*ends, first]
    sides, vertices, notes, lost = _sides(first, pieces, ends, tolerance, label)
    vertices.pop()
    if all(isinstance(side.curve, Line) for side in sides):
        _require_three(vertices, first)
    return Ring(tuple(sides), tuple(vertices), notes, lost=lost)


def straight_ring(vertices: Sequence[Point], label: str | None = None) -> Ring:
    """Ring with straight sides between ``vertices``, no two of which in a row are the same.

    GeometryError if fewer than three are different.
    """
    _require_three(vertices, vertices[0])
    lines = map(Line, vertices, [*vertices[1:], vertices[0]])
    return Ring(tuple(map(Side, lines, repeat(label))), tuple(vertices))


def require_numbers(points: Floats, argument: str) -> None:
    """Check coordinates (n, 2) of points in an argument; CaseError if one is not a number, or too large."""
    bad = np.flatnonzero(~(np.abs(points) <= LARGEST_NUMBER).all(axis=1))
    if len(bad):
        raise CaseError(f"{argument}: point {bad[0]} has a coordinate that is no number, or above {LARGEST_NUMBER:g}")


def _number(value: float, argument: str, above: float = -np.inf) -> float:
    """The argument as a number; CaseError if it is not a number, or not above a bound."""
    if not (is_real(value) and value > above and abs(value) <= LARGEST_NUMBER):
        least = "" if above == -np.inf else f" greater than {above:g}"
        raise CaseError(f"{argument}: must be a number{least} (found {value!r})")
    return float(value)


def _pair(values: Sequence[float], argument: str, above: float = -np.inf) -> Point:
    """The argument as two numbers; CaseError if it is not two numbers, or they are not above a bound."""
    if not isinstance(values, Sequence | np.ndarray) or len(values) != 2:
        raise CaseError(f"{argument}: must be two numbers (found {values!r})")
    return _number(values[0], argument, above), _number(values[1], argument, above)


def _require_three(vertices: Sequence[Point], first: Point) -> None:
    """Refuse a ring of straight sides from ``first`` on that has fewer than three different vertices."""
    if len(set(vertices)) < 3:
        raise GeometryError(f"the ring at {place(first)} has fewer than three different points: give at least three")


def open_path(start: Sequence[float], pieces: Sequence[Piece], label: str) -> OpenPath:
    """Open line from ``start`` along ``pieces``.

    GeometryError if an arc's ends are not equally far from its centre, or the line has no length.
    """
    sides, vertices, notes, lost = _sides(as_point(start), pieces, [end_of(piece) for piece in pieces])
    if not sides:
        raise GeometryError(f"the line at {place(vertices[0])} has no length: give it two different points")
    return OpenPath(tuple(sides), tuple(vertices), label, notes, lost=lost)


def _sides(
    start: Point, pieces: Sequence[Piece], ends: Sequence[Point], tolerance: float = 0.0, label: str | None = None
) -> tuple[list[Side], list[Point], tuple[str, ...], tuple[str, ...]]:
    """Sides along the pieces, the start and all ends, notes on what was merged or mended, and labels lost by that."""
    points = [start, *ends]
    if all(isinstance(piece, LineTo) for piece in pieces) and not _has_doubles(points, tolerance):
        # As most rings of files, some of which have very many points.
        lines = map(Line, points, ends)
        return [Side(line, piece.label or label) for line, piece in zip(lines, pieces, strict=True)], points, (), ()
    sides = list[Side]()
    vertices = [start]
    notes = list[str]()
    doubles, merged = list[Point](), list[str | None]()  # points, and labels of the sides that end there
    for piece, end in zip(pieces, ends, strict=True):
        here = vertices[-1]
        if isinstance(piece, LineTo) and _same(here, end, tolerance):
            doubles.append(end)
            merged.append(piece.label or label)
            continue
        curve, mended = _curve(here, piece, end)
        sides.append(Side(curve, piece.label or label))
        vertices.append(end)
        notes += mended
    kept = {side.label for side in sides}
    lost = tuple(name for name in dict.fromkeys(merged) if name is not None and name not in kept)
    return sides, vertices, (*_merged(doubles, lost), *notes), lost


def _has_doubles(points: Sequence[Point], tolerance: float) -> bool:
    """Whether two points in a row are the same."""
    return bool((np.abs(np.diff(np.array(points), axis=0)).max(axis=1) <= tolerance).any())


def _merged(doubles: Sequence[Point], lost: Sequence[str]) -> list[str]:
    """Notes on points that were given twice in a row, and on labels that were lost with the sides between them."""
    gone = f"left out: {counted(len(lost), 'side')} without length, labelled {listed(list(map(repr, lost)))}"
    return [*_duplicates(doubles), *([gone] if lost else [])]


def _duplicates(doubles: Sequence[Point]) -> list[str]:
    """Notes on points that were given twice in a row."""
    if len(doubles) > MOST_NAMED:
        return [f"{len(doubles)} duplicate points merged, the first at {place(doubles[0])}"]
    return [f"duplicate point {place(point)} merged" for point in doubles]


def _curve(start: Point, piece: Piece, end: Point) -> tuple[Curve, list[str]]:
    """The curve of ``piece`` between two vertices, and notes on what was mended."""
    match piece:
        case LineTo():
            return Line(start, end), []
        case ArcTo():
            return _arc(start, piece, end)
        case BezierTo():
            require_numbers(np.array([piece.first, piece.second]), "inner points of a curve")
            return Bezier(start, piece.first, piece.second, end), []
        case SplineTo():
            return _spline(start, piece, end)


def _spline(start: Point, piece: SplineTo, end: Point) -> tuple[Spline, list[str]]:
    """Spline between two vertices, without knots that are there twice in a row, and notes on these."""
    knots = np.array([start, *piece.through[:-1], end], float)
    require_numbers(knots, "spline")
    repeated = np.flatnonzero((np.diff(knots, axis=0) == 0).all(axis=1))
    notes = [f"duplicate spline point {place(knots[i])} merged" for i in repeated]
    knots = np.delete(knots, repeated, axis=0)
    if len(knots) < 2 or (len(knots) < 4 and start == end):
        raise GeometryError(f"the spline at {place(start)} has too few different points to be a curve")
    spline = Spline(knots)
    _ = spline.fitted  # raises an error for knots that are too near to each other
    return spline, notes


def _arc(start: Point, piece: ArcTo, end: Point) -> tuple[Arc, list[str]]:
    """Arc between two vertices; its centre is moved to the nearest point that is equally far from both."""
    require_numbers(np.array([piece.center]), "center of an arc")
    p, q, center = np.array(start), np.array(end), np.array(piece.center, float)
    radii = np.hypot(*(p - center)), np.hypot(*(q - center))
    if max(radii) == 0:
        raise GeometryError(f"the arc at {place(start)} has its center and both ends in one point: move its center")
    mismatch = abs(radii[0] - radii[1]) / max(radii)
    if mismatch > ARC_MISMATCH:
        one, other = two_places(start, end)
        raise GeometryError(
            f"the arc from {one} to {other} is {radii[0]:.6g} from its center {place(piece.center)} at "
            f"one end and {radii[1]:.6g} at the other: correct the center or an end"
        )
    if start != end:
        chord = q - p
        if np.hypot(*chord) <= FLATTEST_ARC * max(radii):
            one, other = two_places(start, end)
            raise GeometryError(
                f"the arc from {one} to {other} has a radius of {max(radii):.3g}, too large for ends so "
                "near to each other: use a straight line, or the same point at both ends for a whole circle"
            )
        center = center - chord * (((center - p) @ chord) / (chord @ chord) - 0.5)
    notes = []
    if mismatch > 1e-9:
        one, other = two_places(start, end)
        notes.append(f"center of the arc from {one} to {other} moved by {mismatch:.1e} of its radius")
    (ux, uy), (wx, wy) = p - center, q - center
    first, turned = np.arctan2(uy, ux), np.arctan2(ux * wy - uy * wx, ux * wx + uy * wy)
    if piece.left and turned <= 0:
        turned += 2 * np.pi
    elif not piece.left and turned >= 0:
        turned -= 2 * np.pi
    return Arc(as_point(center), float(np.hypot(ux, uy)), float(first), float(turned)), notes


def _same(a: Sequence[float], b: Sequence[float], tolerance: float) -> bool:
    return max(abs(a[0] - b[0]), abs(a[1] - b[1])) <= tolerance
