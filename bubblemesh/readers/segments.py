"""Segments of a plane graph: those around its domain, those within it, and those outside."""

from collections import Counter
from collections.abc import Sequence
from itertools import compress, pairwise
from typing import Any, NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from bubblemesh.arrays import ROUNDING, Booleans, Floats
from bubblemesh.geometry.paths import Point
from bubblemesh.readers.features import CompoundCurve

Edge = tuple[Point, Point]


class Split(NamedTuple):
    """Segments by their position, and the parts of the domain that they enclose."""

    around: list[CompoundCurve]
    inner: list[CompoundCurve]  # within the domain, or partly so
    crossing: list[CompoundCurve]  # inner segments that are partly outside
    outside: list[CompoundCurve]
    parts: list[shapely.Polygon]


def split_segments(segments: Sequence[CompoundCurve], holes: Sequence[Point]) -> Split:
    """Divide segments into those around a domain, within it and outside.

    Parts that contain one of the points in ``holes`` do not belong to the domain. If nothing is enclosed, all segments
    count as around it, so that their open ends are reported.
    """
    lines = shapely.linestrings([(segment.start, segment.end) for segment in segments])
    faces = shapely.get_parts(shapely.polygonize(lines))
    if len(holes):
        _, holed = shapely.STRtree(faces).query(shapely.points(holes), predicate="within")
        faces = np.delete(faces, holed)
    sides = Counter(edge for face in faces.tolist() for edge in _edges(face))
    if not sides:
        return Split(list(segments), [], [], [], [])
    number = np.array([sides[_edge(segment.start, segment.end)] for segment in segments])
    loose = np.flatnonzero(number == 0)
    inside = np.ones(len(segments))
    inside[loose] = _shares_inside(lines[loose], faces)
    inner = (number != 1) & (inside > ROUNDING)

    def those(chosen: Booleans) -> list[CompoundCurve]:
        return list(compress(segments, chosen))

    return Split(
        those(number == 1),
        those(inner),
        those(inner & (inside < 1 - ROUNDING)),
        those(inside <= ROUNDING),
        faces.tolist(),
    )


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
