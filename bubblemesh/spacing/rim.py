"""The rim of a triangle mesh, and its nearest place."""

from dataclasses import dataclass

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.geometry.chord_runs import ChordRuns
from bubblemesh.geometry.nearest_chord import nearest_chord

__all__ = ["Rim"]


@dataclass(frozen=True)
class Rim:
    """Edges with triangles on one side only, also where the triangles beside each other have nodes of their own.

    Attributes
    ----------
    nodes : (k, 2)
        Nodes of the edges, in closed loops.
    runs : ChordRuns
        The edges as chords.
    """

    nodes: Integers
    runs: ChordRuns

    @classmethod
    def of(cls, points: Floats, triangles: Integers) -> "Rim":
        """Rim of triangles (t, 3) that turn either way and have an area."""
        _, places = np.unique(points, axis=0, return_inverse=True)
        a, b, c = np.moveaxis(points[triangles], 1, 0)
        clockwise = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) < (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
        turned = np.where(clockwise[:, None], triangles[:, ::-1], triangles)
        edges = turned[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
        edges = edges[_one_sided(places[edges], len(points))]
        nodes = edges[_along_loops(*places[edges].T)]
        return cls(nodes, ChordRuns.of(points[nodes[:, 0]], points[nodes[:, 1]]))

    def nearest(self, points: Floats) -> tuple[Integers, Floats]:
        """Nodes (m, 2) of the edges nearest to points (m, 2), and the shares (m,) of the ways along them."""
        edge = nearest_chord(self.runs, points)
        return self.nodes[edge], self.runs.feet(points, edge)[0]


def _one_sided(edges: Integers, count: int) -> Integers:
    """Rows (k,) of directed edges (m, 2) that are left when each cancels one in the other direction.

    As many of them begin as end at each of the ``count`` nodes, even where triangles overlap.
    """
    keys, first, number = np.unique(edges[:, 0] * count + edges[:, 1], return_index=True, return_counts=True)
    reverse = keys % count * count + keys // count
    at = np.minimum(np.searchsorted(keys, reverse), len(keys) - 1)
    against = np.where(keys[at] == reverse, number[at], 0)
    return np.repeat(first, np.maximum(number - against, 0))


def _along_loops(start: Integers, end: Integers) -> Integers:
    """Edges (k,) in the order of loops."""
    following = np.empty_like(start)
    following[np.argsort(end, kind="stable")] = np.argsort(start, kind="stable")
    follow, seen = following.tolist(), [False] * len(start)
    order: list[int] = []
    for edge in range(len(follow)):
        while not seen[edge]:
            seen[edge] = True
            order.append(edge)
            edge = follow[edge]
    return np.array(order)
