"""Seams: strips of a net along cuts are packed once more, with the bubbles of the cuts free, and put back."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, any_of_rows, components, each_once
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.curves import Lines
from bubblemesh.geometry.domain import Domain, Held
from bubblemesh.geometry.faces import face
from bubblemesh.kernels.linking import legalised
from bubblemesh.meshes.edges import directed_sides, find_sides, one_sided
from bubblemesh.meshes.triangulation import linked
from bubblemesh.packing.ellipses.smoothing import with_better_shapes
from bubblemesh.packing.net import Net
from bubblemesh.packing.rounds import Record
from bubblemesh.parts.work import Terms, packed_from
from bubblemesh.records import record
from bubblemesh.spacing.metric.metric import MetricSpacing
from bubblemesh.spacing.spacing import Spacing

SEAM = 6  # edges from a cut to the bubbles that stay
JUNCTION = 10  # the same from where a cut ends, which is packed once more after the rest of the seams
TOGETHER = 5000  # triangles, about: smaller strips are packed as one, which takes less than one by one


class Strip(NamedTuple):
    """A part of a net that is packed once more, as a domain with straight sides whose corners are bubbles that stay.

    It may be several strips that are apart from each other.
    """

    node: Integers  # (n,): numbers of its bubbles in the net, ascending
    free: Booleans  # (n,): those of them that are within; the others are corners
    x: Floats  # (n, 2)
    triangles: Integers  # (t, 3): by numbers in the net
    lines: Integers  # (l, 2): likewise, sides of the domain within the strip, and facets between others that stay

    @property
    def rim(self) -> Integers:
        """Numbers (r,) in the net of the bubbles that are its corners."""
        return self.node[~self.free]

    @property
    def inside(self) -> Integers:
        """Numbers (k,) in the net of the other bubbles."""
        return self.node[self.free]

    def domain(self) -> Domain:
        """The strip as a domain."""
        sides = directed_sides(self.triangles)
        outer = sides[np.sort(one_sided(sides, int(self.node[-1]) + 1))]
        ends = np.searchsorted(self.rim, np.concatenate([outer, self.lines]))
        return _polygon(self.x[~self.free], ends, len(outer))


class PackedStrip(NamedTuple):
    """A strip that was packed once more."""

    x: Floats  # (n, 2): bubbles, those of its rim first
    triangles: Integers  # (t, 3)
    record: Record


def packed_again(strip: Strip, terms: Terms) -> PackedStrip:
    """Pack a strip from where its bubbles are: first come those of its rim, in their order."""
    done = packed_from(strip.domain(), strip.x[strip.free], terms)
    return PackedStrip(done.net.bubbles.x, done.net.triangles, Record.in_turn(done.rounds))


def near(net: Net, bubbles: Integers, rings: int) -> Booleans:
    """Bubbles (n,) at most so many triangles away from the given ones."""
    marked = np.zeros(len(net.bubbles), bool)
    marked[bubbles] = True
    for _ in range(rings):
        marked[net.triangles[any_of_rows(marked[net.triangles])]] = True
    return marked


@record
class SeamStrips:
    """Strips of a net, apart from each other, that are made when they are asked for."""

    net: Net
    free: Booleans  # (n,): bubbles that may move
    triangles: tuple[Integers, ...]  # of each strip, by their numbers in the net
    lines: tuple[Integers, ...]  # (l, 2) of each: sides of the domain within it, and facets between others that stay

    @classmethod
    def of(cls, net: Net, free: Booleans) -> "SeamStrips":
        """Strips in which the bubbles that are ``free`` (n,) may move, but for those on the boundary."""
        n = len(net.bubbles)
        free = free & (np.arange(n) >= net.bubbles.boundary_count)
        sides = directed_sides(net.triangles[any_of_rows(free[net.triangles])])
        rank, group = np.cumsum(free) - 1, np.full(n, -1)
        group[free] = components(rank[sides[free[sides].all(axis=1)]], int(free.sum()))
        # The free bubbles of a triangle are joined by its sides, so that each triangle is in one strip at the most.
        of_triangle = group[net.triangles].max(axis=1)
        mine = np.flatnonzero(of_triangle >= 0)
        of_triangle[mine] = _together(np.bincount(of_triangle[mine]))[of_triangle[mine]]
        mine = mine[np.argsort(of_triangle[mine], kind="stable")]
        parts = np.split(mine, np.flatnonzero(np.diff(of_triangle[mine])) + 1) if len(mine) else []
        forth, back = (np.append(of_triangle, -1)[found] for found in _beside_facets(net))
        within = np.where(forth == back, forth, -1)
        return cls(net, free, tuple(parts), tuple(net.facets[within == of_triangle[part[0]]] for part in parts))

    @property
    def sizes(self) -> list[int]:
        """Number of the triangles of each."""
        return [len(part) for part in self.triangles]

    def __len__(self) -> int:
        return len(self.triangles)

    def __getitem__(self, number: int) -> Strip:
        triangles = self.net.triangles[self.triangles[number]]
        node = each_once(triangles.ravel())
        return Strip(node, self.free[node], self.net.bubbles.x[node], triangles, self.lines[number])

    def put_back(self, done: Sequence[tuple[Strip, PackedStrip]], spacing: Spacing) -> tuple[Net, Integers]:
        """The net with all strips packed again, and the new numbers (n,) of its bubbles, -1 for those within.

        Like the net given, it has no list of edges.
        """
        net, gone = self.net, np.zeros(len(self.net.bubbles), bool)
        left = np.ones(len(net.triangles), bool)
        for (strip, _), rows in zip(done, self.triangles, strict=True):
            gone[strip.inside], left[rows] = True, False
        number = np.where(gone, -1, np.cumsum(~gone) - 1)
        rest, count = net.bubbles.select(np.flatnonzero(~gone)), len(gone) - int(gone.sum())
        places, triangles = list[Floats](), [number[net.triangles[left]]]
        for strip, part in done:
            inside = part.x[len(strip.rim) :]
            triangles.append(np.append(number[strip.rim], count + np.arange(len(inside)))[part.triangles])
            places.append(inside)
            count += len(inside)
        x = np.vstack([np.zeros((0, 2)), *places])
        grown = rest.append(x, spacing.extended(x))
        return replace(net, bubbles=grown, facets=number[net.facets], triangles=np.concatenate(triangles)), number


def _together(sizes: Integers) -> Integers:
    """Number (k,) of the group of each of some strips, by the numbers of their triangles (k,).

    Large strips are alone; groups of others have about as many triangles as `TOGETHER` says, if there are so many.
    """
    large = sizes >= TOGETHER
    count = int(large.sum()) + round(sizes[~large].sum() / TOGETHER)
    group, found = np.zeros(len(sizes), np.int64), [0] * max(count, 1)
    for strip in np.argsort(-sizes, kind="stable").tolist():
        group[strip] = smallest = found.index(min(found))
        found[smallest] += int(sizes[strip])
    return group


def _polygon(corners: Floats, ends: Integers, outer: int) -> Domain:
    """The domain with straight sides between corners (k, 2): first ``outer`` ones of the rim, then lines within."""
    count, start, end = len(ends), *ends.T
    zeros, on_rim = np.zeros(count, np.int64), np.arange(count) < outer
    lines = Lines(corners[start], corners[end])
    boundary = Boundary(
        families=(lines,),
        kind=zeros,
        index=np.arange(count),
        offset=np.zeros(count),
        lengths=lines.lengths,
        start=start,
        end=end,
        label=zeros,
        ring=zeros - 1,
        left=zeros,
        right=np.where(on_rim, -1, 0),
        named=np.zeros(count, bool),
        turned=np.zeros(count, bool),
        corners=corners,
        labels=("rim",),
    )
    traced, _ = face(boundary, on_rim)
    return Domain(traced, held=Held(np.arange(count)))


def settled(net: Net, spacing: Spacing) -> Net:
    """The net with its edges flipped until they are Delaunay, but for facets and the rim of its triangles.

    In a metric they are flipped for better shapes, as at the end of a packing.
    """
    if len(net.triangles) == 0:  # cuts run between areas only
        return net
    if isinstance(spacing, MetricSpacing):
        return with_better_shapes(net, spacing)
    known = np.zeros(len(net.bubbles), bool)
    known[net.triangles] = True
    used, number = np.flatnonzero(known), np.cumsum(known) - 1
    x, triangles = net.bubbles.x[used], number[net.triangles]
    forth, back = _beside_facets(net)
    lines = number[net.facets[(forth >= 0) & (back >= 0)]]
    # What is at the rim has no triangle to flip with.
    if (found := legalised(triangles, x, x, lines, is_open=True)) is not None:
        return replace(net, triangles=used[found.triangles])
    sides = directed_sides(triangles)
    rim = sides[np.sort(one_sided(sides, len(used)))]
    legal, _ = linked(x, np.concatenate([rim, lines]), np.arange(len(rim) + len(lines)) >= len(rim))
    return replace(net, triangles=used[legal])


def _beside_facets(net: Net) -> tuple[Integers, Integers]:
    """Triangles (b,) on the left and on the right of each facet, -1 where there is none."""
    left, right = (find_sides(net.triangles, len(net.bubbles), ends)[0] for ends in (net.facets, net.facets[:, ::-1]))
    return left, right
