"""Vertices of a ring next to others of the same ring: short sides become a point, and spikes are left out."""

from collections.abc import Callable

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers, components, different_rows
from bubblemesh.geometry.nesting import Shapes


def without_near_vertices(shapes: Shapes, near: float) -> tuple[Shapes, Booleans]:
    """Shapes (n,) without sides up to the length ``near`` and without spikes up to that width; which of them changed.

    They are valid polygons, some of several parts. All of them that have both ends of a short side have the same one
    afterwards. A shape that would become invalid or vanish keeps its sides, or its spikes, and with it its neighbours.
    """
    found = _without_short_sides(shapes, near)
    for k in _with_spikes(found, near).tolist():
        shape = found[k]
        blunt = _blunt(shape, near)
        if (
            shapely.get_num_coordinates(blunt) < shapely.get_num_coordinates(shape)
            and blunt.is_valid
            and blunt.area > 0
        ):
            found[k] = blunt
    return found, ~shapely.equals_exact(found, shapes)


def _without_short_sides(shapes: Shapes, near: float) -> Shapes:
    """The shapes with both ends of each short side in one place, that of the first of them."""
    coordinates, owner = shapely.get_coordinates(shapes, return_index=True)
    points, number = different_rows(coordinates)
    rings = shapely.get_rings(shapely.get_parts(shapes))
    ring = shapely.get_coordinates(rings, return_index=True)[1]
    place = _places(points, number, ring, near)
    while (place[number] != number).any():
        made = shapely.set_coordinates(shapes.copy(), points[place][number])
        changed = np.unique(owner[place[number] != number])
        made[changed] = [_once(shape) for shape in made[changed]]
        wrong = changed[~shapely.is_valid(made[changed]) | (shapely.area(made[changed]) <= 0)]
        if len(wrong) == 0:
            return made
        stays = np.zeros(len(points), bool)
        stays[number[np.isin(owner, wrong)]] = True
        place = np.where(stays | stays[place], np.arange(len(points)), place)
    return shapes.copy()


def _places(points: Floats, number: Integers, ring: Integers, near: float) -> Integers:
    """Number (p,) of the point to which each point (p, 2) goes, by the points' numbers (m,) along rings (m,)."""
    same = np.flatnonzero(np.diff(ring) == 0)
    sides = np.column_stack([number[same], number[same + 1]])
    short = sides[np.hypot(*(points[sides[:, 0]] - points[sides[:, 1]]).T) <= near]
    group = components(short, len(points))
    first = np.full(len(points), len(points))
    np.minimum.at(first, group, np.arange(len(points)))
    return first[group]


def _once(shape: shapely.Geometry) -> shapely.Geometry:
    """A shape without points twice in a row; empty if a ring around it vanishes."""
    return _through(shape, lambda points: points[(points != np.roll(points, 1, axis=0)).any(axis=1)])


def _with_spikes(shapes: Shapes, thin: float) -> Integers:
    """Numbers (k,) of the shapes of which `blunted` leaves out a point."""
    parts, shape = shapely.get_parts(shapes, return_index=True)
    rings, part = shapely.get_rings(parts, return_index=True)
    points, ring = shapely.get_coordinates(rings, return_index=True)
    inner = np.diff(ring) == 0  # the last point of a ring is its first
    steps, ring = np.diff(points, axis=0)[inner], ring[:-1][inner]
    first = np.flatnonzero(np.diff(ring, prepend=-1))
    count = np.diff(first, append=len(ring))
    before = np.arange(len(ring)) - 1
    before[first] = first + count - 1
    spikes = _turn_back(steps[before], steps, thin) & (np.repeat(count, count) > 3)
    return np.unique(shape[part[ring[spikes]]])


def _turn_back(before: Floats, after: Floats, thin: float) -> Booleans:
    """Mask (m,) of the points where steps (m, 2) after them run back beside those before them, nearer than ``thin``."""
    (ux, uy), (wx, wy) = before.T, after.T
    longer = np.maximum(np.hypot(ux, uy), np.hypot(wx, wy))
    back: Booleans = (ux * wx + uy * wy < 0) & (np.abs(ux * wy - uy * wx) <= thin * longer)
    return back


def _blunt(shape: shapely.Geometry, near: float) -> shapely.Geometry:
    """A shape without spikes up to a width; empty if a ring around it vanishes."""
    return _through(shape, lambda points: blunted(points, near))


def _through(shape: shapely.Geometry, change: Callable[[Floats], Floats]) -> shapely.Geometry:
    """A shape through other points of its rings; rings of less than three points vanish."""
    made = []
    for part in shapely.get_parts(shape):
        outer, *holes = (change(shapely.get_coordinates(ring)[:-1]) for ring in shapely.get_rings(part))
        if len(outer) > 2:
            made.append(shapely.Polygon(outer, [hole for hole in holes if len(hole) > 2]))
    return made[0] if len(made) == 1 else shapely.MultiPolygon(made)


def blunted(points: Floats, thin: float) -> Floats:
    """Points (m, 2) of a ring without those at which it turns back beside itself, nearer than ``thin``."""
    while len(points) > 3:
        before, after = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
        spikes = np.flatnonzero(_turn_back(before, after, thin))
        if len(spikes) == 0:
            break
        points = np.delete(points, spikes[0], axis=0)  # its neighbour may be a spike now
    return points
