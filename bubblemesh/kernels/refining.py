"""Triangles whose edges get nodes in their middles, for compiled kernels: without them all is triangulated anew."""

import numpy as np

from bubblemesh.arrays import Integers, contained
from bubblemesh.kernels.library import Library

LEFT_OUT, WHOLE = -1, -2  # numbers of nodes that are left out, and of middles that there are not


def refined_triangles(
    compiled: Library, triangles: Integers, edges: Integers, number: Integers, middle: Integers
) -> tuple[Integers, Integers]:
    """Parts (u, 3) of triangles (t, 3), and the sides (s, 2) at which others are missing.

    The edges (m, 2) are in the order of `linking.in_order`, and have nodes in their middles with the numbers (m,), or
    are ``WHOLE``; nodes are numbered anew by ``number`` (n,). Parts with a node that is ``LEFT_OUT`` are missing, and
    the sides turn as these did.
    """
    t, given = len(triangles), (np.ascontiguousarray(triangles), len(edges), np.ascontiguousarray(edges))
    kept, sides, count = np.empty((4 * t, 3), np.int64), np.empty((4 * t, 2), np.int64), np.empty(2, np.int64)
    compiled.call("refine_triangles", len(number), t, *given, number, middle, kept, sides, count)
    kept, sides = kept[: count[0]], sides[: count[1]]
    # Sides between two that are missing come in both directions.
    n = int(sides.max(initial=0)) + 1
    keys, reverse = (first * n + last for first, last in (sides.T, sides.T[::-1]))
    return kept, sides[~contained(keys, np.sort(reverse))]
