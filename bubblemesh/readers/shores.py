"""Shapes of land or sea in a box, from files of maps: polygons, and lines of the shore with the land on their left."""

from collections.abc import Sequence
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Floats
from bubblemesh.errors import CaseError
from bubblemesh.geometry.geography import is_projecting, require_geographic
from bubblemesh.geometry.rings import end_of
from bubblemesh.readers.features import Feature
from bubblemesh.readers.formats import content_of
from bubblemesh.readers.selection import Selection

Box = tuple[float, float, float, float]
ON_SIDE = 2e-6  # of the box's size: what ends nearer to a side of it ends on it


class Faces(NamedTuple):
    """Polygons of land, or of sea, in the coordinates of their file, and notes on it."""

    shapes: Sequence[shapely.Polygon]
    of_sea: bool
    notes: tuple[str, ...]


def land_in(path: Path, of: Literal["land", "sea", "lines"], layer: str | None, box: Box) -> Faces:
    """Polygons of a file in a box (x0, y0, x1, y1); what ends at a side of it, but for rounding, ends on that side.

    Lines are closed along the box; what has no line in it is sea. FileError or CaseError if the file cannot be read,
    has nothing of that kind, or lines cross.
    """
    selection = Selection(() if layer is None else (layer,))
    content = content_of(path, selection, "lines" if of == "lines" else "rings")
    features = selection.of(content.features)
    if is_projecting():
        require_geographic(content.degrees)
    frame = shapely.box(*box)
    if of == "lines":
        lines = [_on_sides(line, box) for line in _lines(features)]
        return Faces(_left_of(lines, frame), of_sea=False, notes=content.notes)
    found = _shapes(features)
    if not found:
        raise CaseError("has no areas: give polygons, or say of: lines")
    ending = shapely.transform(np.array(found, dtype=object), lambda points: _on_sides(points, box))
    cut = shapely.intersection(shapely.make_valid(ending), frame)
    polygons = [part for part in shapely.get_parts(shapely.get_parts(cut)) if part.geom_type == "Polygon"]
    return Faces([part for part in polygons if not part.is_empty], of == "sea", content.notes)


def _on_sides(points: Floats, box: Box) -> Floats:
    """Points (n, 2) of which those that nearly are on the line of a side of a box are on it.

    Of land that a box was cut out of before no slivers of sea stay along it, and lines reach it.
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


def _lines(features: Sequence[Feature]) -> list[Floats]:
    """Points (k, 2) of each line, in its direction; rings end where they begin."""
    curves = [np.array([curve.start, *map(end_of, curve.pieces)]) for one in features for curve in one.curves]
    loops = [ring.vertices for one in features for ring in (*one.rings, *(ring for area in one.areas for ring in area))]
    found = [*curves, *(np.array([*loop, loop[0]]) for loop in loops)]
    if not found:
        raise CaseError("has no lines: give lines of the shore, or polygons")
    return found


def _left_of(lines: Sequence[Floats], frame: shapely.Polygon) -> list[shapely.Polygon]:
    """Faces of a frame that are on the left of lines; CaseError if a face is on the left and on the right of some."""
    inside = shapely.intersection(np.array([shapely.LineString(line) for line in lines], dtype=object), frame)
    faces = shapely.get_parts(
        shapely.polygonize(shapely.get_parts(shapely.node(shapely.union_all([*inside, frame.boundary]))))
    )
    tree = shapely.STRtree(faces)
    votes = np.zeros((len(faces), 2))
    segments = np.vstack([np.stack([line[:-1], line[1:]], axis=1) for line in lines])
    length = np.hypot(*(segments[:, 1] - segments[:, 0]).T)
    segments, length = segments[length > 0], length[length > 0]
    middle, along = segments.mean(axis=1), (segments[:, 1] - segments[:, 0]) / length[:, None]
    aside = np.column_stack([-along[:, 1], along[:, 0]]) * (1e-3 * length)[:, None]
    for side, points in enumerate((middle + aside, middle - aside)):
        point, face = tree.query(shapely.points(points), predicate="within")
        np.add.at(votes, (face, side), length[point])
    mixed = np.flatnonzero((votes > 0.05 * votes.sum(axis=1, keepdims=True)).all(axis=1))
    if len(mixed):
        x, y = shapely.get_coordinates(shapely.point_on_surface(faces[mixed[0]]))[0].tolist()
        raise CaseError(
            f"the lines around ({x:.6g}, {y:.6g}) have the land on their left and on their right: turn some of them, "
            "or close the gaps between them"
        )
    return [face for face, (left, right) in zip(faces, votes, strict=True) if left > right]
