"""Splicing: a few nodes leave a triangulation, others come to middles of its edges, and all else stays as it is."""

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, members
from bubblemesh.meshes.edges import edge_keys


def spliced(x: Floats, triangles: Integers, gone: Booleans, halved: Integers) -> Integers | None:
    """Triangles (t, 3) without the nodes that are ``gone``, and with new ones in the middles of ``halved`` edges.

    As the triangles (s, 3) of nodes x (n, 2) they turn left, but they need not be Delaunay: flips may go on from them.
    No two of the nodes gone (n,) have an edge, no two of the edges halved (k, 2) have a node in common, and none of
    them has one that is gone. Nodes are numbered anew: those that stay, then the new ones in the order of the edges.
    None if one of these nodes or edges is on the rim, or a node leaves a hole that no corner of it sees the whole of.
    """
    if gone.any():
        left, number = _without(x, triangles, gone), np.cumsum(~gone) - 1
        return None if left is None else _with_middles(number[left], number[halved], int(number[-1]) + 1)
    return _with_middles(triangles, halved, len(x)) if len(halved) else triangles


def _without(x: Floats, triangles: Integers, gone: Booleans) -> Integers | None:
    """Triangles (t, 3) after each node that is gone has moved onto a neighbour, which makes two of its own vanish.

    It is the neighbour that makes the least area of the others largest. None if with each of them one turns right.
    """
    # 1. The triangles (node, a, b) around each node: their sides (a, b) enclose the hole that it leaves.
    row, place = np.divmod(np.flatnonzero(gone[triangles]), 3)
    order = np.argsort(triangles[row, place], kind="stable")
    row, place = row[order], place[order]
    node, a, b = (triangles[row, (place + k) % 3] for k in range(3))
    begins, ends = (edge_keys(np.column_stack([node, end]), len(x)) for end in (a, b))
    if not np.array_equal(np.sort(begins), np.sort(ends)):  # on the rim the sides enclose nothing
        return None
    # 2. From each corner of the hole, the least area of triangles to the sides that it is no end of.
    nodes, start, count = np.unique(node, return_index=True, return_counts=True)
    corner, rank = members(np.repeat(count, count))
    side = np.repeat(start, count)[corner] + rank
    u, v = x[a[side]] - x[a[corner]], x[b[side]] - x[a[corner]]
    apart = (a[side] != a[corner]) & (b[side] != a[corner])
    area = np.where(apart, u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0], np.inf)
    least = np.minimum.reduceat(area, np.flatnonzero(rank == 0))
    # 3. The node moves onto the corner where that is largest.
    best = np.lexsort([-least, node])[start]
    if not (least[best] > 0).all():
        return None
    onto = np.arange(len(x))
    onto[nodes] = a[best]
    flat = (a == onto[node]) | (b == onto[node])
    return np.delete(onto[triangles], row[flat], axis=0)


def _with_middles(triangles: Integers, halved: Integers, n: int) -> Integers | None:
    """Triangles (t, 3) after the two at each of the halved edges (k, 2) have become four; None for an edge of one.

    The new nodes are numbered from ``n`` on.
    """
    across, middle = np.full(n, -1), np.full(n, -1)
    across[halved] = halved[:, ::-1]
    middle[halved] = n + np.arange(len(halved))[:, None]
    row, place = np.divmod(np.flatnonzero(across[triangles] == triangles[:, [1, 2, 0]]), 3)
    if len(row) != 2 * len(halved):
        return None
    new = middle[triangles[row, place]]
    behind, ahead = triangles.copy(), triangles[row]
    behind[row, (place + 1) % 3] = new
    ahead[np.arange(len(row)), place] = new
    return np.concatenate([behind, ahead])
