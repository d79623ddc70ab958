"""Joining: the packed rest of a domain and its layers as one net of the whole."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers, members
from bubblemesh.layers.heights import on_pieces, reached
from bubblemesh.layers.rest import Rest
from bubblemesh.layers.strips import Strips
from bubblemesh.meshes.edges import find_sides
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.net import Net, unconnected


class JoinedLayers(NamedTuple):
    """A net of the whole domain, with the cells of layers."""

    net: Net  # without a list of edges, nor spacings of its bubbles
    number: Integers  # (n,): of each node of the strips, -1 for those that are not there
    cells: Integers  # (t, 3): triangles of the layers
    pairs: Integers  # (t,): of columns that each of them is between
    halves: Integers  # (q, 2): rows of two of these that are one quadrilateral


def join_layers(rest: Rest, net: Net) -> JoinedLayers:
    """A net of the rest and the cells of the layers, as one of the whole domain."""
    strips = rest.strips
    whole = strips.walls.domain
    own = net.bubbles
    count = len(strips.x)
    fixed = len(whole.boundary.corners)
    inside = len(own) - own.boundary_count
    known = np.append(rest.corners, count + np.arange(len(own) - own.corners))
    edges, between = _nodes_on_fronts(rest, own)
    cells, pairs, halves = _divided(strips, edges, between)
    layer_piece, layer_s = _on_whole(strips)
    origin = rest.origin[own.piece]
    piece = np.concatenate([layer_piece, origin, np.full(inside, -1)])
    along = whole.boundary.wrapped(origin, rest.begin[own.piece] + rest.rate[own.piece] * own.s)
    s = np.concatenate([layer_s, along, np.zeros(inside)])
    x = np.vstack([strips.x, own.x[own.corners :]])
    # What was packed on the straight edges between nodes of a wall is on the wall's own curve.
    on_walls = count + np.flatnonzero((origin >= 0) & rest.straight[own.piece])
    x[on_walls] = whole.boundary.points(piece[on_walls], s[on_walls])
    used, corner = np.zeros(len(x), bool), np.arange(len(x)) < fixed
    used[known] = used[cells] = True
    used[:fixed] = True
    slides = used & (piece >= 0) & ~corner
    order = np.concatenate([np.flatnonzero(which) for which in (corner, slides, used & ~corner & ~slides)])
    number = np.full(len(x), -1)
    number[order] = np.arange(len(order))
    no_spacing = np.full(len(order), np.nan)  # of nodes that stay where they are
    bubbles = Bubbles(x[order], no_spacing, piece[slides], s[slides], fixed, np.zeros(len(order), bool))
    triangles = number[np.concatenate([cells, known[net.triangles]])]
    joint = replace(unconnected(bubbles, whole), triangles=triangles)
    return JoinedLayers(joint, number[:count], number[cells], pairs, halves)


def _on_whole(strips: Strips) -> tuple[Integers, Floats]:
    """Piece (n,) of the whole on which each node of the strips slides, -1 for none, and its arc length (n,) there."""
    walls = strips.walls
    columns = strips.columns
    count = strips.heights.count
    owner, rank = members(columns.own(count))
    piece, s = on_pieces(columns, walls, owner, reached(columns, strips.heights, owner, rank + 1))
    return np.append(walls.node_piece, piece), np.append(walls.node_s, s)


def _nodes_on_fronts(rest: Rest, own: Bubbles) -> tuple[Integers, list[Integers]]:
    """Edges (k, 2) of the strips on which bubbles of the rest lie, and the numbers of these after those of the strips.

    They are in the order from the first end to the second one.
    """
    boundary = rest.domain.boundary
    mine = np.flatnonzero(rest.straight[own.piece])
    mine = mine[np.lexsort((own.s[mine], own.piece[mine]))]
    pieces, first = np.unique(own.piece[mine], return_index=True)
    ends = rest.corners[np.column_stack([boundary.start[pieces], boundary.end[pieces]])]
    return ends, np.split(len(rest.strips.x) + mine, first[1:]) if len(mine) else []


def _divided(strips: Strips, edges: Integers, between: Sequence[Integers]) -> tuple[Integers, Integers, Integers]:
    """Triangles (t, 3) of the layers, with nodes ``between`` the ends of edges (k, 2) at their rim.

    The pairs (t,) of columns that they are between come second, the rows (q, 2) of two triangles that still are a
    quadrilateral last.
    """
    cells = strips.cells
    triangles = cells.triangles
    pair = cells.pair
    q = len(cells.diagonals)
    undivided = np.ones(q, bool)
    left = list(range(len(edges)))
    while left:
        owner, side = find_sides(triangles, int(triangles.max()) + 1, edges[left][:, ::-1])
        parts, later = dict[int, Integers](), list[int]()
        for k, cell, first in zip(left, owner.tolist(), side.tolist(), strict=True):
            quad = cell % q if 0 <= cell < 2 * q and undivided[cell % q] else -1
            rows = [cell] if quad < 0 else [quad, q + quad]
            if any(row in parts for row in rows):  # it has two such edges: its parts have one of them
                later.append(k)
            elif cell >= 0:
                chain = np.concatenate([edges[k, 1:], between[k][::-1], edges[k, :1]])
                turned = triangles[cell, (first + np.arange(3)) % 3]
                others = turned[2:] if quad < 0 else _across(triangles[rows], chain[[0, -1]])
                made = _fans(chain, others)
                parts |= {row: made[number : number + 1] for number, row in enumerate(rows[:-1])}
                parts[rows[-1]] = made[len(rows) - 1 :]
        for cell, some in parts.items():
            triangles[cell] = some[0]
            if cell < 2 * q:
                undivided[cell % q] = False
        triangles = np.concatenate([triangles, *(some[1:] for some in parts.values())])
        pair = np.concatenate([pair, *(np.full(len(some) - 1, pair[cell]) for cell, some in parts.items())])
        left = later
    halves = np.column_stack([np.arange(q), q + np.arange(q)])
    return triangles, pair, halves[undivided & strips.are_quads]


def _across(halves: Integers, edge: Integers) -> Integers:
    """The two corners of a quadrilateral, by its halves (2, 3), after an ``edge`` (2,) of it, counter-clockwise."""
    (a, b, c), (_, _, d) = halves.tolist()
    ring = [a, b, c, d]
    begin = ring.index(edge[1])
    return np.array([ring[(begin + 1) % 4], ring[(begin + 2) % 4]])


def _fans(chain: Integers, others: Integers) -> Integers:
    """Triangles between a chain (k,) of nodes and one or two others, which follow the chain counter-clockwise.

    Of two others each has the nearer half of the chain.
    """
    steps = np.column_stack([chain[:-1], chain[1:]])
    if len(others) == 1:
        return np.column_stack([steps, np.full(len(steps), others[0])])
    middle = len(chain) // 2
    apex = np.where(np.arange(len(steps)) < middle, others[1], others[0])
    return np.vstack([np.column_stack([steps, apex]), [[chain[middle], *others]]])
