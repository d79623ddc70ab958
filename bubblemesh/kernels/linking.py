"""Triangles and their edges in an order of their own, and flips of edges that make them Delaunay."""

from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, ShortIntegers, each_once
from bubblemesh.kernels.library import call, or_none, or_numpy
from bubblemesh.kernels.predicates import in_circle, turns

UNCHANGED = 2  # outcome of the kernel
MOST_PASSES = 100  # each of many flips


class Legal(NamedTuple):
    """A constrained Delaunay triangulation, in the order of `in_order`."""

    triangles: Integers  # (t, 3)
    edges: Integers  # (m, 2)
    # (t, 3): for the side from each node to the next, the number, in these three columns, of the same side of the
    # triangle across; -1 on the rim and on facets
    twins: ShortIntegers


def in_order_in_numpy(triangles: Integers, n: int) -> tuple[Integers, Integers]:
    """The same as `in_order`, in NumPy."""
    first = triangles.argmin(axis=1)
    a, b, c = (np.take_along_axis(triangles, (first[:, None] + k) % 3, axis=1)[:, 0] for k in range(3))
    order = np.argsort(a * n + b, kind="stable")
    sides = np.concatenate([np.minimum(p, q) * n + np.maximum(p, q) for p, q in ((a, b), (b, c), (c, a))])
    return np.column_stack([a, b, c])[order], np.stack(np.divmod(each_once(sides), n), axis=1)


@or_numpy(in_order_in_numpy)
def in_order(triangles: Integers, n: int) -> tuple[Integers, Integers]:
    """Triangles (t, 3) of ``n`` nodes and their edges (m, 2), each once, in an order of their own.

    Triangles begin with their lowest node and keep their turn, edges have the lower node first; both ascend.
    """
    result, (edges, count) = np.empty(triangles.shape, np.int64), room_of_edges(triangles)
    call(
        "order_triangles",
        n=n,
        t=len(result),
        triangles=np.ascontiguousarray(triangles),
        ordered=result,
        edges=edges,
        count=count,
    )
    return result, shortened(edges, count)


@or_none
def legalised(
    triangles: Integers, start: Floats, x: Floats, facets: Integers, known: Legal | None = None, is_open: bool = False
) -> Legal | None:
    """The constrained Delaunay triangulation of nodes x (n, 2), by flips from triangles (t, 3) between these nodes.

    Where nodes would invert triangles, they go to x step by step from ``start`` (n, 2), with flips on the way. Where
    four nodes lie on a circle, as far as rounding can show, the edge between them is the one with the lowest node.

    Parameters
    ----------
    facets
        Edges (b, 2) that stay; the triangles stay on their side of those at the rim. Each is a side of a triangle.
    known
        What an earlier call has returned for these triangles and facets, which saves work.
    is_open
        Whether the rim has edges that are not facets.

    Returns
    -------
    Legal or None
        Triangles and edges in the order of `in_order`; ``known`` if no edge was flipped. None, so that the caller has
        to triangulate anew, if a triangle might be flat or stays inverted, if facets are not as said above, or
        without compiled kernels.

    References
    ----------
    C. L. Lawson, "Software for C1 surface interpolation", in: Mathematical Software III (1977).
    """
    result, (edges, count) = np.empty(triangles.shape, np.int64), room_of_edges(triangles)
    twins, outcome = np.empty(result.shape, np.int32), np.empty(1, np.int64)
    call(
        "legalise_triangles",
        n=len(x),
        t=len(result),
        triangles=np.ascontiguousarray(triangles),
        known_m=0 if known is None else len(known.edges),
        known_edges=edges if known is None else known.edges,
        known_twins=twins if known is None else known.twins,
        start=np.ascontiguousarray(start, np.float64),
        x=np.ascontiguousarray(x, np.float64),
        m=len(facets),
        facets=np.ascontiguousarray(facets),
        open=int(is_open),
        ordered=result,
        twins=twins,
        edges=edges,
        count=count,
        outcome=outcome,
    )
    if outcome[0] == UNCHANGED:
        return known
    return None if outcome[0] else Legal(result, shortened(edges, count), twins)


