"""Content of a file, as all readers return it: features with areas, closed rings and curves that may form rings."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import field, replace
from functools import cached_property, reduce
from itertools import pairwise
from operator import add
from typing import Any, NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import LARGEST_NUMBER, Floats
from bubblemesh.errors import BubblemeshError, CaseError
from bubblemesh.files import FORBIDDEN, is_writable
from bubblemesh.geometry import rings
from bubblemesh.geometry.paths import Area, Point, Ring
from bubblemesh.geometry.rings import LineTo, Piece, end_of
from bubblemesh.messages import cause, place
from bubblemesh.process.shared import warnings_are
from bubblemesh.readers.slips import Slips, clean_loop, has_slips
from bubblemesh.records import record

LONGEST_NAME = 80  # characters
NO_HEIGHTS = "heights (z) are not used"  # a note
FILL, HIDDEN, REGION, INNER = "fill", "hidden", "region", "inner"
SPARE = (
    FILL,
    HIDDEN,
    REGION,
    INNER,
)  # kinds of features that are used only if there are no others, the first before the second


@contextmanager
def foreign(problem: str, advice: str) -> Iterator[None]:
    """Within the block, turn errors of a library, except MemoryError, into a CaseError with a problem and an advice.

    Warnings of the library are not printed.
    """
    try:
        with warnings_are("ignore"):
            yield
    except (BubblemeshError, MemoryError):
        raise
    except Exception as error:  # libraries raise all kinds of errors for damaged files
        raise CaseError(f"{problem}: {cause(error)}: {advice}") from error


@record
class CompoundCurve:
    """A curve from ``start`` along ``pieces``, closed or a part of a ring; messages call it ``name``."""

    start: Point
    pieces: tuple[Piece, ...]
    name: str

    @property
    def end(self) -> Point:
        return end_of(self.pieces[-1])

    @cached_property
    def ring(self) -> Ring:
        """The ring along the curve, closed by a straight line if it is open; made once, since its outline is kept.

        The same errors as `rings.path`.
        """
        return replace(rings.path(self.start, self.pieces), origin=self.name)


@record(eq=False)
class Clip:
    """Clip of features: only what is inside of some areas is visible, or only what is outside."""

    areas: tuple[Area, ...]
    outside: bool = False


@record
class Feature:
    """One item of a file: a feature of a map, an entity or an element of a drawing."""

    name: str  # in messages
    layer: str | None = None
    properties: Mapping[str, Any] = field(default_factory=dict)  # by which a case may choose it
    areas: tuple[tuple[Ring, ...], ...] = ()  # outer rings, each with its holes
    rings: tuple[Ring, ...] = ()  # closed curves; their nesting shows which are holes
    curves: tuple[CompoundCurve, ...] = ()  # that form rings together
    notes: tuple[str, ...] = ()  # on what was left out of it
    points: tuple[Point, ...] = ()
    slips: Slips = field(default_factory=Slips)  # what was dropped from it
    spare: str | None = None  # one of `SPARE`, if it is used only if there is nothing else
    largest: float | None = None  # area of a triangle in it, where the file says so
    clips: tuple[Clip, ...] = ()  # it is visible only through all of them

    @property
    def is_empty(self) -> bool:
        """Whether it has nothing that could be used."""
        return not (self.bounds or self.points)

    @property
    def bounds(self) -> bool:
        """Whether anything in it may bound an area."""
        return bool(self.areas or self.rings or self.curves)


class PhysicalLength(NamedTuple):
    """Length on paper of the unit of a file."""

    metres: float
    assumed: bool  # whether the file does not give it


@record
class FeatureCollection:
    """Content of a file, as a reader returns it."""

    features: tuple[Feature, ...]
    notes: tuple[str, ...] = ()  # on what was changed or left out
    hole_points: tuple[Point, ...] | None = None  # points in holes, if the format has them
    unit: str | None = None  # of length, if the file names it
    physical: PhysicalLength | None = None  # size of the file's unit on paper, if numbers of the format have no unit
    system: str | None = None  # of the coordinates, as the file names it or as well-known text
    degrees: bool | None = False  # whether coordinates are degrees; None if that has to be guessed from them
    absent: str | None = None  # the file beside it that would hold the properties, if there is none

    def require_properties(self) -> None:
        """Check that properties were read; CaseError if the file that would hold them is absent."""
        if self.absent is not None:
            raise CaseError(
                f"there is no {self.absent} beside it, which holds the properties of its features: copy it along"
            )


def vertices_of(features: Iterable[Feature]) -> Floats:
    """Points (n, 2) of features: vertices of rings, ends of the pieces of curves, outlines of whole circles, points."""
    points: list[Sequence[Point] | Floats] = []
    for one in features:
        rings = (*(ring for area in one.areas for ring in area), *one.rings)
        points += [ring.vertices or ring.outline for ring in rings]
        points += [(curve.start, *map(end_of, curve.pieces)) for curve in one.curves]
        points.append(one.points)
    return np.concatenate([np.array(some, float).reshape(-1, 2) for some in (*points, ())])


def finite_points(points: Sequence[Sequence[float]] | Floats, name: str) -> list[Point]:
    """The points as pairs of numbers, without z; CaseError if a coordinate is not a finite number."""
    try:
        array = _pairs(points)
    except (TypeError, ValueError, LookupError, OverflowError):
        raise CaseError(f"{name}: coordinates must be pairs of numbers") from None
    bad = np.flatnonzero(~(np.abs(array) <= LARGEST_NUMBER).all(axis=1))
    if len(bad):
        where, most = f"point {bad[0] + 1} at {place(array[bad[0]])}", f"{LARGEST_NUMBER:g}"
        raise CaseError(f"{name}: {where}: coordinates must be finite and at most {most}")
    return list(map(tuple, array.tolist()))


def _pairs(points: Sequence[Sequence[float]] | Floats) -> Floats:
    """Array (n, 2) of the points, without z; TypeError, ValueError or IndexError if they are not pairs of numbers."""
    with suppress(TypeError, ValueError):  # at once if all have the same number of coordinates, as most do
        array = np.array(points, float)
        if array.ndim == 2 and array.shape[1] >= 2:
            return array[:, :2]
    return np.array([(point[0], point[1]) for point in points], float).reshape(-1, 2)


def polygon_ring(points: Sequence[Point], name: str, label: str | None = None) -> tuple[Ring | None, Slips]:
    """Polygon through points, named ``name`` in messages, and what was dropped from it; None if it has no area."""
    if len(points) == 0:
        return None, Slips()
    corners = list(points[:-1] if len(points) > 1 and points[-1] == points[0] else points)
    first, *others = corners
    ends = [*others, first]
    if not has_slips(np.array([first, *ends], float)):
        return replace(rings.straight_ring(corners, label), origin=name), Slips()
    start, pieces, slips = clean_loop(first, list(map(LineTo, ends)))
    if not pieces:
        return None, slips
    return replace(rings.path(start, pieces, label), origin=name), slips


def feature_name(number: int, properties: Mapping[str, Any], *keys: str) -> str:
    """Name of a feature in messages: its number, and the value of the first key with a short printable one."""
    shown = text_of(properties, *keys)
    short = shown is not None and shown.isprintable() and len(shown) <= LONGEST_NAME
    return f"feature {number} ({shown})" if short else f"feature {number}"


def writable_label(label: str | None, name: str) -> tuple[str | None, tuple[str, ...]]:
    """The label if mesh files can hold it; else None and a note."""
    if label is None or is_writable(label):
        return label, ()
    return None, (f"{name}: {label[:40]!r} is no label, since it is too long or has {FORBIDDEN} in it",)


class SimpleParts(NamedTuple):
    """Simple parts of a geometry, as lists of positions (x, y, and more that is not used)."""

    polygons: list[list[Sequence[Any]]]  # outer ring and holes of each
    lines: list[Sequence[Any]]
    points: list[Any]


NO_PARTS = SimpleParts([], [], [])


def parts_of(shape: shapely.Geometry) -> SimpleParts:
    """Parts of one of shapely's shapes, which may be a collection of collections."""
    parts = SimpleParts([], [], [])
    for part in _simple_parts(shape):
        if part.geom_type == "Polygon":
            parts.polygons.append([shapely.get_coordinates(loop) for loop in (part.exterior, *part.interiors)])
        elif part.geom_type == "Point":
            parts.points.extend(shapely.get_coordinates(part))
        else:
            parts.lines.append(shapely.get_coordinates(part))
    return parts


