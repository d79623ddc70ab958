"""Population control: which bubbles go, and where new ones come.

The published scheme goes by thresholds of the bubbles' overlap, the other by the defects of the triangulation.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Annotated, Literal, NamedTuple, Protocol

import numpy as np
from annotated_types import Ge, Gt, Le
from typing_extensions import Doc

from bubblemesh.arrays import Booleans, Floats, Integers, all_of_rows, any_of_rows, taken
from bubblemesh.geometry.domain import Domain
from bubblemesh.kernels.pairs import pairs_within
from bubblemesh.kernels.relaxing import CUTOFF
from bubblemesh.meshes.quality import edge_ratios
from bubblemesh.meshes.triangulation import circumcircles, sorted_triangles
from bubblemesh.packing.boundary_edges import split_cutting_edges
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.neighbours import Neighbours, maximal_independent_set, next_to
from bubblemesh.packing.net import Net, connect
from bubblemesh.packing.splicing import spliced
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing

REACH_OF_OVERLAP = 2.0  # 2 r_i + r_j is the farthest: below two l0 for any two radii
FEWEST_NEIGHBOURS = 4
MANY_NEIGHBOURS = 8
FEWEST_ON_A_WALL = 3  # of a bubble on a straight wall, that is two triangles with right angles
CLOSE_ON_A_WALL = 0.92  # spacings
STRAIGHT_WALL = 0.1  # radians that a wall turns by at a bubble
SHARP_CORNER = 0.6  # radians that a boundary turns by at a corner that counts: at others bubbles would come and go
WIDEST_CORNER = np.cos(np.radians(80.0))  # two triangles of 45 degrees are better than one with a right angle
NEAREST_TO_CORNER = 0.6  # spacings that a new bubble keeps
TOO_NEAR_CORNER = 0.5  # spacings within which one goes; less, so that none comes and goes in turns


class Change(NamedTuple):
    """Bubbles after population control, which marks those it touched."""

    bubbles: Bubbles
    deleted: int
    inserted: int
    triangles: Integers | None = None  # (t, 3): counter-clockwise, for `connect` to go on from, if they are known


class Population(Protocol):
    """A scheme of population control."""

    def __call__(self, net: Net, domain: Domain, spacing: Spacing, random: np.random.Generator) -> Change:
        """Control the whole population once."""


@record
class Thresholds:
    """Deletion and insertion by thresholds of the overlap ratio.

    The paper gives no thresholds of deletion; these lead to its final numbers of bubbles.
    """

    delete_above: Annotated[float, Gt(0), Doc("overlap ratio above which an interior bubble goes; 6 is perfect")] = 7.8
    delete_above_boundary: Annotated[float, Gt(0), Doc("the same along the boundary; 2 is perfect")] = 3.5
    delete_apart: Annotated[float, Gt(0), Doc("least distance between deletions of one round, in spacings")] = 1.2
    delete_order: Annotated[
        Literal["placed", "random", "worst"],
        Doc("which of two crowded ones goes: the `worst` by overlap ratio, a `random` one, or the one `placed` first"),
    ] = "placed"
    insert_below: Annotated[float, Gt(0), Doc("overlap ratio below which a bubble may get a new neighbour")] = 4.5
    insert_apart: Annotated[float, Ge(0.5), Le(2), Doc("least distance of a new bubble from others, in spacings")] = (
        0.85
    )

    def __call__(self, net: Net, domain: Domain, spacing: Spacing, random: np.random.Generator) -> Change:
        bubbles = net.bubbles
        near = Neighbours.of(bubbles.x, bubbles.d, REACH_OF_OVERLAP)
        alpha = overlaps(near)
        crowded = alpha > self.delete_above
        crowded[bubbles.sliding] = boundary_overlaps(bubbles, domain) > self.delete_above_boundary
        crowded[: bubbles.corners] = False
        close = taken(near.pairs, near.distances < self.delete_apart * near.contact)
        gone = maximal_independent_set(crowded, close, self.rank(alpha, random))
        acting = taken(near.pairs, near.distances < CUTOFF * near.contact)
        rest = replace(bubbles, touched=next_to(acting, gone)).select(np.flatnonzero(~gone))
        grown = self._filled(split_cutting_edges(rest, domain, spacing), domain, spacing)
        return Change(grown, deleted=len(bubbles) - len(rest), inserted=len(grown) - len(rest))

    def rank(self, alpha: Floats, random: np.random.Generator) -> Integers:
        """Position (n,) of each bubble in the order of deletion."""
        if self.delete_order == "random":
            return random.permutation(len(alpha))
        rank = np.arange(len(alpha))
        if self.delete_order == "worst":
            rank[np.argsort(-alpha, kind="stable")] = np.arange(len(alpha))
        return rank

    def _filled(self, bubbles: Bubbles, domain: Domain, spacing: Spacing) -> Bubbles:
        """The bubbles and more in the gaps between them."""
        alpha = overlaps(Neighbours.of(bubbles.x, bubbles.d, REACH_OF_OVERLAP))
        net = connect(bubbles, domain)
        room, piece, s = boundary_gaps(bubbles, domain, net.facets, net.facet_piece, self.insert_apart)
        triangles = sorted_triangles(net.triangles)
        loose = triangles[any_of_rows(alpha[triangles] < self.insert_below)]
        hollow, center = interior_gaps(bubbles, domain, spacing, loose, self.insert_apart)
        x = np.vstack([domain.boundary.points(piece, s), center])
        d = spacing(x)
        come = maximal_independent_set(np.ones(len(x), bool), pairs_within(x, d, self.insert_apart), np.arange(len(x)))
        on_boundary, inside = come[: len(room)], come[len(room) :]
        touched = bubbles.touched.copy()
        touched[room[on_boundary]] = True
        touched[hollow[inside]] = True
        grown = replace(bubbles, touched=touched)
        return grown.append(x[come], d[come], piece[on_boundary], s[on_boundary])


def overlaps(near: Neighbours) -> Floats:
    """Overlap ratios (n,): alpha_i = sum over neighbours of max(0, 2 r_i + r_j - l) / r_i; 6 in a perfect packing."""
    i, j = near.pairs.T
    r, distance = near.d / 2, near.distances
    on_i = np.maximum(0, 2 * r[i] + r[j] - distance) / r[i]
    on_j = np.maximum(0, 2 * r[j] + r[i] - distance) / r[j]
    return np.bincount(np.append(i, j), np.append(on_i, on_j), len(r)).astype(float)


def boundary_overlaps(bubbles: Bubbles, domain: Domain) -> Floats:
    """Overlap ratios (b,) of the sliding bubbles with the two bubbles on either side of them; 2 if all are in place."""
    edges, _ = domain.boundary.edges(bubbles.piece, bubbles.s)
    ahead, behind = (np.full(bubbles.boundary_count, -1) for _ in range(2))
    ahead[edges[:, 0]], behind[edges[:, 1]] = edges[:, 1], edges[:, 0]
    me = np.arange(bubbles.corners, bubbles.boundary_count)
    x, r = bubbles.x, bubbles.d / 2
    alpha = np.zeros(len(me))
    for step in (ahead, behind):
        first = step[me]
        second = np.where(first >= bubbles.corners, step[first], -1)  # not past a corner
        for other in (first, second):
            overlap = 2 * r[me] + r[other] - np.hypot(*(taken(x, me) - taken(x, other)).T)
            alpha += np.where((other >= 0) & (other != me), np.maximum(0, overlap) / r[me], 0)
    return alpha


def boundary_gaps(
    bubbles: Bubbles, domain: Domain, edges: Integers, edge_piece: Integers, apart: float
) -> tuple[Integers, Integers, Floats]:
    """Boundary edges (k, 2) with room for one more bubble, and the pieces and arc lengths (k,) of their midpoints."""
    begin, end = domain.boundary.arcs(edges, edge_piece, bubbles.s)
    gap = np.flatnonzero(end - begin > 2 * apart * bubbles.d[edges].mean(axis=1))
    piece = edge_piece[gap]
    return edges[gap], piece, domain.boundary.wrapped(piece, (begin[gap] + end[gap]) / 2)


def interior_gaps(
    bubbles: Bubbles, domain: Domain, spacing: Spacing, triangles: Integers, apart: float
) -> tuple[Integers, Floats]:
    """Triangles (k, 3) whose empty circumcircle has room for one more bubble, and the circles' centres (k, 2)."""
    center, radius = circumcircles(bubbles.x, triangles)
    inside = np.flatnonzero(np.isfinite(radius))
    inside = inside[domain.contains(center[inside])]
    d = spacing(center[inside])
    wide = radius[inside] > apart * d
    inside, d = inside[wide], d[wide]
    gap = inside[domain.surely_inside(center[inside], apart / 2 * d)]
    return triangles[gap], center[gap]


