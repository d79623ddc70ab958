"""Do the rings bound a domain? If not, which one does not, where, and what is to be done."""

from collections.abc import Sequence

import numpy as np
import shapely
from shapely.validation import explain_validity

from bubblemesh.arrays import Floats
from bubblemesh.errors import GeometryError, Key, about
from bubblemesh.messages import place

SMALLEST = 1e-70  # extent whose fourth power is still a number
SMALLEST_STEPS = 1e4  # between numbers of that size that a ring has to extend over
FLAT = 1e-12  # area over squared extent below which a ring encloses nothing


def require_domain(outlines: Sequence[Floats], names: Sequence[str], keys: Sequence[Key]) -> None:
    """Check the polygonal copies (m, 2) of the rings, the outer one first, which messages call by their ``names``.

    GeometryError, about the key of the ring in the case, with its name and the coordinates of the first fault.
    """
    polygons: list[shapely.Polygon] = []
    for outline, name, key in zip(outlines, names, keys, strict=True):
        with about(key):
            polygons.append(simple_polygon(outline, name))
    for hole, name, key in zip(polygons[1:], names[1:], keys[1:], strict=True):
        with about(key):
            _require_inside(hole, polygons[0], name)
    holes = np.array(polygons[1:], dtype=object)
    tree = shapely.STRtree(holes)
    for i, j in zip(*tree.query(holes, predicate="intersects"), strict=True):
        if i < j:
            with about(keys[1 + j]):
                _require_apart(polygons[1 + i], polygons[1 + j], names[1 + i], names[1 + j])
    whole = shapely.Polygon(outlines[0], outlines[1:])
    if not whole.is_valid:
        fault, where = _explained(whole)
        raise GeometryError(f"the rings cut the domain in two at {where} ({fault}): give one case for each part")


def simple_polygon(outline: Floats, name: str) -> shapely.Polygon:
    """Polygon of a ring's polygonal copy (m, 2).

    GeometryError, with the ring's name and the coordinates, if it encloses no area, or crosses or touches itself.
    """
    extent = np.ptp(outline, axis=0).max()
    if extent <= SMALLEST_STEPS * np.spacing(np.abs(outline).max()):
        raise GeometryError(
            f"{name} at {place(outline[0])} is as small as the rounding of its coordinates: move it nearer to the "
            "origin, or make it larger"
        )
    if extent <= SMALLEST:
        raise GeometryError(
            f"{name} at {place(outline[0])} is smaller than {SMALLEST:g}: choose another unit of length"
        )
    polygon = shapely.Polygon(outline)
    if polygon.convex_hull.area <= FLAT * extent**2:
        raise GeometryError(f"{name} at {place(outline[0])} encloses no area: its points lie on one line")
    if not polygon.is_valid:
        where = _explained(polygon)[1]
        raise GeometryError(f"{name} crosses or touches itself at {where}: move its points so that it does not")
    return polygon


def _require_inside(hole: shapely.Polygon, outer: shapely.Polygon, name: str) -> None:
    if outer.contains(hole):
        shared = shapely.intersection(outer.exterior, hole.exterior)
        if shared.length > 0:
            raise GeometryError(
                f"{name} shares an edge with the outer ring at {first_place(shared)}: draw the outer ring around it"
            )
        return
    if not outer.intersects(hole):
        raise GeometryError(f"{name} at {first_place(hole.exterior)} lies outside the outer ring: move or remove it")
    crossing = shapely.intersection(outer.exterior, hole.exterior)
    if crossing.is_empty:
        where = first_place(hole.exterior)
        raise GeometryError(f"{name} at {where} encloses the outer ring: make it smaller, or exchange the two")
    where = first_place(crossing)
    raise GeometryError(f"{name} crosses the outer ring at {where}: move it, or draw the outer ring around it")


def _require_apart(a: shapely.Polygon, b: shapely.Polygon, name_a: str, name_b: str) -> None:
    where = first_place(shapely.intersection(a.exterior, b.exterior) if not a.exterior.disjoint(b.exterior) else b)
    if a.contains(b) or b.contains(a):
        inner, around = (name_b, name_a) if a.contains(b) else (name_a, name_b)
        raise GeometryError(f"{inner} lies inside {around} at {where}: remove one of them")
    if shapely.intersection(a, b).area > 0:
        raise GeometryError(f"{name_a} and {name_b} overlap at {where}: join them into one hole")
    if shapely.intersection(a.exterior, b.exterior).length > 0:
        raise GeometryError(f"{name_a} and {name_b} share an edge at {where}: join them into one hole")


def _explained(polygon: shapely.Polygon) -> tuple[str, str]:
    """The fault and its coordinates, from GEOS's text "Self-intersection[x y]"."""
    fault, _, where = explain_validity(polygon).rstrip("]").partition("[")
    return fault, place([float(value) for value in where.split()])


def first_place(shape: shapely.Geometry) -> str:
    """Place of a shape's first vertex, as messages write it."""
    return place(shapely.get_coordinates(shape)[0])
