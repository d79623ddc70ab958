"""The rest of a domain beside its layers, as a domain of its own."""

from dataclasses import replace
from functools import cached_property

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, complement
from bubblemesh.geometry.arrangement.regions import InnerParts
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.curves import Lines
from bubblemesh.geometry.domain import Domain, Held
from bubblemesh.geometry.faces import compact, face
from bubblemesh.layers.fronts import Edges
from bubblemesh.layers.heights import on_pieces, reached
from bubblemesh.layers.strips import Strips
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing

LONGEST_UNDIVIDED = 2.0  # spacings: longer fronts of flat triangles are divided
FRONT = "front"  # label of what the layers leave, which no mesh has


@record
class Rest:
    """The rest of a domain beside its layers; its boundary there is straight between their nodes, and may get more."""

    strips: Strips
    domain: Domain
    corners: Integers  # (c,): numbers that its corners have in the strips
    origin: Integers  # (p,): piece of the whole that each piece is a part of or runs along, -1 for fronts above walls
    begin: Floats  # (p,): arc length of the whole's piece at which it begins
    rate: Floats  # (p,): change of that arc length along the piece
    straight: Booleans  # (p,): pieces along layers
    is_flat: Booleans  # (p,): of these, the fronts of triangles that close steps and are too flat to be halved

    @classmethod
    def of(cls, strips: Strips) -> "Rest":
        """The rest of the domain beside strips."""
        walls, whole = strips.walls, strips.walls.domain.boundary
        bare = np.flatnonzero(~walls.pieces_with_layers)
        begin, end, first, last = _beside_columns(strips)
        beside, right = Edges.of(strips).once()
        straight = Lines(strips.x[beside.ends[:, 0]], strips.x[beside.ends[:, 1]])
        count = len(bare)
        edges = len(right)
        rim = np.append(~whole.inner[bare], right < 0)
        boundary = Boundary(
            families=(*whole.families, straight),
            kind=np.append(whole.kind[bare], np.full(edges, len(whole.families))),
            index=np.append(whole.index[bare], np.arange(edges)),
            offset=np.append(whole.offset[bare] + begin[bare], np.zeros(edges)),
            lengths=np.append((end - begin)[bare], straight.lengths),
            start=np.append(first[bare], beside.ends[:, 0]),
            end=np.append(last[bare], beside.ends[:, 1]),
            label=np.append(whole.label[bare], np.full(edges, len(whole.labels))),
            ring=np.append(whole.ring[bare], np.full(edges, -1)),
            left=np.append(whole.left[bare], beside.region),
            right=np.append(whole.right[bare], right),
            named=np.append(whole.named[bare], np.zeros(edges, bool)),
            turned=np.append(whole.turned[bare], np.zeros(edges, bool)),
            corners=strips.x,
            labels=(*whole.labels, FRONT),
        )
        traced, order = face(boundary, rim)
        points = complement(len(whole.corners), np.append(whole.start, whole.end))
        small, corners = compact(traced, points)
        matching = tuple(pair for pair in walls.domain.parts.periodic if {*pair} <= {*small.labels})
        alone = whole.corners[points]
        embedded = tuple(point for point in walls.domain.parts.points if (alone == point.at).all(axis=1).any())
        # What matches a side of the whole gets no node that its counterpart would not have.
        held = np.append(np.zeros(count, bool), np.isin(beside.piece, walls.domain.periodic))
        domain = Domain(
            small, parts=InnerParts(points=embedded, periodic=matching), held=Held(np.flatnonzero(held[order]))
        )
        rate = np.append(np.ones(count), np.diff(beside.s, axis=1)[:, 0] / straight.lengths)
        origin, first_s = np.append(bare, beside.piece), np.append(begin[bare], beside.s[:, 0])
        is_flat = np.append(np.zeros(count, bool), beside.is_flat)
        return cls(strips, domain, corners, origin[order], first_s[order], rate[order], order >= count, is_flat[order])

    def held_at_steps(self, spacing: Spacing) -> "Rest":
        """The rest with fronts that get no node where triangles that close steps would be halved into flat ones.

        These have angles near 180 degrees. Where a front is much longer than the spacing at one of its ends, what is
        packed beside it would be worse.
        """
        boundary, flat = self.domain.boundary, np.flatnonzero(self.is_flat)
        ends = [spacing.along(boundary, flat, s) for s in (np.zeros(len(flat)), boundary.lengths[flat])]
        short = flat[boundary.lengths[flat] <= LONGEST_UNDIVIDED * np.minimum(*ends)]
        return replace(self, domain=replace(self.domain, held=Held(np.union1d(self.domain.held.pieces, short))))

    @cached_property
    def own_nodes(self) -> int:
        """Number of the nodes of the layers that are not on their fronts."""
        own = np.zeros(len(self.strips.x), bool)
        own[self.strips.cells.triangles] = True
        own[self.corners] = False
        return int(own.sum())


def _beside_columns(strips: Strips) -> tuple[Floats, Floats, Integers, Integers]:
    """Arc lengths (p,) between which pieces of the whole have no column along them, and the nodes (p,) there."""
    columns, whole = strips.columns, strips.walls.domain.boundary
    begin, end = np.zeros(len(whole.kind)), whole.lengths.copy()
    first, last = whole.start.copy(), whole.end.copy()
    for at_start in (True, False):
        mine = np.flatnonzero((columns.follows >= 0) & (columns.from_start == at_start))
        piece, s = on_pieces(
            columns, strips.walls, mine, reached(columns, strips.heights, mine, strips.heights.count[mine])
        )
        (begin if at_start else end)[piece] = s
        (first if at_start else last)[piece] = strips.top[mine]
    return begin, end, first, last
