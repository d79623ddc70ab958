"""Thin walls: narrow parts of the outside, through which a spacing that grows must not pass."""

import numpy as np

from bubblemesh.arrays import Floats, members
from bubblemesh.geometry.domain import Domain
from bubblemesh.spacing.rules.sources import short_intervals
from bubblemesh.spacing.spacing import Spacing

WIDEST = 4.0  # spacings: radius of the discs outside that a coarse cell cannot overlook
FITTING = 0.9  # depth of a disc's centre in terms of its radius
CELL = 0.5  # radii: side of the cells that part one side of a wall from the other
THINNEST = 1e-9  # of the domain's size
MOST = 5_000  # places: walls that would need more are seen as thicker than they are


def thin_walls(domain: Domain, spacing: Spacing) -> tuple[Floats, Floats]:
    """Places (k, 2) on thin walls and in their middles, and sides (k,) of cells there that keep both sides apart.

    A wall is as thick as the largest disc that touches the boundary from outside.
    """
    boundary = domain.boundary
    piece, begin, length = short_intervals(domain, spacing)
    outer = ~boundary.inner[piece]
    piece, begin, length = piece[outer], begin[outer], length[outer]
    points, tangents = boundary.points(piece, begin + length / 2), boundary.tangents(piece, begin + length / 2)
    outward = np.column_stack([tangents[:, 1], -tangents[:, 0]])  # the domain is on the left
    radius = WIDEST * spacing(points)
    widest = radius.copy()
    tried = np.arange(len(points))
    while len(tried):
        centers = points[tried] + radius[tried, None] * outward[tried]
        tried = tried[-domain.signed_distance(centers) < FITTING * radius[tried]]
        radius[tried] /= 2
        tried = tried[radius[tried] > THINNEST * domain.size]
    thin = np.flatnonzero(radius < widest)
    radius = np.maximum(radius, length[thin].sum() / (CELL * MOST))
    parts = np.ceil(length[thin] / (CELL * radius[thin])).astype(np.int64)
    wall, part = members(parts)
    mine = thin[wall]
    on_wall = boundary.points(piece[mine], begin[mine] + (part + 0.5) / parts[wall] * length[mine])
    within = on_wall + radius[mine, None] * outward[mine]
    return np.vstack([on_wall, within]), np.tile(CELL * radius[mine], 2)
