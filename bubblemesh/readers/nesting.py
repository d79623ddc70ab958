"""Closed rings that lie around and within each other: an area and its holes."""

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from bubblemesh.errors import GeometryError
from bubblemesh.geometry.paths import Point, Ring
from bubblemesh.geometry.polygonal_copy import outline
from bubblemesh.messages import place


def outer_and_holes(rings: Sequence[Ring], marks: Sequence[Point] | None) -> list[Ring]:
    """The ring around all others, and these as its holes.

    Parameters
    ----------
    rings : sequence of Ring
    marks : sequence of (x, y), optional
        Points in the holes, where the file tells them.

    Raises
    ------
    GeometryError
        If the rings bound several areas, one within another one's hole, or a ring without a mark is inside.
    """
    shapes = np.array([shapely.Polygon(outline(ring)) for ring in rings], dtype=object)
    size = shapely.area(shapes)
    largest = int(size.argmax())
    # A ring is inside if its points are: rings that cross are left to the check of the domain.
    starts = shapely.points([shapely.get_coordinates(shape)[0] for shape in shapes])
    inner, around = shapely.STRtree(shapes).query(starts, predicate="intersects")
    inside = (size[around] > size[inner]) & (inner != around)
    inner, around = inner[inside], around[inside]
    depth = np.bincount(inner, minlength=len(rings))
    crossing = shapely.intersects(shapely.boundary(shapes), shapely.boundary(shapes[largest]))
    apart = np.flatnonzero((depth == 0) & (np.arange(len(rings)) != largest) & ~crossing)
    if len(apart):
        raise GeometryError(
            f"{len(apart) + 1} separate areas, one at {place(_first(shapes[largest]))} and one at "
            f"{place(_first(shapes[apart[0]]))}: choose one by feature or layer"
        )
    deep = np.flatnonzero(depth > 1)
    if len(deep):
        raise GeometryError(
            f"the ring at {place(_first(shapes[deep[0]]))} lies in a hole: an area within a hole is a domain of its "
            "own, choose one by feature or layer"
        )
    holes = [k for k in range(len(rings)) if k != largest]
    if marks is not None:
        _require_marks(shapes, largest, holes, marks)
    return [rings[k] for k in (largest, *holes)]


def _require_marks(shapes: "NDArray[np.object_]", largest: int, holes: Sequence[int], marks: Sequence[Point]) -> None:
    """Every hole must have a mark, and every mark must be in the outer ring."""
    points = shapely.points(np.array(marks, float).reshape(-1, 2))
    for k in holes:
        if not shapely.contains(shapes[k], points).any():
            raise GeometryError(
                f"the ring at {place(_first(shapes[k]))} has no hole point in it: it would part the domain into regions"
            )
    outside = np.flatnonzero(~shapely.contains(shapes[largest], points))
    if len(outside):
        raise GeometryError(f"the hole point {place(marks[outside[0]])} is outside the outer ring: move or remove it")


def _first(shape: shapely.Geometry) -> Point:
    x, y = shapely.get_coordinates(shape)[0].tolist()
    return x, y
