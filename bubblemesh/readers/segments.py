"""Segments of a plane graph: those around its domain, those within it, and those outside."""

from collections import Counter
from collections.abc import Sequence
from itertools import compress, pairwise
from math import dist
from typing import Any, NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from bubblemesh.arrays import ROUNDING, Booleans, Floats
from bubblemesh.geometry.paths import Point, as_point
from bubblemesh.geometry.rings import LineTo
from bubblemesh.readers.features import CompoundCurve
from bubblemesh.readers.rings.duplicates import SAME

Edge = tuple[Point, Point]


class Split(NamedTuple):
    """Segments by their position, and the parts of the domain that they enclose."""

    around: list[CompoundCurve]
    inner: list[CompoundCurve]  # within the domain, or partly so
    crossing: list[CompoundCurve]  # inner segments that are partly outside
    outside: list[CompoundCurve]
    parts: list[shapely.Polygon]


def split_segments(segments: Sequence[CompoundCurve], holes: Sequence[Point]) -> Split:
    """Divide segments, which may meet anywhere, into those around a domain, within it and outside.

    Parts that contain one of the points in ``holes`` do not belong to the domain. If nothing is enclosed, all segments
    count as around it, so that their open ends are reported. A segment stays whole unless a part of it is around.
    """
    pieces = [_cut(segment, places) for segment, places in zip(segments, _meetings(segments), strict=True)]
    edges = {_edge(piece.start, piece.end): (piece.start, piece.end) for some in pieces for piece in some}
    faces = shapely.get_parts(shapely.polygonize(shapely.linestrings([*edges.values()])))
    if len(holes):
        _, holed = shapely.STRtree(faces).query(shapely.points(holes), predicate="within")
        faces = np.delete(faces, holed)
    sides = Counter(edge for face in faces.tolist() for edge in _edges(face))
    if not sides:
        return Split(list(segments), [], [], [], [])
    counts = [[sides[_edge(piece.start, piece.end)] for piece in some] for some in pieces]
    partly = [0 < some.count(1) < len(some) for some in counts]
    found = [
        one
        for segment, some, is_cut in zip(segments, pieces, partly, strict=True)
        for one in (some if is_cut else [segment])
    ]
    number = np.array(
        [one for some, is_cut in zip(counts, partly, strict=True) for one in (some if is_cut else [min(some)])]
    )
    lines = shapely.linestrings([(one.start, one.end) for one in found])
    loose = np.flatnonzero(number == 0)
    inside = np.ones(len(found))
    inside[loose] = _shares_inside(lines[loose], faces)
    inner = (number != 1) & (inside > ROUNDING)

    def those(chosen: Booleans) -> list[CompoundCurve]:
        return list(compress(found, chosen))

    return Split(
        those(number == 1),
        those(inner),
        those(inner & (inside < 1 - ROUNDING)),
        those(inside <= ROUNDING),
        faces.tolist(),
    )


def _meetings(segments: Sequence[CompoundCurve]) -> list[list[Point]]:
    """Places on each segment between its ends where others end on it or cross it."""
    ends = np.array([(segment.start, segment.end) for segment in segments], float)
    tolerance = SAME * float(np.ptp(ends.reshape(-1, 2), axis=0).max())
    lines = shapely.linestrings(ends)
    tree, places = shapely.STRtree(lines), list[list[Point]]([] for _ in segments)
    vertices = np.unique(ends.reshape(-1, 2), axis=0)
    vertex, line = tree.query(shapely.points(vertices), predicate="dwithin", distance=tolerance)
    away = np.hypot(*np.moveaxis(ends[line] - vertices[vertex][:, None], -1, 0)).min(axis=1)
    met = {*zip(line[away > tolerance].tolist(), vertex[away > tolerance].tolist(), strict=True)}
    for k, number in sorted(met):
        places[k].append(as_point(vertices[number]))
    i, j = tree.query(lines, predicate="crosses")
    for k, other in zip(i[i < j].tolist(), j[i < j].tolist(), strict=True):
        at = as_point(shapely.get_coordinates(shapely.intersection(lines[k], lines[other]))[0])
        known = [*places[k], *places[other], *map(as_point, ends[[k, other]].reshape(-1, 2))]
        at = next((one for one in known if dist(at, one) <= tolerance), at)
        for number in (k, other):
            if at not in (*places[number], *map(as_point, ends[number])):
                places[number].append(at)
    return places


def _cut(segment: CompoundCurve, places: Sequence[Point]) -> list[CompoundCurve]:
    """The parts of a segment between places on it."""
    if not places:
        return [segment]
    (line,) = segment.pieces
    stops = [*sorted(places, key=lambda at: dist(segment.start, at)), segment.end]
    starts = [segment.start, *stops[:-1]]
    return [
        CompoundCurve(start, (LineTo(end, line.label),), segment.name) for start, end in zip(starts, stops, strict=True)
    ]


def _shares_inside(lines: NDArray[Any], faces: NDArray[Any]) -> Floats:
    """Share (n,) of the length of each line in faces or on their sides; more than 1 along sides of two faces."""
    face, line = shapely.STRtree(lines).query(faces, predicate="intersects")
    lengths = shapely.length(shapely.intersection(faces[face], lines[line]))
    found: Floats = np.bincount(line, lengths, len(lines)) / shapely.length(lines)
    return found


def _edges(face: shapely.Polygon) -> list[Edge]:
    found = []
    for ring in (face.exterior, *face.interiors):
        points = [(x, y) for x, y in ring.coords]
        found += [_edge(a, b) for a, b in pairwise(points)]
    return found


def _edge(a: Point, b: Point) -> Edge:
    """The edge between two points, the same for both directions."""
    return (a, b) if a <= b else (b, a)
