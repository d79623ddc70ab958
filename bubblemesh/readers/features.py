"""Content of a file, as every reader gives it: features with areas, closed rings and curves that may form rings."""

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import LARGEST_NUMBER
from bubblemesh.errors import BubblemeshError, CaseError, GeometryError, prefixed
from bubblemesh.files import FORBIDDEN, is_writable
from bubblemesh.geometry import rings
from bubblemesh.geometry.paths import Point, Ring
from bubblemesh.geometry.rings import LineTo, Piece, end_of
from bubblemesh.messages import place, shown

LONGEST_NAME = 80  # characters
NO_HEIGHTS = "heights (z) are not used"  # a note


@contextmanager
def foreign(problem: str, advice: str) -> Iterator[None]:
    """Any error of a library that reads a file is a CaseError with the problem, but for one of too little memory."""
    try:
        yield
    except (BubblemeshError, MemoryError):
        raise
    except Exception as error:  # readers of foreign formats fail in any way
        raise CaseError(f"{problem}: {shown(error) or type(error).__name__}: {advice}") from error


class CompoundCurve(NamedTuple):
    """A curve from ``start`` along ``pieces``, closed or a part of a ring; ``name`` is what messages call it."""

    start: Point
    pieces: tuple[Piece, ...]
    name: str

    @property
    def end(self) -> Point:
        return end_of(self.pieces[-1])


@dataclass(frozen=True)
class Feature:
    """One thing of a file."""

    name: str  # what messages call it
    layer: str | None = None
    properties: Mapping[str, Any] = field(default_factory=dict)  # by which a case may choose it
    areas: tuple[tuple[Ring, ...], ...] = ()  # outer rings, each with its holes
    rings: tuple[Ring, ...] = ()  # closed curves; how they nest tells which are holes
    curves: tuple[CompoundCurve, ...] = ()  # that form rings together
    notes: tuple[str, ...] = ()  # on what was left out of it


@dataclass(frozen=True)
class FeatureCollection:
    """All that a reader finds in a file."""

    features: tuple[Feature, ...]
    notes: tuple[str, ...] = ()  # on what was changed or left out
    hole_points: tuple[Point, ...] | None = None  # in the holes, where the format has them
    unit: str | None = None  # of length, if the file names it


def finite_points(points: Sequence[Sequence[float]], name: str) -> list[Point]:
    """The points as pairs of numbers, z left out; CaseError if a coordinate is no finite number."""
    try:
        array = np.array([(point[0], point[1]) for point in points], float).reshape(-1, 2)
    except (TypeError, ValueError, IndexError):
        raise CaseError(f"{name}: coordinates must be pairs of numbers") from None
    bad = np.flatnonzero(~(np.abs(array) <= LARGEST_NUMBER).all(axis=1))
    if len(bad):
        where, most = f"point {bad[0] + 1} at {place(array[bad[0]])}", f"{LARGEST_NUMBER:g}"
        raise CaseError(f"{name}: {where}: coordinates must be finite and at most {most}")
    return [(x, y) for x, y in array.tolist()]


def polygon_ring(points: Sequence[Point], name: str, label: str | None = None) -> Ring:
    """Polygon that comes from the place ``name`` of a file; fewer than three different points are a GeometryError."""
    with prefixed(name):
        return replace(rings.polygon(points, label=label), origin=name)


def feature_name(number: int, properties: Mapping[str, Any], *keys: str) -> str:
    """Name of a feature in messages: its number, and the first of the keys that has a short printable value."""
    shown = _text(properties, *keys)
    short = shown is not None and shown.isprintable() and len(shown) <= LONGEST_NAME
    return f"feature {number} ({shown})" if short else f"feature {number}"


def writable_label(label: str | None, name: str) -> tuple[str | None, tuple[str, ...]]:
    """The label if mesh files can hold it; else none, and a note."""
    if label is None or is_writable(label):
        return label, ()
    return None, (f"{name}: {label[:40]!r} is no label, since it is too long or has {FORBIDDEN} in it",)


def feature_of(
    shape: shapely.Geometry, name: str, layer: str | None = None, properties: Mapping[str, Any] | None = None
) -> Feature:
    """Feature of one of shapely's shapes: polygons are areas, lines join into rings.

    Its property ``label``, else ``name``, names outer rings and lines, ``hole_label`` the holes. CaseError if it has
    points, which bound nothing, or coordinates that are no finite numbers; GeometryError if a ring has fewer than three
    different points.
    """
    label, notes = writable_label(_text(properties or {}, "label", "name"), name)
    hole_label, more = writable_label(_text(properties or {}, "hole_label"), name)
    areas: list[tuple[Ring, ...]] = []
    curves: list[CompoundCurve] = []
    for part in _simple_parts(shape):
        if part.geom_type == "Polygon":
            holes = [_ring(hole, f"{name}, hole {k}", hole_label) for k, hole in enumerate(part.interiors, start=1)]
            areas.append((_ring(part.exterior, name, label), *holes))
        elif part.geom_type in ("LineString", "LinearRing"):
            start, *others = points = finite_points(shapely.get_coordinates(part), name)
            if len(set(points)) < 2:
                raise GeometryError(f"{name}: the line has fewer than two different points")
            curves.append(CompoundCurve(start, tuple(LineTo(point, label) for point in others), name))
        else:
            raise CaseError(f"{name}: a {part.geom_type} bounds no area: give polygons or lines, or choose a feature")
    if not areas and not curves:
        raise CaseError(f"{name}: it is empty: remove it, or choose another feature")
    return Feature(name, layer, properties or {}, tuple(areas), (), tuple(curves), (*notes, *more))


def _ring(loop: shapely.LinearRing, name: str, label: str | None) -> Ring:
    return polygon_ring(finite_points(shapely.get_coordinates(loop), name), name, label)


def _simple_parts(shape: shapely.Geometry) -> list[shapely.Geometry]:
    """Points, lines and polygons of a shape that may be a collection of collections."""
    parts = shapely.get_parts(shape).tolist()
    if len(parts) == 1 and parts[0].geom_type == shape.geom_type:
        return [shape] if not shape.is_empty else []
    return [simple for part in parts for simple in _simple_parts(part)]


def _text(properties: Mapping[str, Any], *keys: str) -> str | None:
    """The text or number of the first of the keys, in any case, that has one."""
    values = {str(key).lower(): value for key, value in properties.items()}
    return next(filter(None, (_as_text(values.get(key)) for key in keys)), None)


def _as_text(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:g}" if math.isfinite(value) else ""
    return str(value).strip() if isinstance(value, str | int) and not isinstance(value, bool) else ""
