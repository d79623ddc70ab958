"""How near lines and points inside the domain are to each other and to the rings."""

from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Floats, Integers
from bubblemesh.geometry.boundary import Boundary, Polyline
from bubblemesh.geometry.gaps import opposite

__all__ = ["Strips", "beside", "beside_tips", "inner_samples", "tips"]

OFF_THE_LINE = 1e-6  # of a ray's length
MOST_SAMPLES = 50_000


class Strips(NamedTuple):
    """Places (k, 2) with another line or point within reach, and its distance (k,), once for each such line."""

    places: Floats
    widths: Floats


def inner_samples(boundary: Boundary, longest: float) -> tuple[Integers, Floats]:
    """Pieces and arc lengths (m,) of places along all inner pieces, no farther apart than ``longest``."""
    piece, s, step = boundary.panels()
    mine = np.flatnonzero(boundary.inner[piece])
    mine = mine[:: len(mine) // MOST_SAMPLES + 1]
    parts = np.ceil(step[mine] / longest).astype(int)
    chord = np.repeat(mine, parts)
    part = np.arange(len(chord)) - np.repeat(np.cumsum(parts) - parts, parts)
    return piece[chord], s[chord] + (part + 0.5) * step[chord] / np.repeat(parts, parts)


def beside(boundary: Boundary, piece: Integers, s: Floats, reach: Floats) -> Strips:
    """Where another line is within reach of places on inner pieces, square to these.

    Parameters
    ----------
    boundary : Boundary
    piece, s : (m,)
        Pieces and arc lengths of the places.
    reach : (m,)
        How far to look to both sides.
    """
    if len(piece) == 0:
        return Strips(np.zeros((0, 2)), np.zeros(0))
    side = np.repeat([1.0, -1.0], len(piece))
    piece, s, reach = np.tile(piece, 2), np.tile(s, 2), np.tile(reach, 2)
    points, (tx, ty) = boundary.points(piece, s), boundary.tangents(piece, s).T
    normal = (side * reach)[:, None] * np.column_stack([-ty, tx])
    rays = shapely.linestrings(np.stack([points + OFF_THE_LINE * normal, points + normal], axis=1))
    line, chords = _chords(boundary)
    ray, chord = shapely.STRtree(chords).query(rays, predicate="intersects")
    apart = opposite(boundary, line, piece[ray], s[ray], chord, reach[ray])
    ray, chord = ray[apart], chord[apart]
    return Strips(points[ray], shapely.distance(shapely.points(points[ray]), chords[chord]))


def tips(boundary: Boundary) -> Integers:
    """Corners (k,) inside the domain: ends, bends and crossings of lines, and embedded points."""
    outer = ~boundary.inner & ~boundary.closed
    return np.setdiff1d(np.arange(len(boundary.corners)), np.concatenate([boundary.start[outer], boundary.end[outer]]))


def beside_tips(boundary: Boundary, corner: Integers, reach: Floats) -> Strips:
    """Inner corners (k,) with a line or another embedded point within reach (k,) that they are not joined to.

    Pieces that end there, and those that have a corner in common with these, are not looked at.
    """
    if len(corner) == 0:
        return Strips(np.zeros((0, 2)), np.zeros(0))
    line, chords = _chords(boundary)
    alone = np.setdiff1d(np.arange(len(boundary.corners)), np.concatenate([boundary.start, boundary.end]))
    things = np.concatenate([chords, shapely.points(boundary.corners[alone])])
    spots = shapely.points(boundary.corners[corner])
    number, thing = shapely.STRtree(things).query(spots, predicate="dwithin", distance=reach)
    open_, count = np.flatnonzero(~boundary.closed), len(boundary.corners)
    begin, end = boundary.start[open_], boundary.end[open_]
    joined = np.concatenate([begin * count + end, end * count + begin, np.arange(count) * (count + 1)])
    piece = np.append(line.piece, np.full(len(alone), -1))[thing]
    first, last = (np.append(ends, -1)[piece] for ends in (boundary.start, boundary.end))
    point = np.append(np.full(len(chords), -1), alone)[thing]
    here = corner[number] * count
    apart = ~np.any([np.isin(here + other, joined) & (other >= 0) for other in (first, last, point)], axis=0)
    number, thing = number[apart], thing[apart]
    return Strips(boundary.corners[corner[number]], shapely.distance(spots[number], things[thing]))


def _chords(boundary: Boundary) -> "tuple[Polyline, np.ndarray[tuple[int], np.dtype[np.object_]]]":
    """All lines as chords, with what they follow."""
    piece, s, step = boundary.panels()
    points = boundary.points(piece, s)
    line = Polyline(points, piece, s, step, np.arange(len(s)), boundary.ring[piece])
    return line, shapely.linestrings(np.stack([points, boundary.points(piece, s + step)], axis=1))