def _simple_parts(shape: shapely.Geometry) -> list[shapely.Geometry]:
    if shape.is_empty:
        return []
    parts = shapely.get_parts(shape).tolist()
    if len(parts) == 1 and parts[0].geom_type == shape.geom_type:
        return [shape]
    return [simple for part in parts for simple in _simple_parts(part)]


def feature_of(
    parts: SimpleParts, name: str, layer: str | None = None, properties: Mapping[str, Any] | None = None
) -> Feature:
    """Feature of the parts of a geometry: polygons are areas, lines are curves; without parts it is empty.

    Its property ``label``, else ``name``, names outer rings and lines, ``hole_label`` the holes. CaseError if
    coordinates are not finite numbers.
    """
    label, notes = writable_label(text_of(properties or {}, "label", "name"), name)
    hole_label, more = writable_label(text_of(properties or {}, "hole_label"), name)
    areas = [_area(loops, name, label, hole_label) for loops in parts.polygons]
    curves = [line_curve(finite_points(line, name), name, label) for line in parts.lines]
    return Feature(
        name,
        layer,
        properties or {},
        areas=tuple(area for area, _ in areas if area),
        curves=tuple(curve for curve, _ in curves if curve is not None),
        points=tuple(finite_points(parts.points, name)),
        notes=(*notes, *more),
        slips=reduce(add, (slips for _, slips in (*areas, *curves)), Slips()),
    )


