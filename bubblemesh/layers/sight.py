"""Sight: what columns see across from them, and how far away it is."""

from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers, concatenated, select
from bubblemesh.layers.columns import Columns
from bubblemesh.layers.obstacles import Obstacles

OWN_WALL = 1e-6  # of a line's length
NEARER = 0.9  # of the ways to the walls above: what ends nearer between two columns is no bend of these walls


class Across(NamedTuple):
    """Walls and ends of walls across from columns (c,); where there is nothing, ways are infinite."""

    wall: Floats  # (c,): height above the foot at which a wall goes on across the column
    nearest: Floats  # (c,): the same of the nearest wall or end
    layered: Booleans  # (c,): whether that has layers


class _Seen(NamedTuple):
    """Heights (k,) above the feet of columns (k,) at which something is, and whether it has layers (k,)."""

    column: Integers
    way: Floats
    layered: Booleans


def across(obstacles: Obstacles, columns: Columns, reach: Floats, narrowest: Floats) -> Across:
    """Find what is across from straight columns up to heights (c,), in their direction and in that at the foot.

    Two neighbours see ends of walls between them, below the heights at which they are ``narrowest`` (c,) too.
    """
    straight = (columns.follows < 0) & ~columns.ends
    # Columns with nodes in common go up from behind the wall.
    start = columns.tops(np.arange(len(columns)), columns.joined)
    origin = obstacles.seen(columns.at) + start[:, None] * columns.up
    bent = straight & ~columns.are_pinched & (columns.foot_up != columns.up).any(axis=1)
    above = concatenated(
        [
            _above(obstacles, columns.up, origin, reach, np.flatnonzero(straight)),
            _above(obstacles, columns.foot_up, origin, reach, np.flatnonzero(bent)),
        ]
    )
    wall, _ = _nearest(above, len(columns))
    pairs = columns.pair[straight[columns.pair].all(axis=1) & ~columns.pinch]
    ends = _between(obstacles, columns, origin, np.minimum(reach, narrowest), pairs)
    # A wall that goes on above both is seen from each of them at its own distance.
    first, second = ends
    nearer = np.maximum(first.way, second.way) < NEARER * np.minimum(wall[first.column], wall[second.column])
    nearest, layered = _nearest(concatenated([above, *(select(end, nearer) for end in ends)]), len(columns))
    return Across(wall + start, nearest + start, layered)


def _above(obstacles: Obstacles, up: Floats, origin: Floats, reach: Floats, which: Integers) -> _Seen:
    """Walls above the columns (k,), straight ``up`` (c, 2) from their origins (c, 2) to a reach (c,)."""
    ray = up * reach[:, None]
    rays = shapely.linestrings(np.stack([origin, origin + ray], axis=1)[which])
    of, line = obstacles.tree.query(rays, "intersects")
    of = which[of]
    along = (obstacles.end - obstacles.start)[line]
    over = obstacles.start[line] - origin[of]
    (rx, ry), (ux, uy), (ox, oy) = ray[of].T, along.T, over.T
    with np.errstate(divide="ignore", invalid="ignore"):
        way = reach[of] * (ox * uy - oy * ux) / (rx * uy - ry * ux)
    # A ray begins on its own wall.
    met = np.isfinite(way) & (way > OWN_WALL * np.hypot(*along.T))
    return _Seen(of[met], way[met], obstacles.layered[line[met]])


def _between(
    obstacles: Obstacles, columns: Columns, origin: Floats, reach: Floats, pairs: Integers
) -> tuple[_Seen, _Seen]:
    """Ends of walls between the pairs (k, 2) of columns, as seen from the first ones and from the second ones."""
    (i, j), high = pairs.T, reach[pairs].min(axis=1)[:, None]
    corners = [origin[i], origin[j], origin[j] + high * columns.up[j], origin[i] + high * columns.up[i]]
    points = np.concatenate([obstacles.start, obstacles.end])
    layered = np.tile(obstacles.layered, 2)
    between = shapely.polygons(np.stack(corners, axis=1))
    # Right above a column they count, too, whatever rounding does.
    pair, point = shapely.STRtree(shapely.points(points)).query(between, "dwithin", distance=OWN_WALL * high[:, 0])
    seeing = pairs[pair].T
    up = columns.up[seeing]
    way = ((points[point] - origin[seeing]) * up).sum(axis=2) / (up * up).sum(axis=2)
    # Both stand on ends of their own wall.
    met = (way > OWN_WALL * high[pair, 0]).all(axis=0)
    first, second = (_Seen(column[met], one[met], layered[point[met]]) for column, one in zip(seeing, way, strict=True))
    return first, second


def _nearest(seen: _Seen, count: int) -> tuple[Floats, Booleans]:
    """Ways (c,) to the nearest of what so many columns see, infinite if that is nothing, and if it has layers (c,)."""
    order = np.argsort(-seen.way, kind="stable")  # the last one written stays
    way, layered = np.full(count, np.inf), np.zeros(count, bool)
    way[seen.column[order]], layered[seen.column[order]] = seen.way[order], seen.layered[order]
    return way, layered
