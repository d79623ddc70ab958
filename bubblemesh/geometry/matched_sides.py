"""Periodic sides that match to few digits, of which the second one becomes exactly the first one moved."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import dist
from typing import TypeVar

import numpy as np

from bubblemesh.arrays import Integers
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.arrangement.regions import InnerParts
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.paths import Area, Curve, Line, OpenPath, Point, Ring, Side, as_point
from bubblemesh.geometry.periodic import motion_of_sides, pieces_of_side
from bubblemesh.geometry.similarity import Similarity
from bubblemesh.messages import counted, place

Path = TypeVar("Path", Ring, OpenPath)
Curves = Mapping[tuple[Point, Point], Curve]  # by their ends


def with_matched_sides(
    areas: Sequence[Area], parts: InnerParts, boundary: Boundary, names: tuple[str, str]
) -> tuple[list[Area], InnerParts]:
    """Areas and inner parts whose second side of a periodic pair is the first one moved, if it nearly was.

    The vertices of the second side, which are those of the noded ``boundary``, come to lie on their counterparts, with
    all that ends in them; curves between them become copies. Nothing changes if the sides do not match to the
    tolerance of the parts. GeometryError if that is not less than half of the shortest piece of a side.
    """
    tolerance = parts.periodic_tolerance
    _require_less_than_pieces(boundary, names, tolerance)
    first, second = (pieces_of_side(boundary, name) for name in names)
    motion, copies = motion_of_sides(boundary, first, second, tolerance)
    if (copies < 0).any():
        return list(areas), parts
    motion = _about_tip(boundary, first, second, motion)
    corners = list(map(as_point, boundary.corners))
    origin = dict[Point, Point]()
    for here, there in zip(first.tolist(), copies.tolist(), strict=True):
        origin[corners[boundary.start[there]]] = corners[boundary.end[here]]
        origin[corners[boundary.end[there]]] = corners[boundary.start[here]]
    places = {there: motion.point(here) for there, here in origin.items() if there != here}
    curves = _curves_by_ends(areas, parts)

    def changed(path: Path) -> Path:
        return _changed(path, places, lambda ends: _copy(curves, origin, ends, motion))

    regions = tuple(replace(region, area=region.area.mapped(changed)) for region in parts.regions)
    points = tuple(replace(point, at=places.get(point.at, point.at)) for point in parts.points)
    lines = tuple(map(changed, parts.lines))
    note = _note(names[1], places)
    inner = replace(parts, regions=regions, lines=lines, points=points, remarks=(*parts.remarks, *note))
    return [area.mapped(changed) for area in areas], inner


def _about_tip(boundary: Boundary, first: Integers, second: Integers, motion: Similarity) -> Similarity:
    """The turn about the corner that both sides of a wedge have, which is its own counterpart; else the motion."""
    ends = [{*boundary.start[pieces].tolist(), *boundary.end[pieces].tolist()} for pieces in (first, second)]
    for corner in ends[0] & ends[1]:
        tip = complex(*boundary.corners[corner])
        return Similarity(motion.factor, tip - motion.factor * tip)
    return motion


def _require_less_than_pieces(boundary: Boundary, names: tuple[str, str], tolerance: float) -> None:
    """Check that a tolerance cannot take one vertex of the sides for the next one; else it is a GeometryError."""
    for name in names:
        pieces = pieces_of_side(boundary, name)
        shortest = int(pieces[boundary.lengths[pieces].argmin()])
        length = float(boundary.lengths[shortest])
        if tolerance >= length / 2:
            at = place(boundary.points(np.array([shortest]), np.array([length / 2]))[0])
            raise GeometryError(
                f"periodic_tolerance of {tolerance:g} is too much for the side {name!r}, of which one piece, at {at}, "
                f"is {length:.3g} long: give less than half of that"
            )


def _curves_by_ends(areas: Sequence[Area], parts: InnerParts) -> dict[tuple[Point, Point], Curve]:
    """Curves that are not straight of all rings and lines, by their ends, in both directions."""
    rings = [*(ring for area in areas for ring in area.rings), *parts.rings]
    paths: list[Ring | OpenPath] = [*rings, *parts.lines]
    found = dict[tuple[Point, Point], Curve]()
    for path in paths:
        for number, side in enumerate(path.sides):
            if path.vertices and not isinstance(side.curve, Line):
                start, end = path.vertices[number], path.vertices[(number + 1) % len(path.vertices)]
                found[start, end] = side.curve
                found[end, start] = side.curve.reversed()
    return found


def _copy(curves: Curves, origin: Mapping[Point, Point], ends: tuple[Point, Point], motion: Similarity) -> Curve | None:
    """The moved copy of the curve whose ends are the counterparts of those given, if there is one."""
    start, end = (origin.get(at) for at in ends)
    curve = None if start is None or end is None else curves.get((start, end))
    return None if curve is None else curve.moved(motion)


def _changed(path: Path, places: Mapping[Point, Point], copy: Callable[[tuple[Point, Point]], Curve | None]) -> Path:
    """The ring or line with vertices at new places, and its sides between them."""
    if not any(vertex in places for vertex in path.vertices):
        return path
    sides = list[Side]()
    for number, side in enumerate(path.sides):
        ends = path.vertices[number], path.vertices[(number + 1) % len(path.vertices)]
        new = places.get(ends[0], ends[0]), places.get(ends[1], ends[1])
        found = None if isinstance(side.curve, Line) else copy(ends)
        sides.append(side._replace(curve=_led(side.curve, ends, new) if found is None else found))
    return replace(path, sides=tuple(sides), vertices=tuple(places.get(vertex, vertex) for vertex in path.vertices))


def _led(curve: Curve, ends: tuple[Point, Point], new: tuple[Point, Point]) -> Curve:
    """The curve turned and stretched so that it has new ends."""
    if ends == new:
        return curve
    if isinstance(curve, Line):
        return Line(*new)
    (a, b), (c, d) = ([complex(*at) for at in pair] for pair in (ends, new))
    factor = (d - c) / (b - a) if a != b else 1 + 0j
    return curve.moved(Similarity(factor, c - factor * a))


def _note(name: str, places: Mapping[Point, Point]) -> tuple[str, ...]:
    """Note on the vertices of a side that were moved."""
    moved = {before: dist(before, after) for before, after in places.items() if before != after}
    if not moved:
        return ()
    farthest = max(moved, key=lambda before: moved[before])
    return (
        f"{counted(len(moved), 'corner')} of the periodic side {name!r} moved onto counterparts, by up to "
        f"{moved[farthest]:.2g} at {place(farthest)}",
    )
