"""Ends of cuts: bubbles on walls and lines that only cuts needed go, or move, where they are too near to others."""

from dataclasses import replace

import numpy as np

from bubblemesh.arrays import Floats, Integers, any_of_rows
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.net import Net
from bubblemesh.spacing.spacing import Spacing

CROWDED = 0.7  # spacings from the next bubble along the wall
LONGEST = 1.45  # spacings: the side that is left
WAYS = 1.0, 0.5, 0.25  # how far a bubble moves, the first that turns no triangle over


def merged_ends(
    x: Floats, spacing: Spacing, triangles: Integers, facets: Integers, ends: Integers
) -> tuple[Integers, Integers]:
    """Triangles (t, 3) without the crowded ones of bubbles ``ends`` (k,), and which bubble (n,) stands for each.

    A crowded one is merged with a neighbour along its facets (b, 2), if no triangle is turned over by that. The places
    are x (n, 2), and the spacing is that along these facets.
    """
    stands, (before, after) = np.arange(len(x)), _neighbours(facets, len(x))
    chosen = np.zeros(len(x), bool)
    chosen[ends] = True
    beside = any_of_rows(chosen[triangles])
    rest, near = triangles[~beside], triangles[beside]
    d = spacing.towards(x[ends], x[after[ends]] - x[before[ends]])
    for end, wide in zip(ends.tolist(), d.tolist(), strict=True):
        neighbours = np.array([before[end], after[end]])
        length = np.hypot(*(x[neighbours] - x[end]).T)
        across = np.hypot(*(x[neighbours[0]] - x[neighbours[1]]))
        if length.min() >= CROWDED * wide or across > LONGEST * wide or (stands[neighbours] != neighbours).any():
            continue
        for neighbour in neighbours[np.argsort(length)].tolist():
            moved = np.where(near == end, neighbour, near)
            ordered = np.sort(moved, axis=1)
            flat = (ordered[:, 1:] == ordered[:, :-1]).any(axis=1)
            if (signed_areas(x, moved[(near == end).any(axis=1) & ~flat]) > 0).all():
                near, stands[end] = moved[~flat], neighbour
                break
    return np.concatenate([rest, near]), stands


def spread_ends(net: Net, boundary: Boundary, ends: Integers, spacing: Spacing) -> Bubbles:
    """The bubbles of a net, with ``ends`` (k,) that are crowded half-way between their neighbours along the boundary.

    They move less far where triangles would be turned over.
    """
    bubbles, triangles = net.bubbles, net.triangles
    corners, (before, after) = bubbles.corners, _neighbours(net.facets, len(bubbles))
    ends = ends[~boundary.closed[bubbles.piece[ends - corners]]]
    piece, first, last = bubbles.piece[ends - corners], before[ends], after[ends]
    x, s = bubbles.x.copy(), np.append(np.zeros(corners), bubbles.s)
    begin, end = np.where(first < corners, 0.0, s[first]), np.where(last < corners, boundary.lengths[piece], s[last])
    wide = spacing.towards(x[ends], x[last] - x[first])
    nearest = np.minimum(*(np.hypot(*(x[ends] - x[other]).T) for other in (first, last)))
    for k in np.flatnonzero(nearest < CROWDED * wide).tolist():
        number, around = ends[k], triangles[(triangles == ends[k]).any(axis=1)]
        here, there = s[number], (begin[k] + end[k]) / 2
        for way in WAYS:
            s[number] = here + way * (there - here)
            x[number] = boundary.points(piece[k : k + 1], s[number : number + 1])[0]
            if (signed_areas(x, around) > 0).all():
                break
        else:
            x[number], s[number] = bubbles.x[number], here
    return replace(bubbles, x=x, d=spacing.extended(x), s=s[corners:])


def _neighbours(facets: Integers, bubbles: int) -> tuple[Integers, Integers]:
    """Bubble (n,) before each of so many along the facets (b, 2), and after it; -1 without one."""
    before, after = np.full(bubbles, -1), np.full(bubbles, -1)
    before[facets[:, 1]], after[facets[:, 0]] = facets[:, 0], facets[:, 1]
    return before, after