@record
class EdgeLimits:
    """Lengths of edges from which bubbles go or to which they come, of circles or of ellipses."""

    delete_shorter: Annotated[float, Gt(0), Le(1), Doc("a bubble goes from an edge shorter than this, in spacings")] = (
        0.72
    )
    insert_longer: Annotated[float, Ge(1), Le(2), Doc("a bubble comes to an edge longer than this, in spacings")] = 1.38
    insert_longer_at_crowd: Annotated[float, Ge(1), Le(2), Doc("the same beside a bubble with eight neighbours")] = 1.12


@record
class Defects(EdgeLimits):
    """Deletion and insertion where the triangulation shows that bubbles are too many or missing.

    An interior bubble goes from an edge that is too short, or if it has four neighbours or fewer. So does one on a
    straight wall that is crowded and has two triangles only. A bubble comes to the middle of an edge that is too long.
    """

    def __call__(self, net: Net, domain: Domain, spacing: Spacing, random: np.random.Generator) -> Change:
        bubbles = net.bubbles
        ratio = relative_lengths(bubbles, net.edges)
        gone = self._crowded(net, ratio, crowded_on_walls(net, domain))
        halved = self._too_long(net, ratio, gone)
        x = bubbles.x[halved].mean(axis=1)
        touched = np.zeros(len(bubbles), bool)
        touched[net.edges[any_of_rows(taken(gone, net.edges))]] = True
        touched[halved] = True
        rest = replace(bubbles, touched=touched).select(np.flatnonzero(~gone))
        grown, triangles = rest.append(x, spacing.extended(x)), spliced(bubbles.x, net.triangles, gone, halved)
        return Change(grown, deleted=len(bubbles) - len(rest), inserted=len(x), triangles=triangles)

    def _crowded(self, net: Net, ratio: Floats, on_walls: Booleans) -> Booleans:
        """Bubbles (n,) to delete, no two of them connected: those given, and interior ones."""
        valence = net.valence
        interior = np.arange(len(valence)) >= net.bubbles.boundary_count
        chosen = on_walls | (interior & (valence <= FEWEST_NEIGHBOURS))
        # What lies in a corner's angle cannot give way: it takes more to be too near.
        at_corner = any_of_rows(net.edges < net.bubbles.corners)
        i, j = net.edges[ratio < np.where(at_corner, TOO_NEAR_CORNER, self.delete_shorter)].T
        chosen[losers(i, j, valence, interior)] = True
        return maximal_independent_set(chosen, net.edges, np.arange(len(chosen)))

    def _too_long(self, net: Net, ratio: Floats, gone: Booleans) -> Integers:
        """Edges (k, 2) with room for one more bubble, no two of them at the same bubble."""
        crowd = any_of_rows((net.valence >= MANY_NEIGHBOURS)[net.edges])
        long = ratio > np.where(crowd, self.insert_longer_at_crowd, self.insert_longer)
        long &= net.inner & ~any_of_rows(taken(gone, net.edges))
        edges = net.edges[long]
        edges = np.concatenate([edges[np.argsort(-ratio[long], kind="stable")], across_wide_corners(net, gone)])
        rank = np.arange(len(edges))
        first = np.full(len(net.bubbles), len(edges))
        np.minimum.at(first, edges, rank[:, None])
        return edges[all_of_rows(first[edges] == rank[:, None])]


