"""The partition of a mesh for a parallel solver: owners of triangles and nodes, halos, and what the parts share."""

from functools import cached_property
from typing import Any, NamedTuple, Self

import numpy as np

from bubblemesh.arrays import Floats, Integers, components, each_once, is_whole, members
from bubblemesh.errors import CaseError
from bubblemesh.meshes.division import divided
from bubblemesh.meshes.edges import neighbour_pairs
from bubblemesh.messages import counted
from bubblemesh.records import record

NO_PAIRS = np.zeros((0, 2), np.int64)


class NodeParts(NamedTuple):
    """Pairs (m,) of a node and a part with triangles at it, in lexicographic order, and the number of these triangles.

    Rows ``starts[i]`` to ``starts[i + 1]`` are those of node i.
    """

    node: Integers
    part: Integers
    triangles: Integers
    starts: Integers


@record(eq=False)
class Partition:
    """Triangles divided among the processes of a parallel solver, which are numbered from 0.

    Attributes
    ----------
    triangles : (t, 3) or (t, 6)
        Nodes of the triangles.
    owner : (t,)
        Part of each triangle.
    count : int
        Number of parts; each has a triangle.
    by : str
        How they were divided: by ``METIS`` or ``geometry``.
    reason : str or None
        Why METIS was not used; None if it was.
    """

    triangles: Integers
    owner: Integers
    count: int
    by: str
    reason: str | None = None

    @classmethod
    def of(cls, points: Floats, triangles: Integers, count: int, quads: Integers = NO_PAIRS) -> Self:
        """Partition of triangles (t, 3) or (t, 6) with nodes at points (n, 2) into ``count`` parts.

        Both triangles of a pair in ``quads`` (q, 2) are in one part. CaseError if there are fewer cells than parts;
        such a pair is one cell.
        """
        if not is_whole(count):
            raise CaseError(f"the number of parts must be a whole one (found {count!r})")
        own = np.arange(len(triangles))
        other = own.copy()
        other[quads] = quads[:, ::-1]
        first = np.minimum(own, other)
        kept = first == own  # one triangle of each cell
        cell = (np.cumsum(kept) - 1)[first]
        cells = int(kept.sum())
        if not 1 <= count <= cells:
            what = counted(cells, "cell" if len(quads) else "triangle")
            raise CaseError(f"a mesh of {what} has from 1 to {cells:,} parts, not {count:,}")
        corners = triangles[:, :3]
        centroids = points[corners].mean(axis=1)
        pairs = cell[neighbour_pairs(corners)]
        pairs = pairs[pairs[:, 0] != pairs[:, 1]]
        division = divided(((centroids + centroids[other]) / 2)[kept], pairs, np.bincount(cell), count)
        return cls(triangles, division.owner[cell], count, division.by, division.reason)

    @cached_property
    def sizes(self) -> Integers:
        """Number (p,) of triangles of each part."""
        return np.bincount(self.owner, minlength=self.count)

    @cached_property
    def node_parts(self) -> NodeParts:
        """Parts that have triangles at each node."""
        keys = self.triangles * self.count + self.owner[:, None]
        keys, triangles = np.unique(keys, return_counts=True)
        node, part = np.divmod(keys, self.count)
        return NodeParts(node, part, triangles, np.searchsorted(node, np.arange(node[-1] + 2)))

    @cached_property
    def node_owner(self) -> Integers:
        """Part (n,) of each node: the one with most of its triangles; of several such parts, the lowest."""
        node, part, triangles, starts = self.node_parts
        order = np.lexsort([part, -triangles, node])
        return part[order[starts[:-1]]]

    @cached_property
    def ghosts(self) -> Integers:
        """Pairs (g, 2) of a part and a triangle of its halo, in lexicographic order.

        The halo of a part are the triangles of other parts that share a node with it.
        """
        _, part, _, starts = self.node_parts
        corners, t = self.triangles[:, :3].ravel(), len(self.triangles)
        at_border = np.flatnonzero(np.diff(starts)[corners] > 1)
        node, triangle = corners[at_border], at_border // 3
        group, rank = members(np.diff(starts)[node])
        halo, triangle = part[starts[node[group]] + rank], triangle[group]
        others = halo != self.owner[triangle]
        return np.column_stack(np.divmod(each_once(halo[others] * t + triangle[others]), t))

    @cached_property
    def interfaces(self) -> Integers:
        """Rows (s, 3) of two parts, the lower first, and a node that they share, in lexicographic order."""
        node, part, _, starts = self.node_parts
        first, rank = members(starts[node + 1] - np.arange(len(node)) - 1)
        rows = np.column_stack([part[first], part[first + 1 + rank], node[first]])
        return rows[np.lexsort(rows.T[::-1])]

    @cached_property
    def cut(self) -> int:
        """Number of edges between triangles of different parts."""
        return int((np.diff(self.owner[neighbour_pairs(self.triangles[:, :3])], axis=1) != 0).sum())

    def halo(self, part: int) -> Integers:
        """Triangles (g,) of the halo of a part, ascending; CaseError if there is no such part."""
        if not isinstance(part, int | np.integer) or not 0 <= part < self.count:
            raise CaseError(f"halo: must be a part, from 0 to {self.count - 1} (found {part!r})")
        begin, end = np.searchsorted(self.ghosts[:, 0], [part, part + 1])
        return self.ghosts[begin:end, 1]

    def with_nodes(self, triangles: Integers) -> "Partition":
        """The partition for the same triangles with other nodes, such as those of second order."""
        return Partition(triangles, self.owner, self.count, self.by, self.reason)

    def figures(self) -> dict[str, Any]:
        """Sizes of the parts, of their borders and of their halos, as plain data of the report."""
        halos = np.bincount(self.ghosts[:, 0], minlength=self.count)
        pairs = neighbour_pairs(self.triangles[:, :3])
        pieces = components(pairs[np.diff(self.owner[pairs], axis=1)[:, 0] == 0], len(self.owner))
        pieces_of = np.bincount(self.owner[np.unique(pieces, return_index=True)[1]], minlength=self.count)
        return {
            "parts": self.count,
            "by": self.by,
            "triangles": {"min": int(self.sizes.min()), "max": int(self.sizes.max())},
            "imbalance": float(self.sizes.max() * self.count / len(self.owner) - 1),
            "edge_cut": self.cut,
            "shared_nodes": int((np.diff(self.node_parts.starts) > 1).sum()),
            "halo": {"min": int(halos.min()), "max": int(halos.max()), "total": len(self.ghosts)},
            "in_several_pieces": int((pieces_of > 1).sum()),
        }
