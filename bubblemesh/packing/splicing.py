"""Splicing: a few nodes leave a triangulation, others come to middles of its edges, and all else stays as it is."""

from typing import NamedTuple, Self

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, contained, cross, members
from bubblemesh.meshes.edges import edge_keys, find_keys

STRAIGHT_RIM = 1e-9  # of the square of a side: what area a node on a straight rim may be off by


def spliced(x: Floats, triangles: Integers, gone: Booleans, halved: Integers) -> Integers | None:
    """Triangles (t, 3) without the nodes that are ``gone``, and with new ones in the middles of ``halved`` edges.

    As the triangles (s, 3) of nodes x (n, 2) they turn left, but they need not be Delaunay: flips may go on from them.
    No two of the nodes gone (n,) have an edge, no two of the edges halved (k, 2) have a node in common, and none of
    them has one that is gone. Nodes are numbered anew: those that stay, then the new ones in the order of the edges.
    None if one of the edges is on the rim, a node is where the rim is not straight, or one leaves a hole that no corner
    of it sees the whole of.
    """
    if gone.any():
        left, done = removed(x, triangles, gone)
        number = np.cumsum(~gone) - 1
        return with_middles(number[left], number[halved], int(number[-1]) + 1) if done[gone].all() else None
    return with_middles(triangles, halved, len(x))


class Holes(NamedTuple):
    """The holes that nodes would leave: their triangles (node, a, b), whose sides (a, b) enclose them."""

    row: Integers  # (m,): of these triangles
    node: Integers  # (m,): ascending
    a: Integers  # (m,)
    b: Integers  # (m,)
    nodes: Integers  # (k,): each of the nodes once
    start: Integers  # (k,): place of its first triangle
    sides: Integers  # (k,): how many it has

    @classmethod
    def of(cls, triangles: Integers, chosen: Booleans) -> Self:
        """Holes of the nodes chosen (n,) of the triangles (t, 3)."""
        row, place = np.divmod(np.flatnonzero(chosen[triangles]), 3)
        order = np.argsort(triangles[row, place], kind="stable")
        row, place = row[order], place[order]
        node, a, b = (triangles[row, (place + k) % 3] for k in range(3))
        return cls(row, node, a, b, *np.unique(node, return_index=True, return_counts=True))

    def rims(self, n: int) -> tuple[Integers, Integers]:
        """Triangles (r,) with which holes on the rim begin, and with which they end, of nodes below ``n``."""
        begins, ends = (edge_keys(np.column_stack([self.node, end]), n) for end in (self.a, self.b))
        begin, end = find_keys(np.sort(ends), begins) < 0, find_keys(np.sort(begins), ends) < 0
        return np.flatnonzero(begin), np.flatnonzero(end)

    def fans(self) -> tuple[Integers, Integers, Booleans]:
        """For each corner of a hole all of its sides, in order: corner, side (p,), and whether it is no end of that."""
        corner, rank = members(np.repeat(self.sides, self.sides))
        side = np.repeat(self.start, self.sides)[corner] + rank
        return corner, side, (self.a[side] != self.a[corner]) & (self.b[side] != self.a[corner])


def removed(x: Floats, triangles: Integers, gone: Booleans) -> tuple[Integers, Booleans]:
    """Triangles (u, 3) after nodes have moved onto a neighbour, which makes two of their own vanish; which did (n,).

    Of the nodes gone (n,), no two of which have an edge, those stay with which one of the others would turn right in
    any case. The neighbour is the one that makes the least area of the others largest. On the rim it is the next one
    along that, one triangle vanishes, and nodes stay where the rim is not straight.
    """
    if not gone.any():
        return triangles, gone
    holes = Holes.of(triangles, gone)
    row, node, a, b, nodes, start, _ = holes
    # From each corner of a hole, the least area of triangles to the sides that it is no end of.
    corner, side, apart = holes.fans()
    u, v = x[a[side]] - x[a[corner]], x[b[side]] - x[a[corner]]
    area = np.where(apart, cross(u, v), np.inf)
    least = np.minimum.reduceat(area, np.searchsorted(corner, np.arange(len(node))))
    begin, end = holes.rims(len(x))
    if len(begin):
        least = np.where(_may_take_on_rims(x, holes, begin, end), least, -np.inf)
    # The node moves onto the corner where that is largest.
    best = np.lexsort([-least, node])[start]
    possible = least[best] > 0
    onto, done = np.arange(len(x)), np.zeros(len(x), bool)
    onto[nodes[possible]], done[nodes[possible]] = a[best[possible]], True
    flat = done[node] & ((a == onto[node]) | (b == onto[node]))
    return np.delete(onto[triangles], row[flat], axis=0), done


def _may_take_on_rims(x: Floats, holes: Holes, begin: Integers, end: Integers) -> Booleans:
    """Whether corners (m,) of holes may take the node: on the rim those do with which a straight one begins."""
    node = holes.node[begin]  # of each end, too
    may = ~contained(holes.node, node)
    u, v = x[holes.a[begin]] - x[node], x[holes.b[end]] - x[node]
    area, side = cross(u, v), v - u
    twice = np.append(node[1:] == node[:-1], False) | np.append(False, node[1:] == node[:-1])  # two rims meet there
    may[begin] = ~twice & (np.abs(area) <= STRAIGHT_RIM * np.einsum("ij,ij->i", side, side))
    return may


def with_middles(triangles: Integers, halved: Integers, n: int) -> Integers | None:
    """Triangles (t, 3) after the two at each of the halved edges (k, 2) have become four; None for an edge of one.

    The new nodes are numbered from ``n`` on.
    """
    if len(halved) == 0:
        return triangles
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
