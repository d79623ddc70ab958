"""Room: how high columns may be before they meet each other, or a wall across."""

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.layers.columns import Columns
from bubblemesh.layers.heights import FEWEST_LAYERS, widest_at_feet
from bubblemesh.layers.obstacles import Obstacles
from bubblemesh.layers.sight import across
from bubblemesh.layers.walls import Walls

NARROWED = 0.35  # least width of the cells between two columns at their tops, in terms of that at their feet
SHARED = 0.3, 0.42  # of the way to a wall with layers: what columns take at least, if edges are shorter, and at most
ALONE = 0.5, 0.8  # the same to a wall without
ALONG = 0.45  # of a piece that a column follows
STEEPEST = 0.6  # change of the height along the wall
REACH = 2.5  # thicknesses that are looked at
ROOM_PASSES = 500


def room(columns: Columns, walls: Walls, obstacles: Obstacles, most: Integers) -> Floats:
    """Heights (c,) above the wall up to which columns of ``most`` (c,) layers may go."""
    # By the spacing at the foot it changes gradually along the wall, as the number of layers need not. Where that is
    # too small for layers the columns beside have fewer, but not compressed ones.
    every, few = np.arange(len(columns)), np.minimum(FEWEST_LAYERS, columns.requested)
    thickness = np.maximum.reduce([columns.thickness, columns.tops(every, most), columns.tops(every, few)])
    height = np.where(columns.ends, 0.0, thickness)
    narrowest = _between_neighbours(columns)
    height = np.minimum(height, narrowest)
    height = np.minimum(height, _up_to(obstacles, columns, thickness, narrowest))
    height = np.minimum(height, _along_pieces(columns, walls))
    return limited_slopes(columns, height)


def limited_slopes(columns: Columns, height: Floats) -> Floats:
    """Heights (c,) that change by no more than a stated slope along the wall, but for where layers end."""
    (i, j), step = columns.pair.T, STEEPEST * columns.bare_widths
    bound = ~columns.ends
    for _ in range(ROOM_PASSES):
        lower = height.copy()
        for a, b in ((i, j), (j, i)):
            np.minimum.at(lower, a, np.where(bound[b], height[b] + step, np.inf))
        if (lower == height).all():
            break
        height = lower
    return height


def _between_neighbours(columns: Columns) -> Floats:
    """Heights (c,) at which neighbours that lean towards each other become too near."""
    i, j = columns.pair.T
    across = columns.at[j] - columns.at[i]
    width = np.hypot(*across.T)
    on_wall = width > 0
    along = across / np.where(on_wall, width, 1.0)[:, None]
    grows = ((columns.up[j] - columns.up[i]) * along).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        height = np.where(on_wall & (grows < 0), (1 - NARROWED) * width / -grows, np.inf)
    return columns.least_of_pairs(height)


def _up_to(obstacles: Obstacles, columns: Columns, thickness: Floats, narrowest: Floats) -> Floats:
    """Heights (c,) at which columns of a thickness (c,) have taken their part of the way to what is across.

    Up to the heights ``narrowest`` (c,) that is also what ends between two of them.
    """
    seen = across(obstacles, columns, REACH * thickness + 2 * columns.spacing, narrowest)
    # Between edges longer than the way to a wall triangles would be flat, but not above a fan, nor across from an end.
    with np.errstate(divide="ignore"):
        width = widest_at_feet(columns)
        narrow = np.where(columns.are_in_fans, 1.0, np.minimum(seen.wall / width, 1.0))
    return share_of_way(seen.nearest, columns.spacing, seen.layered, narrow)


def share_of_way(way: Floats, spacing: Floats, shared: Booleans, narrow: Floats) -> Floats:
    """Heights (k,) that columns may have of the ways (k,) to walls across: all but a spacing, within bounds.

    What is ``shared`` (k,) with the layers of that wall is halved. The lower bound is ``narrow`` (k,) times as high.
    """
    least, most = (np.where(shared, a, b) for a, b in zip(SHARED, ALONE, strict=True))
    with np.errstate(invalid="ignore"):
        return np.where(
            np.isfinite(way),
            np.clip((way - spacing) / np.where(shared, 2, 1), narrow * least * way, most * way),
            np.inf,
        )


def _along_pieces(columns: Columns, walls: Walls) -> Floats:
    """Heights (c,) at which columns have taken their part of the piece that they follow."""
    follows = columns.follows >= 0
    length = walls.domain.boundary.lengths[columns.follows]
    return np.where(follows, ALONG * length / np.hypot(*columns.up.T), np.inf)
