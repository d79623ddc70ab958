"""Ends of cuts: bubbles on walls and lines that only cuts needed there go where they are too near to others."""

import numpy as np

from bubblemesh.arrays import Floats, Integers, any_of_rows
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.spacing.spacing import Spacing

CROWDED = 0.7  # spacings from the next bubble along the wall
LONGEST = 1.45  # spacings: the side that is left


def merged(
    x: Floats, spacing: Spacing, triangles: Integers, facets: Integers, ends: Integers
) -> tuple[Integers, Integers]:
    """Triangles (t, 3) without the crowded ones of bubbles ``ends`` (k,), and which bubble (n,) stands for each.

    A crowded one is merged with a neighbour along its facets (b, 2), if no triangle is turned over by that. The places
    are x (n, 2), and the spacing is that along these facets.
    """
    before, after, stands = np.full(len(x), -1), np.full(len(x), -1), np.arange(len(x))
    before[facets[:, 1]], after[facets[:, 0]] = facets[:, 0], facets[:, 1]
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
