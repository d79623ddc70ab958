"""Vertices that lie on straight sides in the given coordinates, and hence have to lie on them in the plane as well.

A side that is straight on the earth's grid is bent in the plane, or replaced by its chord: a line that ends on it would
end beside it. Where a vertex lies on a side, the side gets that vertex before it is projected.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np

from bubblemesh.arrays import Floats, Integers, cross, different_rows, members
from bubblemesh.geometry.arrangement import ROUNDINGS, TOUCHING
from bubblemesh.geometry.paths import Line, Point, Ring, Side, as_point
from bubblemesh.records import record

Ends = tuple[Point, Point]
Pairs = tuple[Integers, Integers]  # numbers of sides and of points
MOST_PAIRS = 300_000  # that are looked at at once


@record
class Contacts:
    """Vertices on the straight sides of others, by the ends of the sides, in order from the first end."""

    on: Mapping[Ends, Iterable[Point]]

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
    size, largest = np.ptp(sides, axis=(0, 1)).max(), np.abs(sides).max()
    tolerance = max(TOUCHING * float(size), ROUNDINGS * float(np.spacing(largest)))
    points, _ = different_rows(points)
    found = (_on(sides, points, pairs, tolerance) for pairs in _near_each_other(sides, points, tolerance))
    side, number, along = map(np.concatenate, zip(*found, strict=True))
    order = np.lexsort((along, side))
    side, number, along = side[order], number[order], along[order]
    again = (np.diff(side, prepend=-1) == 0) & (np.diff(along, prepend=-np.inf) <= tolerance)
    on: dict[Ends, dict[Point, None]] = {}
    for k, point in zip(side[~again].tolist(), points[number[~again]], strict=True):
        start, end = map(as_point, sides[k])
        on.setdefault((start, end), {})[as_point(point)] = None
    return Contacts(on)


def _near_each_other(sides: Floats, points: Floats, tolerance: float) -> Iterator[Pairs]:
    """Sides (m, 2, 2) and ascending points (n, 2) that may meet, some at a time.

    With a side come the points within its extent in x, or in y if these are fewer, unless they are its ends alone.
    """
    low, high = np.minimum(*sides.swapaxes(0, 1)) - tolerance, np.maximum(*sides.swapaxes(0, 1)) + tolerance
    orders = np.array([np.arange(len(points)), np.argsort(points[:, 1])])
    begin, end = (
        np.array([np.searchsorted(points[order, k], bound[:, k]) for k, order in enumerate(orders)])
        for bound in (low, high)
    )
    axis = (end - begin).argmin(axis=0)
    begin, counts = begin[axis, np.arange(len(sides))], (end - begin).min(axis=0)
    some = np.flatnonzero(counts > 2)
    for few in np.split(some, np.flatnonzero(np.diff(np.cumsum(counts[some]) // MOST_PAIRS)) + 1):
        group, rank = members(counts[few])
        side = few[group]
        yield side, orders[axis[side], begin[side] + rank]


def _on(sides: Floats, points: Floats, pairs: Pairs, tolerance: float) -> tuple[Integers, Integers, Floats]:
    """Those pairs (k,) whose point is on the side between its ends, and how far (k,) from its start that is."""
    side, number = pairs
    way, place = sides[side, 1] - sides[side, 0], points[number] - sides[side, 0]
    length, along = np.hypot(*way.T), (way * place).sum(axis=1)  # in terms of the length
    between = (along > tolerance * length) & (along < (length - tolerance) * length)
    on = np.flatnonzero(between & (np.abs(cross(way, place)) <= tolerance * length))
    return side[on], number[on], along[on] / length[on]
