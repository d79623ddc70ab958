"""Check that rings bound a domain; errors name the ring, the place, and what to do."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import shapely
from shapely.validation import explain_validity

from bubblemesh.arrays import SMALLEST_EXTENT, Floats
from bubblemesh.errors import GeometryError, Key, about
from bubblemesh.geometry.polygonal_copy import PolygonalCopy
from bubblemesh.messages import place
from bubblemesh.records import record

SMALLEST_STEPS = 1e4  # between numbers of that size that a ring has to extend over
CLEARLY = 0.1  # of the smaller of two holes: a larger common area is not due to rounding or chords of curves
FLAT_RING = 1e-12  # area over squared extent below which a ring encloses nothing


def require_domain(copy: PolygonalCopy, names: Sequence[str], keys: Sequence[Key]) -> None:
    """Check the rings of a polygonal copy; ``names`` are those in messages.

    GeometryError, about the key of the ring in the case, with its name and the coordinates of the first fault.
    """
    checked = [_CheckedRing(*ring) for ring in zip(copy.rings(), names, keys, strict=True)]
    owner = np.array(copy.area_of_ring)
    areas = [[checked[ring] for ring in np.flatnonzero(owner == area)] for area in range(1 + max(owner))]
    only = len(areas) == 1
    shapes = np.array([_area(*rings, around="the outer ring" if only else rings[0].name) for rings in areas])
    for i, j in zip(*shapely.STRtree(shapes).query(shapes, predicate="intersects"), strict=True):
        if i < j:
            with about(areas[j][0].key):
                _require_separate(shapes[i], shapes[j], areas[i][0].name, areas[j][0].name)


@record
class _CheckedRing:
    """A ring that may bound a domain: its polygonal copy (m, 2), its name in messages, its key in the case."""

    outline: Floats
    name: str
    key: Key

    @cached_property
    def polygon(self) -> shapely.Polygon:
        """The polygon that the ring encloses."""
        with about(self.key):
            return simple_polygon(self.outline, self.name)


def _area(outer: _CheckedRing, *holes: _CheckedRing, around: str) -> shapely.Polygon:
    """The area between an outer ring, which messages on holes call ``around``, and its holes."""
    for ring in (outer, *holes):
        _ = ring.polygon  # an invalid ring is reported before its position
    for hole in holes:
        with about(hole.key):
            _require_inside(hole.polygon, outer.polygon, hole.name, around)
    polygons = np.array([hole.polygon for hole in holes], dtype=object)
    tree = shapely.STRtree(polygons)
    for i, j in zip(*tree.query(polygons, predicate="intersects"), strict=True):
        if i < j:
            with about(holes[j].key):
                _require_apart(polygons[i], polygons[j], holes[i].name, holes[j].name)
    whole = shapely.Polygon(outer.outline, [hole.outline for hole in holes])
    if not whole.is_valid:
        fault, where = explained(whole)
        raise GeometryError(f"the rings cut the domain in two at {where} ({fault}): give each part an outer ring")
    return whole


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
    if extent <= SMALLEST_EXTENT:
        raise GeometryError(
            f"{name} at {place(outline[0])} is smaller than {SMALLEST_EXTENT:g}: choose another unit of length"
        )
    polygon = shapely.Polygon(outline)
    if polygon.convex_hull.area <= FLAT_RING * extent**2:
        raise GeometryError(f"{name} at {place(outline[0])} encloses no area: its points lie on one line")
    if not polygon.is_valid:
        where = explained(polygon)[1]
        raise GeometryError(f"{name} crosses or touches itself at {where}: move its points so that it does not")
    return polygon


def require_holes_apart(
    holes: Sequence[shapely.Polygon], owner: Sequence[int], names: Sequence[str], keys: Sequence[Key]
) -> None:
    """Refuse holes of one area, their ``owner``, that clearly overlap; a small overlap may be due to chords of curves.

    `require_domain` would find them as well, but after a search for contacts, which has no end for nearly equal curves.
    """
    tree = shapely.STRtree(holes)
    for j, hole in enumerate(holes):  # one by one: of very many in one place all pairs would be too many
        before = tree.query(hole, predicate="intersects")
        for i in sorted(before[before < j].tolist()):
            common = shapely.intersection(holes[i], hole).area
            if owner[i] == owner[j] and common > CLEARLY * min(holes[i].area, hole.area):
                with about(keys[j]):
                    _require_apart(holes[i], hole, names[i], names[j])


def _require_inside(hole: shapely.Polygon, outer: shapely.Polygon, name: str, around: str) -> None:
    """Refuse a hole that is not inside the ring ``around`` it, or shares an edge with that; names are for messages."""
    if outer.contains(hole):
        shared = shapely.intersection(outer.exterior, hole.exterior)
        if shared.length > 0:
            raise GeometryError(
                f"{name} shares an edge with {around} at {first_place(shared)}: draw {around} around it"
            )
        return
    if not outer.intersects(hole):
        raise GeometryError(f"{name} at {first_place(hole.exterior)} lies outside {around}: move or remove it")
    crossing = shapely.intersection(outer.exterior, hole.exterior)
    if crossing.is_empty:
        where = first_place(hole.exterior)
        raise GeometryError(f"{name} at {where} encloses {around}: make it smaller, or exchange the two")
    where = first_place(crossing)
    raise GeometryError(f"{name} crosses {around} at {where}: move it, or draw {around} around it")


def _require_apart(a: shapely.Polygon, b: shapely.Polygon, name_a: str, name_b: str) -> None:
    where = first_place(shapely.intersection(a.exterior, b.exterior) if not a.exterior.disjoint(b.exterior) else b)
    if a.contains(b) or b.contains(a):
        inner, around = (name_b, name_a) if a.contains(b) else (name_a, name_b)
        raise GeometryError(f"{inner} lies inside {around} at {where}: remove one of them")
    if shapely.intersection(a, b).area > 0:
        raise GeometryError(f"{name_a} and {name_b} overlap at {where}: join them into one hole")
    if shapely.intersection(a.exterior, b.exterior).length > 0:
        raise GeometryError(f"{name_a} and {name_b} share an edge at {where}: join them into one hole")


def _require_separate(a: shapely.Polygon, b: shapely.Polygon, name_a: str, name_b: str) -> None:
    """Check that areas that meet do so in points only."""
    common = shapely.intersection(a, b)
    if common.area > 0:
        where = first_place(shapely.point_on_surface(common))
        raise GeometryError(f"{name_a} and {name_b} overlap at {where}: join them into one area, or remove one of them")
    if common.length > 0:
        raise GeometryError(
            f"{name_a} and {name_b} share an edge at {first_place(common)}: join them into one area, or give them as "
            "regions"
        )


def fault_place(polygon: shapely.Polygon) -> Floats:
    """Coordinates (2,) of the fault of a polygon that is not valid."""
    return np.array(explain_validity(polygon).rstrip("]").partition("[")[2].split(), float)


def explained(polygon: shapely.Polygon) -> tuple[str, str]:
    """The fault and its coordinates, from GEOS's text "Self-intersection[x y]"."""
    fault, _, where = explain_validity(polygon).rstrip("]").partition("[")
    return fault, place([float(value) for value in where.split()])


def first_place(shape: shapely.Geometry) -> str:
    """Place of a shape's first vertex, as messages write it."""
    return place(shapely.get_coordinates(shape)[0])
