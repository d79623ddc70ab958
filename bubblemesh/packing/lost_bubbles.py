"""Bubbles that leave the domain on their way: where flips end, the rest of a net is connected without them."""

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, all_of_rows, each_once, taken
from bubblemesh.kernels.linking import legalised
from bubblemesh.kernels.predicates import turns
from bubblemesh.packing.splicing import removed

MOST_LOST = 100  # bubbles: of more it is faster to triangulate anew


def connected_without_lost(
    start: Floats, x: Floats, triangles: Integers, edges: Integers, facets: Integers, rim: Integers
) -> tuple[Integers, Integers] | None:
    """Triangles (t, 3) and edges (m, 2) of the nodes that are inside when they have gone from start to x (n, 2).

    They come by flips from ``triangles`` and ``edges`` between the same nodes, in the order of `linking.in_order`.
    Facets stay, and those of the ``rim`` bound the domain. None where no node has left it, or where that cannot be
    decided: then all nodes have to be triangulated anew.
    """
    lost = _outside(x, triangles, facets, rim)
    if lost is None or not lost.any() or all_of_rows(taken(lost, edges)).any():
        return None
    rest, done = removed(start, triangles, lost)
    if not done[lost].all():
        return None
    kept, number = np.flatnonzero(~lost), np.cumsum(~lost) - 1
    found = legalised(number[rest], start[kept], x[kept], number[facets])
    return None if found is None else (kept[found.triangles], kept[found.edges])


def _outside(x: Floats, triangles: Integers, facets: Integers, rim: Integers) -> Booleans | None:
    """Nodes (n,) that have left through a facet of the rim; None where rounding would decide, or there are many.

    The triangle behind that facet is turned over then. If flips on the way have put other nodes there, these are not
    found, and no harm is done.
    """
    fixed = int(facets.max()) + 1
    beside = triangles[(triangles < fixed).sum(axis=1) == 2]
    turned = beside[turns(*(x[beside[:, k]] for k in range(3))) <= 0]
    tested = each_once(turned[turned >= fixed])
    if len(tested) > MOST_LOST:
        return None
    p, a, b = x[tested][:, None], x[rim[:, 0]], x[rim[:, 1]]
    turn = turns(a, b, np.broadcast_to(p, (len(tested), *a.shape)))
    beside_it = ((np.minimum(a, b) <= p) & (p <= np.maximum(a, b))).any(axis=-1)
    if (beside_it & (turn == 0)).any():
        return None
    # A ray to the right passes an odd number of facets if it begins inside.
    upwards = b[:, 1] > a[:, 1]
    crossed = ((a[:, 1] > p[..., 1]) != (b[:, 1] > p[..., 1])) & ((turn > 0) == upwards)
    lost = np.zeros(len(x), bool)
    lost[tested[crossed.sum(axis=1) % 2 == 0]] = True
    return lost
