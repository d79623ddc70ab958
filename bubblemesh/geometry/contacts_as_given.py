"""Vertices that lie on straight sides in the given coordinates, and hence have to lie on them in the plane as well.

A side that is straight on the earth's grid is bent in the plane, or replaced by its chord: a line that ends on it would
end beside it. Where a vertex lies on a side, the side gets that vertex before it is projected.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers, different_rows
from bubblemesh.geometry.arrangement import ROUNDINGS, TOUCHING
from bubblemesh.geometry.paths import Line, Point, Ring, Side, as_point
from bubblemesh.records import record

Ends = tuple[Point, Point]


@record
class Contacts:
    """Vertices on the straight sides of others, by the ends of the sides, in order from the first end."""

    on: Mapping[Ends, Sequence[Point]]

    def along(self, start: Point, end: Point) -> list[Point]:
        """The vertices of a straight side: its start, those that lie on it, its end."""
        return [start, *self.on.get((start, end), ()), end]

    def ring(self, ring: Ring) -> Ring:
        """The ring with these vertices in its straight sides, whose parts keep their labels."""
        if not self.on or not all(isinstance(side.curve, Line) for side in ring.sides):
            return ring
        parts = [(self.along(*side.curve), side.label) for side in ring.sides if isinstance(side.curve, Line)]
        sides = [Side(Line(*ends), label) for points, label in parts for ends in pairwise(points)]
        vertices = [point for points, _ in parts for point in points[:-1]]
        return replace(ring, sides=tuple(sides), vertices=tuple(vertices))

    def line(self, points: Floats) -> tuple[Floats, Integers]:
        """A line by points (n, 2) with these vertices in it, and the given side (m - 1,) of each of its sides."""
        if not self.on:
            return points, np.arange(len(points) - 1)
        parts = [self.along(*ends)[:-1] for ends in pairwise(map(as_point, points))]
        side = np.repeat(np.arange(len(parts)), list(map(len, parts)))
        return np.array([*(point for part in parts for point in part), as_point(points[-1])]), side


NO_CONTACTS = Contacts({})


def contacts_between(sides: Floats, points: Floats) -> Contacts:
    """Those of the points (n, 2) that lie on straight sides (m, 2, 2), whose ends are among them, but for rounding.

    Points that are as near to an end of the side, or to another one that is on it, are left out.
    """
    if len(sides) == 0:
        return NO_CONTACTS
    extent, largest = np.ptp(sides, axis=(0, 1)).max(), np.abs(sides).max()
    tolerance = max(TOUCHING * float(extent), ROUNDINGS * float(np.spacing(largest)))
    points, _ = different_rows(points)
    sides = sides[_may_have(points, sides, tolerance)]
    if len(sides) == 0:
        return NO_CONTACTS
    rows, _ = different_rows(sides.reshape(-1, 4))
    starts, ends = rows[:, :2], rows[:, 2:]
    lines = shapely.STRtree(shapely.linestrings(rows.reshape(-1, 2, 2)))
    number, side = lines.query(shapely.points(points), predicate="dwithin", distance=tolerance)
    length = np.hypot(*(ends - starts).T)
    along = ((points[number] - starts[side]) * (ends - starts)[side]).sum(axis=1) / length[side]
    between = (along > tolerance) & (along < length[side] - tolerance)
    side, number, along = side[between], number[between], along[between]
    order = np.lexsort((along, side))
    side, number, along = side[order], number[order], along[order]
    again = (np.diff(side, prepend=-1) == 0) & (np.diff(along, prepend=-np.inf) <= tolerance)
    on: dict[Ends, list[Point]] = {}
    for k, point in zip(side[~again].tolist(), points[number[~again]], strict=True):
        on.setdefault((as_point(starts[k]), as_point(ends[k])), []).append(as_point(point))
    return Contacts(on)


def _may_have(points: Floats, sides: Floats, tolerance: float) -> Booleans:
    """Mask (m,) of the sides (m, 2, 2) in whose circle is a third point beside the two ends: few, and soon found."""
    from scipy.spatial import cKDTree  # takes longer to load than to read a small domain

    middles, radii = sides.mean(axis=1), np.hypot(*(sides[:, 1] - sides[:, 0]).T) / 2
    away, _ = cKDTree(points).query(middles, k=[3])
    return np.asarray(away)[:, 0] <= radii + tolerance
