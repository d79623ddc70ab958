"""Regions as polygons of the noded pieces: which of them overlap, and which one is where."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import shapely

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.arrangement import NEARLY
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.messages import place

BELLY = 0.01  # of the square of a chord's length: more than the area between it and its curve


def areas_of(boundary: Boundary, lines: int, outlines: Sequence[shapely.Polygon]) -> list[shapely.Polygon]:
    """The regions as polygons of the chords of the noded pieces, so that common sides are the same in each."""
    chords = boundary.chords()
    number = -boundary.ring[chords.piece] - lines
    order = np.argsort(number, kind="stable")
    bounds = np.searchsorted(number[order], np.arange(1, len(outlines) + 2))
    areas = [shapely.Polygon(chords.start[order[a:b]]) for a, b in pairwise(bounds)]
    for area in areas:
        shapely.prepare(area)
    return areas


def slack_of(boundary: Boundary, lines: int, outlines: Sequence[shapely.Polygon], size: float) -> Floats:
    """Area (r,) that the polygon of each region may be off along its rim."""
    piece, _, step = boundary.stations()
    off = NEARLY * size * step + np.where(boundary.curved[piece], BELLY * step**2, 0)
    number = -boundary.ring[piece] - lines
    total = np.bincount(np.maximum(number, 0), off, minlength=len(outlines) + 1)
    return np.asarray(total[1:], float)


def require_apart(areas: Sequence[shapely.Polygon], names: Sequence[str], slack: Floats) -> None:
    """Check that regions overlap only by one being inside the other.

    Raises
    ------
    GeometryError
        With the names and a place.
    """
    shapes = np.array(areas, dtype=object)
    i, j = shapely.STRtree(shapes).query(shapes, predicate="intersects")
    i, j = i[i < j], j[i < j]
    common = shapely.intersection(shapes[i], shapes[j])
    off, shared, size = slack[i] + slack[j], shapely.area(common), shapely.area(shapes)
    overlapping = (shared > off) & (shared < np.minimum(size[i], size[j]) - off)
    same = shared >= np.maximum(size[i], size[j]) - off
    for k in np.flatnonzero(overlapping | same):
        names_of_both = f"regions {names[i[k]]!r} and {names[j[k]]!r}"
        where = place(shapely.get_coordinates(shapely.point_on_surface(common[k]))[0])
        if same[k]:
            raise GeometryError(f"{names_of_both} at {where} are the same: remove one of them")
        raise GeometryError(f"{names_of_both} overlap at {where}: give them a common side")


def region_at(points: Floats, areas: Sequence[shapely.Polygon]) -> Integers:
    """Number (n,) of the innermost region at points (n, 2); 0 where there is none."""
    found = np.zeros(len(points), np.int64)
    if len(areas) == 0:
        return found
    number, point = shapely.STRtree(shapely.points(points)).query(np.array(areas, dtype=object), predicate="contains")
    order = np.argsort(-shapely.area(areas)[number], kind="stable")  # the last one written stays
    found[point[order]] = number[order] + 1
    return found
