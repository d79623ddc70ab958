"""Triangles and their edges in an order of their own, and flips of edges that make them Delaunay."""

from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers, ShortIntegers, each_once
from bubblemesh.kernels.library import library

UNCHANGED = 2  # outcome of the kernel


class Legal(NamedTuple):
    """A constrained Delaunay triangulation, in the order of `in_order`."""

    triangles: Integers  # (t, 3)
    edges: Integers  # (m, 2)
    twins: ShortIntegers  # (t, 3): of the side from each node to the next, that of the triangle across: its number in
    # these three columns, -1 on the rim and on facets


def in_order(triangles: Integers, n: int) -> tuple[Integers, Integers]:
    """Triangles (t, 3) of ``n`` nodes and their edges (m, 2), each once, in an order of their own.

    Triangles begin with their lowest node and keep their turn, edges have the lower node first; both ascend.
    """
    compiled = library()
    if compiled is None:
        return in_order_in_numpy(triangles, n)
    result, (edges, count) = np.empty(triangles.shape, np.int64), room_of_edges(triangles)
    compiled.call("order_triangles", n, len(result), np.ascontiguousarray(triangles), result, edges, count)
    return result, shortened(edges, count)


def in_order_in_numpy(triangles: Integers, n: int) -> tuple[Integers, Integers]:
    """Triangles (t, 3) and edges (m, 2) as of `in_order`, made in NumPy."""
    first = triangles.argmin(axis=1)
    a, b, c = (np.take_along_axis(triangles, (first[:, None] + k) % 3, axis=1)[:, 0] for k in range(3))
    order = np.argsort(a * n + b, kind="stable")
    sides = np.concatenate([np.minimum(p, q) * n + np.maximum(p, q) for p, q in ((a, b), (b, c), (c, a))])
    return np.column_stack([a, b, c])[order], np.stack(np.divmod(each_once(sides), n), axis=1)


def legalised(
    triangles: Integers, start: Floats, x: Floats, facets: Integers, known: Legal | None = None, is_open: bool = False
) -> Legal | None:
    """The constrained Delaunay triangulation of nodes x (n, 2), by flips from triangles (t, 3) between these nodes.

    The facets (b, 2) stay, and the triangles lie on the same side of those at the rim. Each is a side of a triangle,
    and the rim is of facets only, unless it ``is_open``. Where nodes would invert triangles they go to x step by step
    from ``start`` (n, 2), with flips on the way. Triangles and edges come as from `in_order`; None where rounding would
    decide, a triangle stays inverted, facets are not as they should be, or no kernels are compiled: triangulate anew.
    What was ``known`` of these triangles and facets spares work, and comes back where there is no flip.

    References
    ----------
    C. L. Lawson, "Software for C1 surface interpolation", in: Mathematical Software III (1977).
    """
    compiled = library()
    if compiled is None:
        return None
    result, (edges, count) = np.empty(triangles.shape, np.int64), room_of_edges(triangles)
    twins, outcome = np.empty(result.shape, np.int32), np.empty(1, np.int64)
    before = (0, edges, twins) if known is None else (len(known.edges), known.edges, known.twins)
    places = np.ascontiguousarray(start, np.float64), np.ascontiguousarray(x, np.float64)
    given = np.ascontiguousarray(triangles), *before, *places, len(facets), np.ascontiguousarray(facets), int(is_open)
    compiled.call("legalise_triangles", len(x), len(result), *given, result, twins, edges, count, outcome)
    if outcome[0] == UNCHANGED:
        return known
    return None if outcome[0] else Legal(result, shortened(edges, count), twins)


def room_of_edges(triangles: Integers) -> tuple[Integers, Integers]:
    """Room for the edges (3 t, 2) of triangles (t, 3), and for their number (1,)."""
    return np.empty((3 * len(triangles), 2), np.int64), np.empty(1, np.int64)


def shortened(edges: Integers, count: Integers) -> Integers:
    """The first ``count`` (1,) of the edges."""
    edges.resize((int(count[0]), 2), refcheck=False)  # in place: a copy would double what large meshes take
    return edges
