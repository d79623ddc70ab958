"""Shapes of land or sea in a box, from files of maps: polygons, and lines of the shore with the land on their left."""

from collections.abc import Sequence
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import CaseError
from bubblemesh.geometry.nesting import polygons_of
from bubblemesh.geometry.systems import full_turn
from bubblemesh.geometry.validity import fault_place
from bubblemesh.messages import counted, extent
from bubblemesh.readers.features import Feature, vertices_of
from bubblemesh.readers.formats import read_content
from bubblemesh.readers.projection import require_places
from bubblemesh.readers.selection import Selection
from bubblemesh.readers.shore_lines import given_place, left_of, shore_lines

Box = tuple[float, float, float, float]
Shapes = NDArray[np.object_]
Notes = tuple[str, ...]
Kind = Literal["land", "sea", "lines"]
ON_SIDE = 2e-6  # of the box's size: ends nearer to a side are on it, and shapes nearer to each other meet


class Faces(NamedTuple):
    """Polygons of land, or of sea, in the coordinates of their file, and notes on it."""

    shapes: Sequence[shapely.Polygon]
    of_sea: bool
    notes: tuple[str, ...]


def land_in(path: Path, of: Kind, layer: str | None, box: Box, system: str | None = None) -> Faces:
    """Polygons of a file in a box (x0, y0, x1, y1); ends that are nearly on a side of the box are moved onto it.

    Longitudes may differ from those of the box by whole turns. Lines are closed along the box; a box without lines is
    sea. FileError or CaseError if the file cannot be read, has nothing of that kind, or lines do not bound land.
    """
    selection = Selection(() if layer is None else (layer,))
    content = read_content(path, selection, "lines" if of == "lines" else "rings")
    features = selection.of(content.features)
    require_places(vertices_of(features), features, content, system)
    frame = shapely.box(*box)
    found, notes = (_left_of if of == "lines" else _areas)(features, box, full_turn(system))
    shore = shapely.union_all([shape.boundary for shape in found])
    if not shapely.relate_pattern(shore, frame, "T********"):
        extents = extent(box), extent(shapely.total_bounds(shapely.multipoints(vertices_of(features))).tolist())
        notes = (*notes, "no shore lies in the box {}: the shapes of the file are in {}".format(*extents))
    return Faces(found, of == "sea", (*content.notes, *notes))


def _left_of(features: Sequence[Feature], box: Box, turn: float | None) -> tuple[list[shapely.Polygon], Notes]:
    """Polygons of the land on the left of lines, and notes."""
    lines = shore_lines(features)
    made = np.array([shapely.LineString(line.points) for line in lines], dtype=object)
    number, turned = _near(made, box, turn)
    if len(turned) == 0:
        return [], ()
    turned, frame = shapely.transform(turned, lambda points: _on_sides(points, box)), shapely.box(*box)
    cut = shapely.transform(shapely.intersection(turned, frame), lambda points: _on_sides(points, box))
    moved = [lines[k]._replace(points=shapely.get_coordinates(line)) for k, line in zip(number, turned, strict=True)]
    return left_of(moved, shapely.union_all(cut), frame)


def _areas(features: Sequence[Feature], box: Box, turn: float | None) -> tuple[list[shapely.Polygon], Notes]:
    """Polygons of features in the box, without gaps of rounding between them, and notes."""
    shapes = np.array(_shapes(features), dtype=object)
    if len(shapes) == 0:
        raise CaseError("has no areas: give polygons, or say of: lines")
    _, turned = _near(shapes, box, turn)
    faulty = turned[~shapely.is_valid(turned)]
    ending = shapely.transform(turned, lambda points: _on_sides(points, box))
    cut = shapely.intersection(shapely.make_valid(ending), shapely.box(*box))
    mended: Notes = ()
    if len(faulty):
        where = given_place(fault_place(faulty[0]))
        mended = (f"{counted(len(faulty), 'shape')} mended that crossed or touched itself, the first at {where}",)
    joined, more = _joined(polygons_of(cut), ON_SIDE * max(box[2] - box[0], box[3] - box[1]))
    return joined, (*mended, *more)


def _near(shapes: Shapes, box: Box, turn: float | None) -> tuple[Integers, Shapes]:
    """Numbers (k,) of the shapes whose extents meet a box, and these shapes, moved by whole turns of longitude."""
    numbers = list[Integers]()
    moved = list[Shapes]()
    x0, y0, x1, y1 = box
    for shift in (0.0,) if turn is None else (0.0, -turn, turn):
        left, low, right, high = (shapely.bounds(shapes) + np.array([shift, 0, shift, 0])).T
        near = ON_SIDE * max(x1 - x0, y1 - y0)
        meets = (left <= x1 + near) & (right >= x0 - near) & (low <= y1 + near) & (high >= y0 - near)
        numbers.append(np.flatnonzero(meets))
        moved.append(shapely.transform(shapes[meets], lambda points, by=shift: points + np.array([by, 0.0])))
    return np.concatenate(numbers), np.concatenate(moved)


def _joined(shapes: Sequence[shapely.Polygon], near: float) -> tuple[list[shapely.Polygon], Notes]:
    """The shapes with gaps between them narrower than ``near`` closed, and a note on these gaps."""
    found = np.array(shapes, dtype=object)
    rims = shapely.boundary(found)
    first, second = shapely.STRtree(rims).query(rims, predicate="dwithin", distance=near)
    places = list[Floats]()
    for i, j in zip(first.tolist(), second.tolist(), strict=True):
        if i < j and len(apart := _apart(found[i], found[j], near)):
            places.append(apart[0])
            found[j] = shapely.snap(found[j], shapely.multipoints(apart), near)
            found[i] = shapely.snap(found[i], shapely.multipoints(_apart(found[j], found[i], near)), near)
    if not places:
        return list(shapes), ()
    pairs = counted(len(places), "pair")
    note = f"gaps of rounding closed between {pairs} of shapes, the first at {given_place(places[0])}"
    return polygons_of(shapely.make_valid(found)), (note,)


def _apart(one: shapely.Polygon, other: shapely.Polygon, near: float) -> Floats:
    """Vertices (k, 2) of a shape that are near to the boundary of another one, but not on it."""
    rim, points = other.boundary, shapely.get_coordinates(one)
    shapely.prepare(rim)
    points = points[shapely.dwithin(rim, shapely.points(points), near)]
    return points[shapely.distance(rim, shapely.points(points)) > 0]


def _on_sides(points: Floats, box: Box) -> Floats:
    """Points (n, 2), with those that are nearly on the line of a side of a box moved onto it.

    So no slivers of sea stay along the box if the file was cut to it before, and lines reach it.
    """
    x0, y0, x1, y1 = box
    near, moved = ON_SIDE * max(x1 - x0, y1 - y0), points.copy()
    for axis, value in ((0, x0), (0, x1), (1, y0), (1, y1)):
        moved[np.abs(points[:, axis] - value) <= near, axis] = value
    return moved


def _shapes(features: Sequence[Feature]) -> list[shapely.Polygon]:
    areas = [area for one in features for area in one.areas]
    found = [shapely.Polygon(outer.outline, [hole.outline for hole in holes]) for outer, *holes in areas]
    return found + [shapely.Polygon(ring.outline) for one in features for ring in one.rings]
