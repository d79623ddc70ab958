"""Points that stand out: how far it is from ends and sharp bends of lines to what is ahead of them."""

from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Floats, Integers
from bubblemesh.geometry.departures import departures
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.gaps import Gaps, Walls, kept_within

__all__ = ["Tips", "ahead", "tips"]

SHARPEST_BEND = np.cos(np.radians(120))  # of lines that go on, rather than stand out
BEHIND = 0.9  # cosine of the angle to the tip's own lines, above which something is a part of these
PARTS = (0.05, 0.5, 0.95)  # of the way that lie in the domain
DOUBLINGS = 8  # of the reach: what is near is found without all that is far


class Tips(NamedTuple):
    """Corners (k,) that stand out into the domain, and directions (k, 2) of the lines there.

    Both are the same at the end of a line, and zero for an embedded point.
    """

    corner: Integers
    first: Floats
    second: Floats


def tips(domain: Domain) -> Tips:
    """Embedded points, ends of lines, and sharp bends of lines and of rings into the domain."""
    boundary = domain.boundary
    leaving = departures(boundary)
    direction = np.column_stack([np.cos(leaving.direction), np.sin(leaving.direction)])
    count = np.bincount(leaving.corner, minlength=len(boundary.corners))
    start = np.cumsum(count) - count
    alone, open_end, bend = (np.flatnonzero(count == number) for number in (0, 1, 2))
    a, b = start[bend], start[bend] + 1
    sharp = (direction[a] * direction[b]).sum(axis=1) > SHARPEST_BEND
    # The domain is on the left of a ring, and so all of it is that is not between the lines.
    ring = ~boundary.inner[leaving.piece[a]] & ~boundary.inner[leaving.piece[b]]
    ahead = np.where(leaving.forward[a], leaving.angle_to(leaving.following)[a], leaving.angle_to(leaving.following)[b])
    bend, a, b = (column[sharp & (~ring | (ahead > np.pi))] for column in (bend, a, b))
    corner = np.concatenate([alone, open_end, bend])
    none = np.zeros((len(alone), 2))
    first, second = (np.vstack([none, direction[start[open_end]], direction[which]]) for which in (a, b))
    return Tips(corner, first, second)


def ahead(walls: Walls, some: Tips, reach: Floats) -> Gaps:
    """The nearest line or embedded point within reach (k,) of each tip that is not behind it."""
    domain, boundary = walls.domain, walls.domain.boundary
    open_ = ~boundary.closed
    alone = np.setdiff1d(np.arange(len(boundary.corners)), [boundary.start[open_], boundary.end[open_]])
    things = np.append(walls.tree.geometries, shapely.points(boundary.corners[alone]))
    inner = np.append(boundary.inner[walls.chords.piece], np.ones(len(alone), bool))
    on_ring = np.isin(some.corner, [boundary.start[~boundary.inner], boundary.end[~boundary.inner]])
    tree, spots = shapely.STRtree(things), shapely.points(boundary.corners[some.corner])
    left, found = np.arange(len(spots)), []
    for share in 2.0 ** np.arange(-DOUBLINGS, 1):
        tip, thing = tree.query(spots[left], predicate="dwithin", distance=share * reach[left])
        tip = left[tip]
        ways = shapely.get_coordinates(shapely.shortest_line(spots[tip], things[thing])).reshape(-1, 2, 2)
        place, foot = ways[:, 0], ways[:, 1]
        width = np.hypot(*(foot - place).T)
        behind = np.max([(line[tip] * (foot - place)).sum(axis=1) for line in (some.first, some.second)], axis=0)
        gaps = Gaps(tip, place, foot, width, inner[thing] | ~on_ring[tip])
        gaps = kept_within(domain, gaps.kept((width > 0) & (behind < BEHIND * width)), PARTS)
        order = np.lexsort((gaps.widths, gaps.number))
        found.append(gaps.kept(order[np.diff(gaps.number[order], prepend=-1) != 0]))
        left = np.setdiff1d(left, gaps.number)
    return Gaps(*(np.concatenate(column) for column in zip(*found, strict=True)))
