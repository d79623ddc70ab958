"""Rings around the parts of a sea, with the labels open, land and island."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import shapely

from bubblemesh.arrays import Floats, Integers
from bubblemesh.geometry.paths import Area, Line, Point, Polyline, Ring, Side, as_point
from bubblemesh.problem.shoreline.box import Sea, side_of_box

OPEN, LAND, ISLAND = "open", "land", "island"
SHORE = LAND, ISLAND


def areas_of_sea(sea: Sea, file: str) -> list[Area]:
    """Areas of the parts of a sea, with the labels open, land and island; the first ring has the notes on the file."""
    areas = [
        Area(_ring(part.exterior, sea.sides, LAND), tuple(_ring(hole, sea.sides, ISLAND) for hole in part.interiors))
        for part in sea.parts
    ]
    first = replace(areas[0].outer, notes=tuple(f"{Path(file).name}: {note}" for note in sea.notes))
    return [replace(areas[0], outer=first), *areas[1:]]


def _ring(loop: shapely.LinearRing, sides: Sequence[Floats], closed: str) -> Ring:
    """A ring whose sides on the box are open, each one curve from corner or shore to the next."""
    points = shapely.get_coordinates(loop)[:-1]
    side = side_of_box(points, sides)
    first = np.flatnonzero((side != np.roll(side, 1)) | (side < 0))
    start = int(first[0]) if len(first) else 0
    points, side = np.roll(points, -start, axis=0), np.roll(side, -start)
    starts, made = zip(*_sides(points, side, closed), strict=True)
    return Ring(made, starts)


def _sides(points: Floats, side: Integers, closed: str) -> Iterator[tuple[Point, Side]]:
    """Where each side of a ring by points (n, 2) starts, and the side."""
    around = np.vstack([points, points[:1]])
    begin = 0
    while begin < len(points):
        end = begin + 1
        while side[begin] >= 0 and end < len(points) and side[end] == side[begin]:
            end += 1
        label = OPEN if side[begin] >= 0 else closed
        start = as_point(around[begin])
        single = end == begin + 1
        yield start, Side(Line(start, as_point(around[end])) if single else Polyline(around[begin : end + 1]), label)
        begin = end
