"""Land cut out of a box: the parts of the sea that are open, and the sides of the box that they have."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Floats, Integers
from bubblemesh.case.domain import ShoreDomain
from bubblemesh.errors import GeometryError, prefixed
from bubblemesh.geometry.map_projection import UNPROJECTED, MapProjection
from bubblemesh.geometry.nesting import polygons_of
from bubblemesh.messages import counted
from bubblemesh.readers.shores import ON_SIDE, land_in

PARTS_OF_SIDES = 1000  # of the box, before it is projected
STRAIGHT = 1e-7  # of the box's size: how far points are from a straight side that are left out


class Sea(NamedTuple):
    """Parts of the sea, the sides (4) of the box around it, and notes on what was left out."""

    parts: list[shapely.Polygon]
    sides: tuple[Floats, ...]
    in_metres: bool  # whether coordinates are places on the earth
    notes: tuple[str, ...]


def sea_in_box(keys: ShoreDomain, projection: MapProjection = UNPROJECTED) -> Sea:
    """The sea in the box of a domain, with all detail; errors have the file.

    Parts without an open side, which no tide reaches, and what is smaller than the smallest area are left out.
    """
    x0, y0, x1, y1 = keys.box
    corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)]
    step = max(x1 - x0, y1 - y0) / PARTS_OF_SIDES
    lines = shapely.segmentize(shapely.MultiLineString(list(pairwise(corners))), step)
    around = shapely.transform(lines, projection.points)
    straight = STRAIGHT * max(np.ptp(np.array(around.bounds).reshape(2, 2), axis=0))
    sides = tuple(map(shapely.get_coordinates, shapely.get_parts(shapely.simplify(around, straight))))
    shore = keys.shoreline
    with prefixed(shore.file):
        faces = land_in(Path(shore.file), shore.of, shore.layer, keys.box, projection.system)
        # Cut where the sides of the box are straight still, so that land which ends on one has no sea beside it.
        frame = shapely.segmentize(shapely.box(*keys.box), step)
        shape = shapely.union_all(faces.shapes)
        sea = frame.intersection(shape) if faces.of_sea else frame.difference(shape)
        projected = (shapely.make_valid(_projected(part, projection)) for part in polygons_of(sea))
        parts = [valid for shape in projected for valid in polygons_of(shape)]
        advice = "make the box smaller" if parts else "correct the box"
        if not faces.of_sea:
            advice += ", or say of: sea if the shapes are water"
        simplified = polygons_of(shapely.simplify(shapely.MultiPolygon(parts), straight))
        whole = Sea(simplified, sides, projection.plane is not None, faces.notes)
        return open_sea(whole, shore.smallest or 0.0, advice)


def _projected(part: shapely.Polygon, projection: MapProjection) -> shapely.Polygon:
    """A part of the sea in the plane, with more points on sides that are not straight there."""
    around, *islands = (projection.line(shapely.get_coordinates(ring))[0] for ring in (part.exterior, *part.interiors))
    return shapely.Polygon(around, islands)


def open_sea(sea: Sea, smallest: float, advice: str) -> Sea:
    """Parts of the sea that are open and large, without small islands; GeometryError, with the advice, if none is."""
    found, notes = sea.parts, list(sea.notes)
    rim = shapely.MultiLineString([shapely.LineString(side) for side in sea.sides])
    size = box_size(sea.sides)
    area = _area(smallest, sea.in_metres)
    opened = [part for part in found if part.boundary.intersection(rim.buffer(ON_SIDE * size)).length > 1e-3 * size]
    closed = len(found) - len(opened)
    if closed:
        notes.append(f"{counted(closed, 'part')} of the sea that no open side reaches left out")
    large = [part for part in opened if part.area >= smallest]
    if len(large) < len(opened):
        notes.append(f"{counted(len(opened) - len(large), 'part')} of the sea smaller than {area} left out")
    if found and not opened:
        raise GeometryError(f"no part of the sea reaches a side of the box: {advice}")
    if not large:
        advice = f"all of it is below smallest: {area}: ask for less" if opened else advice
        raise GeometryError(f"no sea is left in the box: {advice}")
    holes = [[ring for ring in part.interiors if shapely.Polygon(ring).area >= smallest] for part in large]
    dropped = sum(len(part.interiors) for part in large) - sum(map(len, holes))
    if dropped:
        notes.append(f"{counted(dropped, 'island')} smaller than {area} left out")
    parts = [shapely.Polygon(part.exterior, kept) for part, kept in zip(large, holes, strict=True)]
    return sea._replace(parts=sorted(parts, key=lambda part: -part.area), notes=tuple(notes))


def _area(value: float, in_metres: bool) -> str:
    """An area as messages write it, with a unit if it has one."""
    if not in_metres:
        return f"{value:.6g}"
    return f"{value / 1e6:.6g} km2" if value >= 1e4 else f"{value:.6g} m2"


def box_size(sides: Sequence[Floats]) -> float:
    """Length of the longer sides of a box, by its sides (n, 2) in the plane."""
    return float(max(np.ptp(np.vstack(sides), axis=0)))


def side_of_box(ring: Floats, sides: Sequence[Floats]) -> Integers:
    """Number (n,) of the side of the box that each side of a ring (n, 2) is on; -1 for those of the shore."""
    near_enough = ON_SIDE * box_size(sides)
    ends = np.roll(ring, -1, axis=0)
    found = np.full(len(ring), -1)
    for number, side in enumerate(sides):
        line = shapely.LineString(side)
        shapely.prepare(line)
        near = [shapely.dwithin(line, shapely.points(at), near_enough) for at in (ring, ends, (ring + ends) / 2)]
        found[np.all(near, axis=0)] = number
    return found
