"""Edges of triangles: directed sides, edges without repetition, and the triangles across.

A pair of nodes i, j < n has the key i n + j: one integer for each pair sorts many times faster than rows do.
"""

import numpy as np

from bubblemesh.arrays import Integers, each_once, taken
from bubblemesh.records import record


def edge_keys(pairs: Integers, n: int) -> Integers:
    """Keys (m,) of directed pairs (m, 2) of nodes below ``n``; of longer rows the first two columns are used."""
    return _keys(pairs[:, 0], pairs[:, 1], n)


def _keys(i: Integers, j: Integers, n: int) -> Integers:
    return i.astype(np.int64, copy=False) * n + j


def find_keys(keys: Integers, sought: Integers) -> Integers:
    """Indices (m,) of the sought keys (m,) among ascending keys (k,), at least one; -1 for a key that is missing."""
    place = np.minimum(np.searchsorted(keys, sought), len(keys) - 1)
    return np.where(keys[place] == sought, place, -1)


def directed_sides(triangles: Integers) -> Integers:
    """Sides (3 t, 2) of triangles (t, 3): all from corner 0 to 1, then all from 1 to 2, then all from 2 to 0."""
    return triangles.T[[[0, 1, 2], [1, 2, 0]]].reshape(2, -1).T


@record(eq=False)
class SideTable:
    """Table of the directed sides of triangles, which finds them by their nodes."""

    sides: Integers  # (3 t, 2) in the order of `directed_sides`
    n: int  # number of nodes
    keys: Integers  # (3 t,) of the sides, ascending
    order: Integers  # (3 t,) row in the sides of each key

    @classmethod
    def of(cls, triangles: Integers, n: int) -> "SideTable":
        """Table of the sides of triangles (t, 3) with nodes below ``n``."""
        sides = directed_sides(triangles)
        keys = edge_keys(sides, n)
        order = np.argsort(keys)
        return cls(sides, n, keys[order], order)

    def find(self, pairs: Integers) -> Integers:
        """Rows (m,) of the sides from the first to the second node of pairs (m, 2); -1 if there is no such side."""
        place = find_keys(self.keys, edge_keys(pairs, self.n))
        return np.where(place < 0, -1, self.order[place])

    def opposite(self) -> Integers:
        """Row (3 t,) of the side of the same edge in the triangle across; -1 if there is no such triangle."""
        return self.find(self.sides[:, ::-1])

    def owner(self, rows: Integers) -> tuple[Integers, Integers]:
        """Triangles (m,) of the sides in some rows (m,), and the numbers (m,) of the sides there: 0, 1 or 2."""
        number, triangle = np.divmod(rows, len(self.sides) // 3)
        return triangle, number


def find_sides(triangles: Integers, n: int, pairs: Integers) -> tuple[Integers, Integers]:
    """Triangles with a side from the first to the second node of pairs (m, 2); faster than a `SideTable` for few pairs.

    The triangles are (t, 3), with nodes below ``n``.

    Returns
    -------
    tuple
        Triangle (m,) of each side, and its number (m,) there: 0, 1 or 2. Both are -1 for a pair that is not a side.
    """
    sought, which = np.unique(edge_keys(pairs, n), return_inverse=True)
    found = np.full((2, len(sought)), -1)
    for number in range(3 if len(sought) else 0):
        place = find_keys(sought, _keys(triangles[:, number], triangles[:, (number + 1) % 3], n))
        triangle = np.flatnonzero(place >= 0)
        found[0, place[triangle]], found[1, place[triangle]] = triangle, number
    triangle, side = found[:, which.ravel()]
    return triangle, side


def unique_edges(triangles: Integers) -> tuple[Integers, Integers]:
    """Edges (e, 2) of triangles (t, 3), nodes i < j in lexicographic order, and the number (e,) of triangles at each.

    The number is 1 on the boundary, 2 inside, and more where the mesh is not a surface.
    """
    keys, n = _undirected_keys(triangles)
    keys.sort()
    first = np.flatnonzero(np.append(True, keys[1:] != keys[:-1])[: len(keys)])
    return np.stack(np.divmod(keys[first], n), axis=1), np.diff(first, append=len(keys))


def numbered_edges(triangles: Integers) -> tuple[Integers, Integers]:
    """Edges (e, 2) as in `unique_edges`, and the numbers (t, 3) of the edges 0-1, 1-2, 2-0 of each triangle."""
    keys, n = _undirected_keys(triangles)
    order = np.argsort(keys, kind="stable")  # a merge sort, fast for the ascending runs in keys of sorted triangles
    ascending, number = keys[order], np.empty_like(order)
    fresh = np.append(True, ascending[1:] != ascending[:-1])[: len(keys)]
    number[order] = np.cumsum(fresh) - 1
    return np.stack(np.divmod(ascending[fresh], n), axis=1), number.reshape(3, -1).T


def neighbour_pairs(triangles: Integers) -> Integers:
    """Pairs (m, 2) of triangles that share an edge, for the nodes (t, 3) of triangles of either orientation.

    Of more than two triangles at an edge, as where a mesh overlaps itself, each is paired with the next one.
    """
    keys, _ = _undirected_keys(triangles)
    order = np.argsort(keys, kind="stable")
    same = np.flatnonzero(keys[order[1:]] == keys[order[:-1]])
    return np.column_stack([order[same], order[same + 1]]) % len(triangles)


def _undirected_keys(triangles: Integers) -> tuple[Integers, int]:
    """Keys (3 t,) of the sides with the lower node first, and the number of nodes."""
    n = int(triangles.max(initial=0)) + 1
    columns = [(triangles[:, k], triangles[:, (k + 1) % 3]) for k in range(3)]
    return np.concatenate([_keys(np.minimum(i, j), np.maximum(i, j), n) for i, j in columns]), n


def rim_nodes(triangles: Integers) -> Integers:
    """Nodes (b,) on edges of one triangle only, ascending."""
    edges, counts = unique_edges(triangles)
    return each_once(edges[counts == 1].ravel())


def one_sided(sides: Integers, n: int) -> Integers:
    """Rows (k,) of directed sides (m, 2) that remain when opposite sides cancel in pairs, ordered by keys.

    At each of the ``n`` nodes as many of them begin as end, even where triangles overlap.
    """
    rows = _not_in_pairs(sides, n)
    keys, first, number = np.unique(edge_keys(taken(sides, rows), n), return_index=True, return_counts=True)
    if len(keys) == 0:
        return rows
    reverse = find_keys(keys, keys % n * n + keys // n)
    against = np.where(reverse < 0, 0, number[reverse])
    return rows[np.repeat(first, np.maximum(number - against, 0))]


def _not_in_pairs(sides: Integers, n: int) -> Integers:
    """Rows (k,) of directed sides (m, 2), without edges that have just one side in each direction: most of a mesh."""
    i, j = sides.T
    keys = 2 * _keys(np.minimum(i, j), np.maximum(i, j), n) + (i > j)
    ordered = np.sort(keys)
    same = np.concatenate([[False], ordered[1:] >> 1 == ordered[:-1] >> 1, [False]])  # edge as the one before
    alone = ~same[:-1] & same[1:] & ~np.append(same[2:], False) & (np.append(ordered[1:], -1) != ordered)
    left = ordered[~(alone | np.append(False, alone)[:-1])]
    return np.flatnonzero(find_keys(left, keys) >= 0) if len(left) else np.zeros(0, np.int64)
