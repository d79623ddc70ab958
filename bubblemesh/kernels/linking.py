"""Triangles and their edges in an order of their own, and flips of edges that make them Delaunay."""

from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers, ShortIntegers, each_once
from bubblemesh.kernels.library import Library, library

NO_PLACES, NO_FACETS = np.zeros((0, 2)), np.zeros((0, 2), np.int64)


class Legal(NamedTuple):
    """A constrained Delaunay triangulation, in the order of `in_order`."""

    triangles: Integers  # (t, 3)
    edges: Integers  # (m, 2)
    quads: ShortIntegers  # (k, 4): two triangles with an edge that is no facet: its ends, and their other nodes


def in_order(triangles: Integers, n: int) -> tuple[Integers, Integers]:
    """Triangles (t, 3) of ``n`` nodes and their edges (m, 2), each once, in an order of their own.

    Triangles begin with their lowest node and keep their turn, edges have the lower node first; both ascend.
    """
    compiled = library()
    if compiled is None:
        return in_order_in_numpy(triangles, n)
    found = _linked(compiled, triangles, n, 0, NO_PLACES, NO_PLACES, NO_FACETS)
    assert found is not None  # only flips may be undecided
    return found.triangles, found.edges


def in_order_in_numpy(triangles: Integers, n: int) -> tuple[Integers, Integers]:
    """Triangles (t, 3) and edges (m, 2) as of `in_order`, made in NumPy."""
    first = triangles.argmin(axis=1)
    a, b, c = (np.take_along_axis(triangles, (first[:, None] + k) % 3, axis=1)[:, 0] for k in range(3))
    order = np.argsort(a * n + b, kind="stable")
    sides = np.concatenate([np.minimum(p, q) * n + np.maximum(p, q) for p, q in ((a, b), (b, c), (c, a))])
    return np.column_stack([a, b, c])[order], np.stack(np.divmod(each_once(sides), n), axis=1)


def legalised(triangles: Integers, start: Floats, x: Floats, facets: Integers) -> Legal | None:
    """The constrained Delaunay triangulation of nodes x (n, 2), by flips from triangles (t, 3) between these nodes.

    The facets (b, 2) stay, and the triangles lie on the same side of those at the rim. Where nodes would invert
    triangles they go to x step by step from ``start`` (n, 2), with flips on the way. Triangles and edges come as from
    `in_order`; None where rounding would decide, a triangle stays inverted, or no kernels are compiled: triangulate
    anew.

    References
    ----------
    C. L. Lawson, "Software for C1 surface interpolation", in: Mathematical Software III (1977).
    """
    compiled = library()
    return None if compiled is None else _linked(compiled, triangles, len(x), 1, start, x, facets)


def is_legal(known: Legal, x: Floats) -> bool:
    """Whether a triangulation is the constrained Delaunay one for sure, also with its nodes at x (n, 2)."""
    compiled, outcome = library(), np.empty(1, np.int64)
    assert compiled is not None  # nothing else makes one
    rows = len(known.triangles), known.triangles, len(known.quads), known.quads
    compiled.call("check_quads", *rows, np.ascontiguousarray(x, np.float64), outcome)
    return not outcome[0]


def _linked(
    compiled: Library, triangles: Integers, n: int, flips: int, start: Floats, x: Floats, facets: Integers
) -> Legal | None:
    """Triangles and edges in order, and quads, after flips if these are wanted; None where they are undecided."""
    result, edges = np.array(triangles, order="C"), np.empty((3 * len(triangles), 2), np.int64)
    quads = np.empty((3 * len(triangles) // 2, 4), np.int32)  # they are kept for long, and are many
    counts, outcome = np.zeros(2, np.int64), np.zeros(1, np.int64)
    places = np.ascontiguousarray(start, np.float64), np.ascontiguousarray(x, np.float64)
    given = flips, *places, len(facets), np.ascontiguousarray(facets)
    compiled.call("link_triangles", n, len(result), result, *given, edges, quads, counts, outcome)
    if outcome[0]:
        return None
    edges.resize((int(counts[0]), 2), refcheck=False)  # in place: a copy would double what large meshes take
    quads.resize((int(counts[1]), 4), refcheck=False)
    return Legal(result, edges, quads)
