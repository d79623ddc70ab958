"""Shapes of Python programs: polygons and lines of shapely, and arrays of points."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np
import shapely
from numpy.typing import ArrayLike

from bubblemesh.arrays import Floats, unmasked
from bubblemesh.errors import CaseError, GeometryError, Key, about
from bubblemesh.geometry import rings
from bubblemesh.geometry.paths import Ring
from bubblemesh.records import record

Shape: TypeAlias = "shapely.Polygon | shapely.MultiPolygon | ArrayLike"

A_RING = "the points (n, 2) of a ring"


@record
class ProgramPoints:
    """Points (m, 2), and the argument that has them."""

    points: Floats
    argument: str

    def ring(self, label: str | None) -> Ring:
        """The ring through the points."""
        with about(Key([self.argument])):
            return replace(rings.polygon(self.points.tolist(), label=label), key=Key([self.argument]))


def areas_of(shape: Any, argument: str, expected: str) -> list[list[ProgramPoints]]:
    """Rings of each area of a shape, the outer one first.

    CaseError, with what is ``expected``, if it is no polygon and no array of points; GeometryError if it is empty.
    """
    if not isinstance(shape, shapely.Geometry):
        return [[points_of(shape, argument, expected)]]
    if not isinstance(shape, shapely.Polygon | shapely.MultiPolygon):
        raise CaseError(f"{argument}: must be {expected} (found {_named(shape, 'polygon')})")
    single = isinstance(shape, shapely.Polygon)
    polygons = _filled(shape, argument, "polygon")
    return [_rings(part, argument if single else f"{argument}.geoms[{k}]") for k, part in polygons]


def lines_of(shape: Any, argument: str, expected: str) -> list[ProgramPoints]:
    """Points of each line of a shape.

    CaseError, with what is ``expected``, if it is no line and no array of points; GeometryError if it is empty.
    """
    if not isinstance(shape, shapely.Geometry):
        return [some_points_of(shape, argument, expected, "line")]
    if not isinstance(shape, shapely.LineString | shapely.MultiLineString):
        raise CaseError(f"{argument}: must be {expected} (found {_named(shape, 'line')})")
    return [
        points_of(shapely.get_coordinates(line), argument, expected) for _, line in _filled(shape, argument, "line")
    ]


def points_of(given: Any, argument: str, expected: str = A_RING) -> ProgramPoints:
    """Points as an array; CaseError, with what is ``expected``, if they are no finite numbers (n, 2)."""
    try:
        array = np.asarray(unmasked(given))
    except ValueError:  # rows of unequal length
        raise CaseError(f"{argument}: must be {expected} (found rows of unequal length)") from None
    if array.dtype.kind not in "iuf":
        raise CaseError(f"{argument}: must be {expected} (found {_no_numbers(array, given)})")
    if array.ndim != 2 or array.shape[1] != 2:
        raise CaseError(f"{argument}: must be {expected} (found the shape {array.shape})")
    array = array.astype(float)  # the limit is no number of smaller types
    rings.require_numbers(array, argument)
    return ProgramPoints(array, argument)


def _no_numbers(array: Any, given: Any) -> str:
    """What is given in place of real numbers, and what makes such of it; ``array`` is NumPy's of it."""
    if array.ndim and isinstance(array.flat[0] if array.size else None, shapely.Geometry):
        return "several shapes: shapely.union_all makes one of them"
    if array.ndim == 0 or not isinstance(given, np.ndarray):
        return type(given).__name__
    if array.dtype.kind == "c":
        return f"an array of {array.dtype}: column_stack([z.real, z.imag]) makes coordinates of it"
    return f"an array of {array.dtype}: astype(float) makes numbers of it"


def some_points_of(given: Any, argument: str, expected: str, noun: str) -> ProgramPoints:
    """Points as of `points_of`, of what the noun names; GeometryError if there are none."""
    found = points_of(given, argument, expected)
    if len(found.points) == 0:
        raise _empty(argument, noun)
    return found


def list_of(given: Any, argument: str) -> "Sequence[Any] | Floats":
    """Rings, one after the other; CaseError if they are not a list."""
    if not isinstance(given, Sequence | np.ndarray):
        raise CaseError(f"{argument}: must be a list of rings, arrays (n, 2) of points (found {type(given).__name__})")
    return given


def _rings(polygon: shapely.Polygon, argument: str) -> list[ProgramPoints]:
    named = [(polygon.exterior, f"{argument}.exterior")]
    named += [(hole, f"{argument}.interiors[{k}]") for k, hole in enumerate(polygon.interiors)]
    return [points_of(shapely.get_coordinates(ring), name) for ring, name in named]


def _named(shape: shapely.Geometry, noun: str) -> str:
    """The kind of a shape; of one with others beside some that the noun names, how to get these."""
    mixed = isinstance(shape, shapely.GeometryCollection)
    return f"{type(shape).__name__}{f': take the {noun}s among its geoms alone' if mixed else ''}"


def _filled(shape: shapely.Geometry, argument: str, noun: str) -> list[tuple[int, Any]]:
    """Parts of a shape that are not empty, with their numbers in it; GeometryError if there is none."""
    parts = [(k, part) for k, part in enumerate(shapely.get_parts(shape).tolist()) if not part.is_empty]
    if not parts:
        raise _empty(argument, noun)
    return parts


def _empty(argument: str, noun: str) -> GeometryError:
    """Error about an argument in which there is nothing, so that its name would be lost."""
    error = GeometryError(f"the {noun} is empty")
    error.about = Key([argument])
    return error
