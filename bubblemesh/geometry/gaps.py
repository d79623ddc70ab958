"""How far it is across the domain from places on its boundary."""

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.domain import Domain

__all__ = ["gaps"]

OFF_THE_WALL = 1e-6  # of a ray's length


def gaps(domain: Domain, piece: Integers, s: Floats, reach: Floats) -> tuple[Floats, Floats]:
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
    places : (k, 2)
        On both sides of each gap.
    widths : (k,)
        Shortest distance from the place to the wall that a ray meets, once for each such wall.
    """
    line, boundary = domain.polyline, domain.boundary
    points, (tx, ty) = boundary.points(piece, s), boundary.tangents(piece, s).T
    normal = reach[:, None] * np.column_stack([-ty, tx])
    rays = shapely.linestrings(np.stack([points + OFF_THE_WALL * normal, points + normal], axis=1))
    chords = shapely.linestrings(np.stack([line.points, line.points[line.successor]], axis=1))
    ray, chord = shapely.STRtree(chords).query(rays, predicate="intersects")
    opposite = _opposite(domain, piece[ray], s[ray], chord, reach[ray])
    ray, chord = ray[opposite], chord[opposite]
    return points[ray], shapely.distance(shapely.points(points[ray]), chords[chord])


def _opposite(domain: Domain, piece: Integers, s: Floats, chord: Integers, reach: Floats) -> Booleans:
    """Whether the chords (m,) belong to another wall than the places (m,), not to its bend or next corner."""
    line, boundary = domain.polyline, domain.boundary
    joints = np.column_stack([boundary.start, boundary.end])
    other = line.piece[chord]
    mine, theirs = joints[piece][:, :, None], joints[other][:, None, :]
    joined = ((mine == theirs) & (mine >= 0)).any(axis=(1, 2))  # -1 is no corner
    apart = np.abs(np.clip(s, line.s[chord], line.s[chord] + line.step[chord]) - s)
    apart = np.where(boundary.closed[piece], np.minimum(apart, boundary.lengths[piece] - apart), apart)
    return np.where(piece == other, apart > np.pi / 2 * reach, ~joined)
