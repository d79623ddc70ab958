"""How far it is across the domain from places on its boundary."""

from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.boundary import Boundary, Polyline
from bubblemesh.geometry.domain import Domain

__all__ = ["Gaps", "gaps", "opposite"]

OFF_THE_WALL = 1e-6  # of a ray's length


class Gaps(NamedTuple):
    """Places (k, 2) on the boundary, distances (k,) to another wall, and the nearest points (k, 2) there."""

    places: Floats
    widths: Floats
    feet: Floats


def gaps(domain: Domain, piece: Integers, s: Floats, reach: Floats) -> Gaps:
    """Places (k, 2) on the boundary with another wall within reach, and the distances (k,) to it.

    Parameters
    ----------
    domain : Domain
    piece, s : (m,)
        Boundary pieces and arc lengths of the places.
    reach : (m,)
        How far to look, square to the boundary.

    Returns
    -------
    Gaps
        On both sides of each gap, once for each wall that a ray from the place meets, with the shortest way to it.
    """
    line, boundary = domain.polyline, domain.boundary
    points, (tx, ty) = boundary.points(piece, s), boundary.tangents(piece, s).T
    normal = reach[:, None] * np.column_stack([-ty, tx])
    rays = shapely.linestrings(np.stack([points + OFF_THE_WALL * normal, points + normal], axis=1))
    chords = shapely.linestrings(np.stack([line.points, line.points[line.successor]], axis=1))
    ray, chord = shapely.STRtree(chords).query(rays, predicate="intersects")
    apart = opposite(boundary, line, piece[ray], s[ray], chord, reach[ray])
    ray, chord = ray[apart], chord[apart]
    ways = shapely.get_coordinates(shapely.shortest_line(shapely.points(points[ray]), chords[chord]))
    feet = ways.reshape(-1, 2, 2)[:, 1]
    return Gaps(points[ray], np.hypot(*(feet - points[ray]).T), feet)


def opposite(
    boundary: Boundary, line: Polyline, piece: Integers, s: Floats, chord: Integers, reach: Floats
) -> Booleans:
    """Whether the chords (m,) belong to another wall than the places (m,), not to its bend or next corner."""
    joints = np.column_stack([boundary.start, boundary.end])
    other = line.piece[chord]
    mine, theirs = joints[piece][:, :, None], joints[other][:, None, :]
    joined = ((mine == theirs) & (mine >= 0)).any(axis=(1, 2))  # -1 is no corner
    apart = np.abs(np.clip(s, line.s[chord], line.s[chord] + line.step[chord]) - s)
    apart = np.where(boundary.closed[piece], np.minimum(apart, boundary.lengths[piece] - apart), apart)
    return np.where(piece == other, apart > np.pi / 2 * reach, ~joined)
