"""Regions, embedded lines and points outside of the domain: left out if the case says so, else an error."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import shapely

from bubblemesh.arrays import Floats
from bubblemesh.errors import GeometryError, about
from bubblemesh.geometry.arrangement import TOUCHING
from bubblemesh.geometry.arrangement.regions import InnerParts
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.paths import InnerPoint, OpenPath, Point, as_point
from bubblemesh.messages import counted, listed, place

MOST_NAMED = 5


def without_outside(
    parts: InnerParts, polygon: shapely.Polygon | shapely.MultiPolygon, signed_distance: Callable[[Floats], Floats]
) -> InnerParts:
    """The parts without the optional regions, lines and points outside of a domain, which are listed in the notes.

    ``signed_distance`` is that of points (m, 2) from its boundary, positive inside. GeometryError if other points are
    outside, with their number and the first of them.
    """
    parts = _without_seeds(_without_regions(_without_parts(parts, polygon), polygon), signed_distance)
    if not any(thing.optional for thing in parts.lines) and not parts.points:
        return parts
    x0, y0, x1, y1 = polygon.bounds
    tolerance = TOUCHING * max(x1 - x0, y1 - y0)
    at = np.array([point.at for point in parts.points], float).reshape(-1, 2)
    outside = signed_distance(at) < -tolerance
    points = [point for point, out in zip(parts.points, outside.tolist(), strict=True) if out]
    _require_none([point for point in points if not point.optional])

    def middle_outside(line: OpenPath) -> Point | None:
        """The middle of a line's first chord, if all of the line is outside."""
        curves = Boundary.empty().with_inner([line])
        # Chords of a line along a curve of the boundary may be beyond those of the polygon.
        if length_inside(curves, polygon) > tolerance:
            return None
        middles = _middles(curves)
        return as_point(middles[0]) if (signed_distance(middles) < -tolerance).all() else None

    middles = [(line, middle_outside(line)) for line in parts.lines if line.optional]
    lines = [line for line, middle in middles if middle is not None]
    notes = [f"{counted(len(points), 'point')} left out, outside of the domain: {_named(points)}"] if points else []
    notes += [f"{counted(len(lines), 'line')} left out, outside of the domain"] if lines else []
    gone = {*map(id, points), *map(id, lines)}
    places = {side.label or line.label: at for line, at in middles if at is not None for side in line.sides}
    return replace(
        parts,
        lines=tuple(line for line in parts.lines if id(line) not in gone),
        points=tuple(point for point in parts.points if id(point) not in gone),
        remarks=(*parts.remarks, *notes),
        left_out=places | {point.label: point.at for point in points},
    )


def _without_parts(parts: InnerParts, polygon: shapely.Polygon | shapely.MultiPolygon) -> InnerParts:
    """The parts without what later regions leave of others outside of a domain, if they leave some inside."""
    outside = [region.cut and not polygon.intersects(region.core) for region in parts.regions]
    left = {region.name for region, is_outside in zip(parts.regions, outside, strict=True) if not is_outside}
    kept = [one for one, is_out in zip(parts.regions, outside, strict=True) if not is_out or one.name not in left]
    return replace(parts, regions=tuple(kept))


def _without_regions(parts: InnerParts, polygon: shapely.Polygon | shapely.MultiPolygon) -> InnerParts:
    """The parts without the optional regions that have nothing but their rim in common with a domain."""
    optional = [region for region in parts.regions if region.area.outer.optional]
    gone = [region for region in optional if not polygon.intersects(region.core)]
    if not gone:
        return parts
    names = listed([*dict.fromkeys(repr(region.name) for region in gone)], MOST_NAMED)
    note = f"{counted(len(gone), 'region')} left out, outside of the domain: {names}"
    left = set(map(id, gone))
    kept = tuple(region for region in parts.regions if id(region) not in left)
    return replace(parts, regions=kept, remarks=(*parts.remarks, note))


def _without_seeds(parts: InnerParts, signed_distance: Callable[[Floats], Floats]) -> InnerParts:
    """The parts without the optional points of regions that are outside of a domain."""
    optional = [seed for seed in parts.seeds if seed.optional]
    if not optional:
        return parts
    outside = signed_distance(np.array([seed.at for seed in optional], float)) < 0
    gone = [seed for seed, out in zip(optional, outside.tolist(), strict=True) if out]
    if not gone:
        return parts
    left = set(map(id, gone))
    note = f"{counted(len(gone), 'point')} of regions left out, outside of the domain"
    kept = tuple(seed for seed in parts.seeds if id(seed) not in left)
    return replace(parts, seeds=kept, remarks=(*parts.remarks, note))


def _require_none(points: Sequence[InnerPoint]) -> None:
    if not points:
        return
    skip = ", or set outside: skip" if "points" in points[0].key else ""  # in an entry of a case
    with about(points[0].key):
        if len(points) == 1:
            one = f"{points[0].label!r} at {place(points[0].at)}"
            raise GeometryError(f"the point {one} lies outside the domain: move or remove it{skip}")
        raise GeometryError(
            f"{counted(len(points), 'point')} lie outside the domain ({_named(points)}): move or remove them{skip}"
        )


def _named(points: Sequence[InnerPoint]) -> str:
    named = ", ".join(f"{point.label!r} at {place(point.at)}" for point in points[:MOST_NAMED])
    return f"{named} and {len(points) - MOST_NAMED} more" if len(points) > MOST_NAMED else named


def _middles(curves: Boundary) -> Floats:
    """Points (m, 2) on curves, halfway along their chords."""
    piece, s, step = curves.stations()
    return curves.points(piece, s + step / 2)


def length_inside(curves: Boundary, polygon: shapely.Polygon | shapely.MultiPolygon) -> float:
    """Length of the part of curves that is inside a prepared polygon, or on its boundary, by their chords."""
    _, _, _, start, end = curves.chords()
    chords = shapely.linestrings(np.stack([start, end], axis=1))
    inside = shapely.contains_properly(polygon, chords)
    others = chords[~inside]
    parts = shapely.intersection(others[shapely.intersects(polygon, others)], polygon)
    return float(shapely.length(chords[inside]).sum() + shapely.length(parts).sum())