def losers(i: Integers, j: Integers, valence: Integers, interior: Booleans) -> Integers:
    """Of bubbles i (k,) and j (k,) too near to each other, those that go: with fewer neighbours, and inner ones."""
    loser = np.where(interior[j] & ((valence[j] <= valence[i]) | ~interior[i]), j, i)
    return loser[interior[loser]]


def relative_lengths(bubbles: Bubbles, edges: Integers) -> Floats:
    """Lengths (m,) of edges (m, 2) over the mean spacing of their ends."""
    i, j = edges.T
    return edge_ratios(bubbles.x, edges, (bubbles.d[i] + bubbles.d[j]) / 2)


def crowded_on_walls(net: Net, domain: Domain) -> Booleans:
    """Sliding bubbles (n,) on nearly straight walls, nearer to their neighbours there than the spacing.

    They have two triangles only, and beside their neighbours on the wall one that is inside; beside a perfect packing
    they have three. Where a curve turns more, every bubble serves the shape of the boundary.
    """
    bubbles, n = net.bubbles, len(net.bubbles)
    ratio = relative_lengths(bubbles, net.facets)
    crowded = np.bincount(net.facets.ravel(), np.repeat(ratio, 2), minlength=n) < 2 * CLOSE_ON_A_WALL
    free = np.zeros(n, bool)
    free[bubbles.sliding] = ~(domain.boundary.inner | domain.tied)[bubbles.piece]
    on_walls = np.bincount(net.edges[all_of_rows(net.edges < bubbles.boundary_count)].ravel(), minlength=n)
    free &= (net.valence == FEWEST_ON_A_WALL) & (on_walls == FEWEST_ON_A_WALL - 1)
    return free & crowded & (net.turns < STRAIGHT_WALL)


