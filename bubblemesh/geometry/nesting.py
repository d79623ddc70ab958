"""Nesting of shapes: areas within each other become areas with holes, and holes find the area around."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from bubblemesh.arrays import Integers
from bubblemesh.errors import GeometryError, about
from bubblemesh.geometry.paths import Area, Ring, outlines
from bubblemesh.geometry.validity import first_place

Shapes = NDArray[np.object_]  # of polygons, not valid ones where rings cross


def shapes_of(areas: Sequence[Area]) -> Shapes:
    """Polygonal copies (n,) of areas, with their holes."""
    outlines(ring for area in areas for ring in area.rings)
    return np.array(
        [shapely.Polygon(area.outer.outline, [hole.outline for hole in area.holes]) for area in areas], dtype=object
    )


def polygons_of(shapes: shapely.Geometry | Shapes) -> list[shapely.Polygon]:
    """The polygons with an area that a shape of any kind, or several (n,), consist of."""
    parts = shapely.get_parts(shapely.get_parts(shapes))  # twice, since parts of collections may have parts
    return parts[shapely.area(parts) > 0].tolist()


def made_valid(shapes: shapely.Geometry | Shapes) -> Any:
    """A shape that is valid, or several (n,): all places around which its rings turn, without parts of no area."""
    return shapely.make_valid(shapes, method="structure", keep_collapsed=False)


def holes_of(shapes: shapely.Geometry | Shapes) -> Shapes:
    """The holes (h,) of a shape, or of several (n,), as polygons."""
    loops = [ring for part in shapely.get_parts(shapes) for ring in part.interiors]
    return shapely.polygons(np.array(loops, dtype=object))


def nested(areas: Sequence[Area], whole: int = 0) -> list[Area]:
    """Areas after nesting: areas within others become holes of these, areas within such holes are areas again.

    The first ``whole`` ones stay areas: one of them that lies only partly within another is not a hole of it.
    """
    shapes = shapes_of(areas)
    within, around = enclosures(shapes, shapes)
    partly = (within < whole) & (around < whole) & ~shapely.covers(_solid(shapes[around]), shapes[within])
    within = within[~partly]
    removed = np.bincount(within, minlength=len(areas)) % 2 == 1
    kept = [area for area, away in zip(areas, removed, strict=True) if not away]
    taken = [area for area, away in zip(areas, removed, strict=True) if away]
    kept += [Area(ring) for area in taken for ring in area.holes]
    return with_holes(kept, [area.outer for area in taken])


def with_holes(areas: Sequence[Area], holes: Sequence[Ring]) -> list[Area]:
    """The areas with more holes, each of the smallest area whose outer ring is around it.

    GeometryError, about the hole's key, if there are several areas and it is in none of them.
    """
    if len(areas) == 1 or not holes:
        return [replace(area, holes=(*area.holes, *holes)) for area in areas]
    inner, around = (shapes_of([Area(ring) for ring in some]) for some in (holes, [area.outer for area in areas]))
    owner = smallest_around(inner, around)
    more: list[list[Ring]] = [[] for _ in areas]
    for ring, shape, number in zip(holes, inner, owner.tolist(), strict=True):
        if number < 0:
            with about(ring.key):
                raise GeometryError(f"the hole at {first_place(shape)} lies in none of the areas: move or remove it")
        more[number].append(ring)
    return [replace(area, holes=(*area.holes, *rings)) for area, rings in zip(areas, more, strict=True)]


def without_outside_holes(areas: Sequence[Area], holes: Sequence[Area]) -> tuple[list[Area], int]:
    """The holes that are needed or have something in common with areas, and the number of the others."""
    optional = [number for number, hole in enumerate(holes) if hole.outer.optional]
    if not optional:
        return list(holes), 0
    solid = shapes_of([Area(holes[number].outer) for number in optional])
    hole, area = shapely.STRtree(shapes_of(areas)).query(solid, predicate="intersects")
    inner = ~shapely.touches(solid[hole], shapes_of(areas)[area])
    gone = {*optional} - {optional[number] for number in hole[inner].tolist()}
    return [each for number, each in enumerate(holes) if number not in gone], len(gone)


def smallest_around(inner: Shapes, around: Shapes) -> Integers:
    """Numbers (n,) of the smallest shapes around inner ones (n,), -1 for those that are not within any."""
    within, outer = enclosures(inner, around)
    order = np.argsort(-shapely.area(around)[outer], kind="stable")  # the last one written stays
    owner = np.full(len(inner), -1)
    owner[within[order]] = outer[order]
    return owner


def thick(shape: shapely.Geometry, thin: float) -> shapely.MultiPolygon:
    """The polygons of a shape, and their holes, that are wider than ``thin``."""
    holed = []
    for part in polygons_of(shape):
        if part.area <= thin * part.length:
            continue
        holes = [hole for hole in part.interiors if shapely.Polygon(hole).area > thin * hole.length]
        holed.append(shapely.Polygon(part.exterior, holes) if len(holes) < len(part.interiors) else part)
    return shapely.MultiPolygon(holed)


def _solid(shapes: Shapes) -> Shapes:
    """The shapes without their holes."""
    return shapely.polygons(shapely.get_exterior_ring(shapes))


def enclosures(inner: Shapes, around: Shapes) -> tuple[Integers, Integers]:
    """Numbers (k,) of inner shapes, and (k,) of larger ones that each of them lies within, unless they cross."""
    outer, within = shapely.STRtree(shapely.point_on_surface(inner)).query(around, predicate="contains")
    larger = shapely.area(around)[outer] > shapely.area(inner)[within]  # what is around a lake is not its island
    return within[larger], outer[larger]
