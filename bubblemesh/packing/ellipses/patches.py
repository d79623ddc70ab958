"""Patches: small parts of a net around some of its triangles, where bubbles change while the others stay."""

from typing import NamedTuple, Self

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, all_of_rows
from bubblemesh.kernels.patches import least_around
from bubblemesh.packing.net import Net
from bubblemesh.packing.splicing import removed, with_middles

LOOKS = 6  # for room between the patches that are there already


class PatchNet(NamedTuple):
    """Bubbles and triangles of patches, no two of which have an edge in between; bubbles are numbered anew."""

    nodes: Integers  # (n,): numbers of the bubbles in the net, -1 for new ones
    x: Floats  # (n, 2)
    tensors: Floats  # (n, 3): of the metric at each, but at those that have moved since
    free: Booleans  # (n,): bubbles that may move
    patch: Integers  # (n,): the patch that each is in
    triangles: Integers  # (t, 3)
    facets: Integers  # (f, 2): edges that stay

    @property
    def owner(self) -> Integers:
        """The patch (t,) that each triangle is in."""
        return self.patch[self.triangles[:, 0]]

    def changed(self, gone: Booleans, halved: Integers) -> Self:
        """The patches without the bubbles gone (n,), and with new ones in the middles of edges halved (k, 2).

        In each patch one bubble leaves, or one inner edge is halved, at most.
        """
        n, k = len(self.x), len(halved)
        triangles, done = removed(self.x, self.triangles, gone)
        split = with_middles(triangles, halved, n)
        if split is None:
            raise ValueError("an edge on the rim is halved")
        return self._replace(
            nodes=np.append(self.nodes, np.full(k, -1)),
            x=np.concatenate([self.x, self.x[halved].mean(axis=1)]),
            tensors=np.concatenate([self.tensors, self.tensors[halved].mean(axis=1)]),
            free=np.append(self.free & ~done, np.ones(k, bool)),
            patch=np.append(self.patch, self.patch[halved[:, 0]]),
            triangles=split,
        )

    def select(self, chosen: Booleans) -> Self:
        """The chosen ones of all patches, which keep their numbers."""
        kept = chosen[self.patch]
        number = np.cumsum(kept) - 1
        return type(self)(
            nodes=self.nodes[kept],
            x=self.x[kept],
            tensors=self.tensors[kept],
            free=self.free[kept],
            patch=self.patch[kept],
            triangles=number[self.triangles[chosen[self.owner]]],
            facets=number[self.facets[all_of_rows(kept[self.facets])]],
        )


def patches_around(
    candidates: Integers, rings: int, net: Net, x: Floats, tensors: Floats, triangles: Integers, edges: Integers
) -> tuple[Integers, Booleans, PatchNet]:
    """Patches of triangles (t, 3) and edges (m, 2) with the boundary of a net, around candidates (c,).

    Their bubbles are at x (n, 2), with tensors (n, 3). Around a triangle there are so many ``rings`` of them, of which
    the outermost one stays.

    Returns
    -------
    chosen
        The triangles (k,) that patches are around, by their rows: of two candidates that are too near to each other
        the one that comes first.
    within
        Mask (t,) of the triangles that are in patches, where they have the same order.
    patches
        The patches.
    """
    n, none = len(x), len(candidates)
    chosen, left, patch = candidates[:0], candidates, np.full(n, none)
    for _ in range(LOOKS):
        # 1. Those are chosen that come before all others near to them.
        rank, first = np.arange(len(left)), np.full(n, none)
        np.minimum.at(first, triangles[left], rank[:, None])
        near = least_around(edges, first, 2 * rings + 1)
        chosen = np.append(chosen, left[all_of_rows(near[triangles[left]] == rank[:, None])])
        # 2. What is near to those is left no longer.
        patch[triangles[chosen]] = np.arange(len(chosen))[:, None]
        apart = least_around(edges, patch, 2 * rings + 1) == none
        left = left[all_of_rows(apart[triangles[left]])]
        if len(left) == 0:
            break
    inner = least_around(edges, patch, rings - 1)
    patch = least_around(edges, inner, 1)
    within, known = all_of_rows(patch[triangles] < none), np.zeros(n, bool)
    known[triangles[within]] = True
    nodes, number = np.flatnonzero(known), np.cumsum(known) - 1
    facets = net.facets[all_of_rows(known[net.facets])]
    free = (inner[nodes] < none) & (nodes >= net.bubbles.boundary_count)
    found = nodes, x[nodes], tensors[nodes], free, patch[nodes], number[triangles[within]], number[facets]
    return chosen, within, PatchNet(*found)
