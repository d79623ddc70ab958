"""Walls: edges of the boundary by the sides that face the domain, in the order in which they go around it."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, side_by_side, turned_left
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.curves import turning
from bubblemesh.geometry.domain import Domain
from bubblemesh.layers.ladder import Ladder
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing

# Of fillets: in sharper corners the first node of the column in the middle would be too near to the chord.
LARGEST_TURN = np.radians(100)


@record
class Walls:
    """Sides of boundary edges that face the domain, which is on their left.

    An edge inside the domain has two sides, of opposite directions.
    """

    domain: Domain
    x: Floats  # (n, 2): nodes on the boundary, corners first
    d: Floats  # (n,): spacing there, square to the sides
    node_piece: Integers  # (n,): piece of the boundary, -1 for a corner
    node_s: Floats  # (n,): arc length on it
    ends: Integers  # (m, 2): nodes at which sides begin and end
    piece: Integers  # (m,): piece that they follow
    forward: Booleans  # (m,): whether they run as their piece does
    arcs: Floats  # (m, 2): arc lengths there at which they begin and end, past its length across a closed one's start
    region: Integers  # (m,): number of the region that they face
    ladder: Integers  # (m,): number of the layers that they have, -1 for none
    following: Integers  # (m,): side that comes next around the area
    middles: Floats  # (m, 2): points halfway along the curves that they follow
    angle: Floats  # (m,): in the domain, between a side and the following one, up to 2 pi

    @classmethod
    def of(cls, domain: Domain, shell: Bubbles, spacing: Spacing, ladders: Sequence[Ladder]) -> "Walls":
        """Walls of a domain with nodes as the bubbles of its boundary, and the ``spacing`` there."""
        boundary = domain.boundary
        facets, piece = boundary.edges(shell.piece, shell.s)
        both = np.flatnonzero(boundary.inner[piece])
        arcs = np.column_stack(boundary.arcs(facets, piece, shell.s))
        middles = boundary.points(piece, boundary.wrapped(piece, arcs.mean(axis=1)))
        ends = np.concatenate([facets, facets[both, ::-1]])
        forward = np.arange(len(ends)) < len(facets)
        piece = np.append(piece, piece[both])
        following, angle = _following(shell.x, facets, both)
        region = np.where(forward, boundary.left[piece], boundary.right[piece])
        names = np.array(domain.parts.names, object)[domain.parts.name_indices[region]]
        label = np.array(boundary.labels, object)[boundary.label[piece]]
        ladder = np.full(len(ends), -1)
        for number, layers in enumerate(ladders):
            mine = np.isin(label, layers.labels)
            ladder[mine & ((names == layers.region) | (layers.region is None))] = number
        corners = shell.corners
        node_piece, node_s = np.full(corners, -1), np.zeros(corners)
        return cls(
            domain,
            shell.x,
            _square_to(facets, shell.x, spacing),
            np.append(node_piece, shell.piece),
            np.append(node_s, shell.s),
            ends,
            piece,
            forward,
            np.concatenate([arcs, arcs[both, ::-1]]),
            region,
            ladder,
            following,
            np.concatenate([middles, middles[both]]),
            angle,
        )

    @property
    def layered(self) -> Booleans:
        """Mask (m,) of the sides with layers."""
        return self.ladder >= 0

    @property
    def pieces_with_layers(self) -> Booleans:
        """Mask (p,) of the pieces of the boundary with layers on one side at least."""
        found = np.zeros(len(self.domain.boundary.kind), bool)
        found[self.piece[self.layered]] = True
        return found

    @cached_property
    def fillet_radii(self) -> Floats:
        """Radii (p,) of the pieces of the boundary that are fillets; infinite for all others."""
        return fillet_radii(self.domain.boundary)

    @property
    def directions(self) -> Floats:
        """Unit vectors (m, 2) along the sides."""
        along = self.x[self.ends[:, 1]] - self.x[self.ends[:, 0]]
        return along / np.hypot(*along.T)[:, None]


def fillet_radii(boundary: Boundary) -> Floats:
    """Mean radii (p,) of the pieces of a boundary that are curves and turn as fillets do; infinite for all others."""
    curved = np.flatnonzero(boundary.approximated & ~boundary.closed)
    length, radii = boundary.lengths[curved], np.full(len(boundary.lengths), np.inf)
    if len(curved) == 0:
        return radii
    turn = np.abs(turning(boundary.tangents(curved, np.zeros(len(curved))), boundary.tangents(curved, length)))
    fillet = (turn > 0) & (turn <= LARGEST_TURN)
    radii[curved[fillet]] = length[fillet] / turn[fillet]
    return radii


def rotated(directions: Floats, angle: Floats) -> Floats:
    """Vectors (m, 2), or one (1, 2), turned counter-clockwise by angles (m,)."""
    (x, y), c, s = directions.T, np.cos(angle), np.sin(angle)
    return side_by_side(c * x - s * y, s * x + c * y)


def _square_to(facets: Integers, x: Floats, spacing: Spacing) -> Floats:
    """Spacing (n,) at nodes x (n, 2) square to the facets (f, 2) there; infinite where there is none.

    Of several facets at a node the least one counts.
    """
    square, d = turned_left(x[facets[:, 1]] - x[facets[:, 0]]), np.full(len(x), np.inf)
    for end in facets.T:
        np.minimum.at(d, end, spacing.towards(x[end], square))
    return d


def _following(x: Floats, facets: Integers, both: Integers) -> tuple[Integers, Floats]:
    """The next side around the area after each, and the angle (m,) in between.

    Sides are all facets (f, 2), then those of two sides the other way.
    """
    ends = np.concatenate([facets, facets[:, ::-1]])  # each facet as seen from either end
    along = x[ends[:, 1]] - x[ends[:, 0]]
    direction = np.arctan2(along[:, 1], along[:, 0])
    order = np.lexsort((direction, ends[:, 0]))
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    node = ends[order, 0]
    begins = np.flatnonzero(np.diff(node, prepend=-1))
    last = np.append(begins[1:], len(node)) - 1
    # The one before each, counter-clockwise around its node.
    before = np.arange(len(order)) - 1
    before[begins] = last
    count = len(facets)
    side = np.append(np.arange(count), np.full(count, -1))
    side[count + both] = count + np.arange(len(both))
    sides = np.append(np.arange(count), count + both)
    back = (sides + count) % (2 * count)  # the same facet as seen from the end
    next_one = order[before[rank[back]]]
    angle = np.mod(direction[back] - direction[next_one], 2 * np.pi)
    return side[next_one], np.where(next_one == back, 2 * np.pi, angle)