def across_wide_corners(net: Net, gone: Booleans) -> Integers:
    """Edges (k, 2) inside the domain that face too wide an angle at a corner of the boundary.

    Where the boundary goes nearly straight on is no corner: cuts, seams, fronts of layers and coasts have many such.
    """
    return np.sort(facing_wide_corners(net, gone, lambda at, v: v / net.bubbles.d[at, None]), axis=1)


def facing_wide_corners(net: Net, gone: Booleans, in_spacings: Callable[[Integers, Floats], Floats]) -> Integers:
    """The edges (k, 2) of `across_wide_corners`, by the angles and lengths where the spacing is 1 in all directions.

    The function takes vectors (m, 2) at bubbles (m,) to those there.
    """
    x, corners = net.bubbles.x, net.bubbles.corners
    beside = taken(net.triangles, any_of_rows(net.triangles < corners))
    beside = beside[~any_of_rows(gone[beside])]
    rows, first = np.arange(len(beside)), np.argmin(beside, axis=1)
    apex, a, b = (beside[rows, (first + k) % 3] for k in range(3))
    sharp = net.turns[apex] >= SHARP_CORNER
    apex, a, b = apex[sharp], a[sharp], b[sharp]
    u, v = (in_spacings(apex, taken(x, end) - taken(x, apex)) for end in (a, b))
    wide = np.einsum("ij,ij->i", u, v) < WIDEST_CORNER * np.hypot(*u.T) * np.hypot(*v.T)
    roomy = np.hypot(*(u + v).T) / 2 > NEAREST_TO_CORNER
    faced = np.column_stack([a, b])[wide & roomy]
    return faced[~net.are_facets(faced)]
