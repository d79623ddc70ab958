"""Coverages: polygons that have common borders with the same vertices, and overlap nowhere."""

from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers, different_rows
from bubblemesh.geometry.nesting import Shapes

MANY = 100  # shapes, from which on it is faster to look at the edges first


def is_coverage(shapes: Shapes, gap: float = 0.0) -> bool:
    """What `shapely.coverage_is_valid` says of valid polygons (n,), also of gaps between them narrower than ``gap``.

    It looks at all vertices of the neighbours of each shape: for thousands of grains in a matrix that takes very long.
    Edges decide first, where they surely do.
    """
    known = surely_coverage(shapes, gap)
    return bool(shapely.coverage_is_valid(shapes, gap)) if known is None else known


def surely_coverage(shapes: Shapes, gap: float = 0.0) -> bool | None:
    """Whether valid polygons (n,) are a coverage without gaps as narrow as ``gap``; None if edges do not tell."""
    if len(shapes) < MANY:
        return None
    edges = _Edges.of(shapes)
    if edges.overlap_along_axes:
        return False
    return True if edges.only_meet_in_ends(gap) and not edges.lie_within(shapes) else None


class _Edges(NamedTuple):
    """Edges of polygons, with these on their left."""

    points: Floats  # (p, 2), each once
    start: Integers  # (e,)
    end: Integers  # (e,)
    shape: Integers  # (e,)

    @classmethod
    def of(cls, shapes: Shapes) -> "_Edges":
        parts, shape_of_part = shapely.get_parts(shapes, return_index=True)
        rings, part = shapely.get_rings(parts, return_index=True)
        backward = shapely.is_ccw(rings) == (np.diff(part, prepend=-1) == 0)  # the first ring of a part is around it
        coordinates, ring = shapely.get_coordinates(rings, return_index=True)
        points, number = different_rows(coordinates)
        first = np.flatnonzero(np.diff(ring) == 0)
        a, b, turned = number[first], number[first + 1], backward[ring[first]]
        return cls(points, np.where(turned, b, a), np.where(turned, a, b), shape_of_part[part][ring[first]])

    @property
    def overlap_along_axes(self) -> bool:
        """Whether two edges along an axis, as those of pixels, have a part in common without being the same."""
        low, high = np.unique(np.sort(np.column_stack([self.start, self.end]), axis=1), axis=0).T
        for axis in (0, 1):
            level = self.points[low, axis]
            along = level == self.points[high, axis]
            ends = np.sort(self.points[np.stack([low[along], high[along]]), 1 - axis], axis=0)
            order = np.lexsort((ends[0], level[along]))
            (begin, end), level = ends[:, order], level[along][order]
            if ((np.diff(level) == 0) & (begin[1:] < end[:-1])).any():
                return True
        return False

    def only_meet_in_ends(self, gap: float) -> bool:
        """Whether two edges have no more in common than an end, or are the same, one there and one back.

        And whether vertices are farther than a gap from all edges that do not end there.
        """
        count = len(self.points)
        if len(np.unique(self.start * count + self.end)) < len(self.start):
            return False
        ends = np.unique(np.sort(np.column_stack([self.start, self.end]), axis=1), axis=0)
        lines = shapely.linestrings(self.points[ends])
        tree = shapely.STRtree(lines)
        point, edge = tree.query(shapely.points(self.points), predicate="dwithin", distance=gap)
        if (ends[edge] != point[:, None]).all(axis=1).any():
            return False
        one, other = tree.query(lines, predicate="intersects")
        return bool((ends[one][:, :, None] == ends[other][:, None]).any(axis=(1, 2)).all())

    def lie_within(self, shapes: Shapes) -> bool:
        """Whether an edge with a shape on one side only lies within another shape."""
        outer = self._outer
        middles = (self.points[self.start[outer]] + self.points[self.end[outer]]) / 2
        shape, edge = shapely.STRtree(shapely.points(middles)).query(shapes, predicate="contains")
        return bool((self.shape[outer][edge] != shape).any())

    @property
    def _outer(self) -> Booleans:
        """Mask (e,) of the edges that no other shape has on its left, in the opposite direction."""
        count = len(self.points)
        return ~np.isin(self.start * count + self.end, self.end * count + self.start)