def line_curve(points: Sequence[Point], name: str, label: str | None = None) -> tuple[CompoundCurve | None, Slips]:
    """The polyline through the points, and what was dropped from it; None if it has no length."""
    doubles = [point for before, point in pairwise(points) if point == before]
    slips = Slips(doubles=len(doubles), first=doubles[0]) if doubles else Slips()
    kept = [point for k, point in enumerate(points) if k == 0 or point != points[k - 1]]
    if len(kept) < 2:
        return None, slips
    return CompoundCurve(kept[0], tuple(LineTo(point, label) for point in kept[1:]), name), slips


def _area(
    loops: Sequence[Sequence[Any]], name: str, label: str | None, hole_label: str | None
) -> tuple[tuple[Ring, ...], Slips]:
    """Outer ring and holes that have an area, and what was dropped; no rings if the outer one has no area."""
    made, slips = list[Ring](), Slips()
    for number, loop in enumerate(loops):
        called = f"{name}, hole {number}" if number else name
        ring, dropped = polygon_ring(finite_points(loop, called), called, hole_label if number else label)
        slips += dropped
        made += [] if ring is None else [ring]
        if not made:
            break
    return tuple(made), slips


def text_of(properties: Mapping[str, Any], *keys: str) -> str | None:
    """The text or number of the first key, in small or capital letters, that has one; else None."""
    values = {str(key).lower(): value for key, value in properties.items()}
    return next(filter(None, (_as_text(values.get(key)) for key in keys)), None)


def text_of_number(value: float) -> str:
    """A number as a name: whole numbers without a point, others with all digits, so that no two have the same name."""
    return repr(float(value)).removesuffix(".0")


def _as_text(value: Any) -> str:
    if isinstance(value, float):
        return text_of_number(value) if math.isfinite(value) else ""
    return str(value).strip() if isinstance(value, str | int) and not isinstance(value, bool) else ""