def without_ties_in_numpy(triangles: Integers, x: Floats, facets: Integers) -> tuple[Integers, Integers]:
    """The same as `without_ties`, in NumPy."""
    return in_order_in_numpy(_without_ties(triangles, x, facets), len(x))


@or_numpy(without_ties_in_numpy)
def without_ties(triangles: Integers, x: Floats, facets: Integers) -> tuple[Integers, Integers]:
    """Triangles (t, 3) and edges (m, 2), in the order of `in_order`, of a Delaunay triangulation without ties.

    The given triangles are a constrained Delaunay triangulation of nodes x (n, 2). Where four nodes lie on a circle, as
    far as rounding can show, either edge between them is right: they get the one with the lowest node, as `legalised`
    gives it. The facets (b, 2) stay, and so do triangles that might be flat.
    """
    found = legalised(triangles, x, x, facets)
    return in_order(triangles, len(x)) if found is None else (found.triangles, found.edges)


def _without_ties(triangles: Integers, x: Floats, facets: Integers) -> Integers:
    """Triangles (t, 3) of `without_ties`, in NumPy and in no order."""
    result, n, t = triangles.copy(), len(x), len(triangles)
    held = np.sort(_undirected(facets[:, 0], facets[:, 1], n))
    if not _turn_left(x, *result.T).all():
        return triangles
    for _ in range(MOST_PASSES):
        # 1. Edges, other than facets, to flip: their new edge is Delaunay, or there is a tie and it has the lowest
        # node.
        keys = _sides(result, n)
        order = np.argsort(keys, kind="stable")
        keys = keys[order]
        twice = keys[1:] == keys[:-1]
        at = np.searchsorted(keys, held)
        if (keys[np.minimum(at, len(keys) - 1)] != held).any():  # a facet that is divided by a node
            return triangles
        twice[at[at < len(twice)]] = False
        twice = np.flatnonzero(twice)
        side, across = order[twice], order[twice + 1]
        (one, k), (two, k2) = (np.divmod(rows, 3) for rows in (side, across))
        a, b, c = (result[one, (k + turn) % 3] for turn in range(3))
        d = result[two, (k2 + 2) % 3]
        inside = in_circle(*(x[node] for node in (*result[one].T, d)))
        tied = (inside == 0) & (np.minimum(c, d) < np.minimum(a, b))
        if (tied & ~(_turn_left(x, a, d, c) & _turn_left(x, d, b, c))).any():
            return triangles
        chosen = np.flatnonzero((inside > 0) | tied)
        if len(chosen) == 0:
            return result
        # 2. Of these, flip those that share no triangle with an earlier one.
        pairs, rank, first = np.column_stack([one, two])[chosen], np.arange(len(chosen)), np.full(t, len(chosen))
        np.minimum.at(first, pairs, rank[:, None])
        alone = (first[pairs] == rank[:, None]).all(axis=1)
        (one, two), (a, b, c, d) = pairs[alone].T, (node[chosen[alone]] for node in (a, b, c, d))
        result[one], result[two] = np.column_stack([a, d, c]), np.column_stack([d, b, c])
    return triangles


def _sides(triangles: Integers, n: int) -> Integers:
    """Keys (3 t,) of the sides of triangles (t, 3), the same for both directions of a side; triangle after triangle."""
    return _undirected(triangles, np.roll(triangles, -1, axis=1), n).ravel()


def _undirected(a: Integers, b: Integers, n: int) -> Integers:
    return np.minimum(a, b) * n + np.maximum(a, b)


def _turn_left(x: Floats, a: Integers, b: Integers, c: Integers) -> Booleans:
    return np.asarray(turns(x[a], x[b], x[c]) > 0)


def room_of_edges(triangles: Integers) -> tuple[Integers, Integers]:
    """Room for the edges (3 t, 2) of triangles (t, 3), and for their number (1,)."""
    return np.empty((3 * len(triangles), 2), np.int64), np.empty(1, np.int64)


def shortened(edges: Integers, count: Integers) -> Integers:
    """The first ``count`` (1,) of the edges."""
    edges.resize((int(count[0]), 2), refcheck=False)  # in place: a copy would double what large meshes take
    return edges
