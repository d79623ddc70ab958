"""Features of shapely's shapes: polygons are areas, lines join into rings."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import shapely

from bubblemesh.errors import CaseError, GeometryError
from bubblemesh.geometry import rings
from bubblemesh.geometry.rings import Ring
from bubblemesh.readers.features import Feature, Stroke, checked, fitting, label_of, line


def feature_of(
    shape: shapely.Geometry, name: str, layer: str | None = None, properties: Mapping[str, Any] | None = None
) -> Feature:
    """The feature that a shape makes.

    Its property ``label``, else ``name``, names outer rings and lines, ``hole_label`` the holes.

    Raises
    ------
    CaseError
        If it has points, which bound nothing, or coordinates that are no finite numbers.
    GeometryError
        If a ring has fewer than three different points.
    """
    label, notes = fitting(label_of(properties or {}, "label", "name"), name)
    hole_label, more = fitting(label_of(properties or {}, "hole_label"), name)
    areas: list[tuple[Ring, ...]] = []
    strokes: list[Stroke] = []
    for part in _parts(shape):
        if part.geom_type == "Polygon":
            loops = [part.exterior, *part.interiors]
            holes = [_ring(loop, f"{name}, hole {k}", hole_label) for k, loop in enumerate(loops[1:], start=1)]
            areas.append((_ring(loops[0], name, label), *holes))
        elif part.geom_type in ("LineString", "LinearRing"):
            points = checked(shapely.get_coordinates(part), name)
            if len(set(points)) < 2:
                raise GeometryError(f"{name}: the line has fewer than two different points")
            strokes.append(line(points, name, label))
        else:
            raise CaseError(f"{name}: a {part.geom_type} bounds no area: give polygons or lines, or choose a feature")
    if not areas and not strokes:
        raise CaseError(f"{name}: it is empty: remove it, or choose another feature")
    return Feature(name, layer, properties or {}, tuple(areas), (), tuple(strokes), (*notes, *more))


def _parts(shape: shapely.Geometry) -> list[shapely.Geometry]:
    """The simple shapes of a shape that may be a collection of collections."""
    parts = shapely.get_parts(shape).tolist()
    if len(parts) == 1 and parts[0].geom_type == shape.geom_type:
        return [shape] if not shape.is_empty else []
    return [simple for part in parts for simple in _parts(part)]


def _ring(loop: shapely.LinearRing, name: str, label: str | None) -> Ring:
    points = checked(shapely.get_coordinates(loop), name)
    try:
        return replace(rings.polygon(points, label=label), origin=name)
    except GeometryError as error:
        raise GeometryError(f"{name}: {error}") from None
