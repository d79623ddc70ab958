"""Segments of a plane graph: which are around its domain, and which lie within it."""

from collections import Counter
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import shapely

from bubblemesh.geometry.paths import Point
from bubblemesh.readers.features import CompoundCurve

Edge = tuple[Point, Point]


def split(
    segments: Sequence[CompoundCurve], holes: Sequence[Point]
) -> tuple[list[CompoundCurve], list[CompoundCurve], list[shapely.Polygon]]:
    """Segments around the domain, those within it, and the parts of the domain that they enclose.

    Parts with one of the ``holes`` in them do not belong to the domain. Where nothing is enclosed, all segments are
    around it, for their open ends to be told; those outside are left out.
    """
    lines = [shapely.LineString([segment.start, segment.end]) for segment in segments]
    faces = shapely.get_parts(shapely.polygonize(lines))
    if len(holes):
        _, holed = shapely.STRtree(faces).query(shapely.points(holes), predicate="within")
        faces = np.delete(faces, holed)
    sides = Counter(edge for face in faces.tolist() for edge in _edges(face))
    if not sides:
        return list(segments), [], []
    number = [sides[_edge(segment.start, segment.end)] for segment in segments]
    middles = [((a + c) / 2, (b + d) / 2) for (a, b), (c, d) in ((one.start, one.end) for one in segments)]
    within, _ = shapely.STRtree(faces).query(shapely.points(middles), predicate="intersects")
    inner = {k for k in within.tolist() if number[k] != 1}
    around = [segment for segment, count in zip(segments, number, strict=True) if count == 1]
    return around, [segments[k] for k in sorted(inner)], faces.tolist()


def _edges(face: shapely.Polygon) -> list[Edge]:
    found = []
    for ring in (face.exterior, *face.interiors):
        points = [(x, y) for x, y in ring.coords]
        found += [_edge(a, b) for a, b in pairwise(points)]
    return found


def _edge(a: Point, b: Point) -> Edge:
    """The edge between two points, whichever way it runs."""
    return (a, b) if a <= b else (b, a)
