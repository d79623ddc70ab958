"""Features of shapely's shapes: polygons are areas, lines join into rings."""

from collections.abc import Mapping
from typing import Any

import shapely

from bubblemesh.errors import CaseError, GeometryError
from bubblemesh.geometry import rings
from bubblemesh.geometry.rings import Ring
from bubblemesh.readers.features import Feature, Stroke, checked, line

__all__ = ["feature_of"]


def feature_of(
    shape: shapely.Geometry, name: str, layer: str | None = None, properties: Mapping[str, Any] | None = None
) -> Feature:
    """The feature that a shape makes.

    Raises
    ------
    CaseError
        If it has points, which bound nothing, or coordinates that are no finite numbers.
    GeometryError
        If a ring has fewer than three different points.
    """
    areas: list[tuple[Ring, ...]] = []
    strokes: list[Stroke] = []
    for part in _parts(shape):
        if part.geom_type == "Polygon":
            loops = [part.exterior, *part.interiors]
            areas.append(tuple(_ring(loop, _loop_name(name, k)) for k, loop in enumerate(loops)))
        elif part.geom_type in ("LineString", "LinearRing"):
            points = checked(shapely.get_coordinates(part), name)
            if len(set(points)) < 2:
                raise GeometryError(f"{name}: the line has fewer than two different points")
            strokes.append(line(points, name))
        else:
            raise CaseError(f"{name}: a {part.geom_type} bounds no area: give polygons or lines, or choose a feature")
    if not areas and not strokes:
        raise CaseError(f"{name}: it is empty: remove it, or choose another feature")
    return Feature(name, layer, properties or {}, tuple(areas), (), tuple(strokes))


def _parts(shape: shapely.Geometry) -> list[shapely.Geometry]:
    """The simple shapes of a shape that may be a collection of collections."""
    parts = shapely.get_parts(shape).tolist()
    if len(parts) == 1 and parts[0].geom_type == shape.geom_type:
        return [shape] if not shape.is_empty else []
    return [simple for part in parts for simple in _parts(part)]


def _loop_name(name: str, number: int) -> str:
    return f"{name}, hole {number}" if number else name


def _ring(loop: shapely.LinearRing, name: str) -> Ring:
    points = checked(shapely.get_coordinates(loop), name)
    try:
        return rings.polygon(points)
    except GeometryError as error:
        raise GeometryError(f"{name}: {error}") from None
