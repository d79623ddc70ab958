"""Fronts: straight edges between layers and the rest of a domain."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, concatenated, select
from bubblemesh.layers.heights import on_pieces, reached
from bubblemesh.layers.strips import Strips
from bubblemesh.layers.walls import Walls
from bubblemesh.meshes.edges import edge_keys, find_keys


class Edges(NamedTuple):
    """Straight edges between nodes of strips, beside which the rest of the domain is."""

    ends: Integers  # (k, 2): it is on their left
    region: Integers  # (k,): there
    piece: Integers  # (k,): piece of the whole that they run along, -1 above walls
    s: Floats  # (k, 2): arc lengths of their ends there
    is_flat: (
        Booleans  # (k,): whether the cell on their right is a triangle that closes a step, and too flat to be halved
    )

    @classmethod
    def of(cls, strips: Strips) -> "Edges":
        """All edges between layers and the rest: fronts, other sides of walls, and columns with layers on one side."""
        return concatenated([_fronts(strips), _other_sides(strips.walls), *_behind_columns(strips)])

    def once(self) -> tuple["Edges", Integers]:
        """The edges, those of both directions once, and the regions (k,) on their right, -1 where the rest is not."""
        proper = select(self, self.ends[:, 0] != self.ends[:, 1])
        n = int(proper.ends.max(initial=0)) + 1
        keys = edge_keys(proper.ends, n)
        order = np.argsort(keys)
        back = find_keys(keys[order], edge_keys(proper.ends[:, ::-1], n))
        right = np.where(back < 0, -1, proper.region[order[back]])
        kept = (back < 0) | (proper.ends[:, 0] < proper.ends[:, 1])
        return select(proper, kept), right[kept]


def _fronts(strips: Strips) -> Edges:
    """Tops of strips, which run along the wall where there are no layers."""
    walls, columns = strips.walls, strips.columns
    side = columns.side
    on_wall = (strips.heights.count[columns.pair] == 0).all(axis=1)
    piece = np.where(on_wall, walls.piece[side], -1)
    return Edges(strips.fronts, walls.region[side], piece, walls.arcs[side], strips.flat_steps)


def _other_sides(walls: Walls) -> Edges:
    """Sides without layers of walls that have some on the other side."""
    sides = np.flatnonzero(~walls.layered & walls.pieces_with_layers[walls.piece])
    is_flat = np.zeros(len(sides), bool)
    return Edges(walls.ends[sides], walls.region[sides], walls.piece[sides], walls.arcs[sides], is_flat)


def _behind_columns(strips: Strips) -> Iterator[Edges]:
    """Edges of columns that follow a piece within the domain, if there are no layers on its other side."""
    columns, whole = strips.columns, strips.walls.domain.boundary
    in_pairs = np.zeros((2, len(columns)), bool)
    for last in range(2):
        in_pairs[last, columns.pair[:, last]] = True
    for column in np.flatnonzero(columns.follows >= 0).tolist():
        piece = int(columns.follows[column])
        level = np.arange(strips.heights.count[column] + 1)
        owner = np.full(len(level), column)
        nodes = strips.node(owner, level)
        s = on_pieces(columns, strips.walls, owner, reached(columns, strips.heights, owner, level))[1]
        up, s_up = np.column_stack([nodes[:-1], nodes[1:]]), np.column_stack([s[:-1], s[1:]])
        # A column goes up on the left of the strip behind it.
        on_left, on_right = columns.from_start[column] == np.array([True, False])
        sides = (up, s_up, 1, on_left), (up[::-1, ::-1], s_up[::-1, ::-1], 0, on_right)
        for ends, arcs, last, forth in sides:
            if whole.inner[piece] and not in_pairs[last, column]:
                region = whole.left[piece] if forth else whole.right[piece]
                region_of, piece_of = np.full(len(ends), region), np.full(len(ends), piece)
                yield Edges(ends, region_of, piece_of, arcs, np.zeros(len(ends), bool))
