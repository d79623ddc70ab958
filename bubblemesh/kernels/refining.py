"""Triangles whose edges get nodes in their middles. Without compiled kernels all is triangulated anew."""

import numpy as np

from bubblemesh.arrays import Integers, contained
from bubblemesh.kernels.library import call, or_none

LEFT_OUT, WHOLE = -1, -2  # in place of the number of a node that is left out, and of an edge's middle if it has none


@or_none
def refined_triangles(
    triangles: Integers, edges: Integers, number: Integers, middle: Integers
) -> tuple[Integers, Integers]:
    """Parts (u, 3) of triangles (t, 3), and the sides (s, 2) at which parts are missing.

    Parameters
    ----------
    triangles
        Triangles (t, 3).
    edges
        Edges (m, 2) in the order of `linking.in_order`.
    number
        New numbers (n,) of the nodes, or ``LEFT_OUT``: parts with such a node are missing.
    middle
        Numbers (m,) of the nodes in the middles of the edges, or ``WHOLE`` for edges that are not divided.

    Returns
    -------
    tuple
        The parts, and the sides of missing ones, in the direction that they had in these.
    """
    t = len(triangles)
    kept, sides, count = np.empty((4 * t, 3), np.int64), np.empty((4 * t, 2), np.int64), np.empty(2, np.int64)
    call(
        "refine_triangles",
        n=len(number),
        t=t,
        triangles=np.ascontiguousarray(triangles),
        m=len(edges),
        edges=np.ascontiguousarray(edges),
        number=number,
        middle=middle,
        kept=kept,
        sides=sides,
        count=count,
    )
    kept, sides = kept[: count[0]], sides[: count[1]]
    # A side between two missing parts comes in both directions.
    n = int(sides.max(initial=0)) + 1
    keys, reverse = (first * n + last for first, last in (sides.T, sides.T[::-1]))
    return kept, sides[~contained(keys, np.sort(reverse))]
