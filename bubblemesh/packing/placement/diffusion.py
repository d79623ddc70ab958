"""Initial bubbles by error diffusion: as many as the spacing asks for, from the start."""

from collections.abc import Callable
from typing import Annotated

import numpy as np
from annotated_types import Ge, Le
from typing_extensions import Doc

from bubblemesh.arrays import GAUSS, Booleans, Floats, Integers, members, taken
from bubblemesh.geometry.distance.chord_runs import ChordRuns
from bubblemesh.geometry.distance.nearest_chord import distance_at_least, nearest_chord
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.periodic import counterparts
from bubblemesh.packing.boundary_edges import split_cutting_edges
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.placement import Placement, require_at_most
from bubblemesh.records import record
from bubblemesh.spacing.grid.cells import Leaves, leaves_in_blocks
from bubblemesh.spacing.rules.rules import finer_of_both_sides
from bubblemesh.spacing.rules.sources import short_intervals
from bubblemesh.spacing.spacing import Spacing

AREA = np.sqrt(3) / 2  # of the plane for each bubble of a perfect packing, in units of d^2
HALF_A_ROW = np.sqrt(3) / 4  # what the boundary bubbles take up of the domain beside them, in units of d
FEWEST_ON_A_CLOSED_CURVE = 3
NEAREST_TO_BOUNDARY = 0.5  # spacings
HELD = 0.75  # part of the bubbles held on a piece, or of every second of them, that a spacing has to ask for
FEWEST_HALVED = 12  # intervals that are left, at least, of a number that is halved again and again


@record
class ErrorDiffusion(Placement):
    """As many bubbles as the spacing asks for, by error diffusion.

    A walk through small cells places one wherever the cells passed add up to the area of one more. It follows a Hilbert
    curve over the leaves of a quadtree, so that no error of the sum is carried far.

    References
    ----------
    R. W. Floyd, L. Steinberg, "An adaptive algorithm for spatial greyscale", Proc. SID 17 (1976), for the principle.
    """

    leaf: Annotated[float, Ge(0.1), Le(0.5), Doc("largest side of the cells, in spacings")] = 0.35

    def __call__(self, domain: Domain, spacing: Spacing, max_nodes: int) -> Bubbles:
        shell = boundary_bubbles(domain, spacing)
        x = diffused_points(domain, spacing, shell, self.leaf)
        require_at_most(max_nodes, len(shell) + len(x), spacing)
        return shell.append(x, spacing(x))


def everything(x: Floats, d: Floats) -> Floats:
    """Part (n,) of the bubbles of sizes d (n,) at x (n, 2) that a domain without any lacks: one."""
    return np.ones(len(x))


def diffused_points(
    domain: Domain,
    spacing: Spacing,
    shell: Bubbles,
    leaf: float,
    lacking: Callable[[Floats, Floats], Floats] = everything,
) -> Floats:
    """Points (k, 2) for interior bubbles, by error diffusion over leaves of sides up to ``leaf`` spacings.

    ``lacking`` returns the part (n,) of the bubbles of sizes d (n,) at points x (n, 2) that is not there yet.
    """
    diffusion = Diffusion(near_facets(shell, domain))
    cells = leaves_in_blocks(domain, spacing, leaf)
    return np.concatenate(
        [taken(some.centers, diffusion.chosen(some, lacking(some.centers, some.d))) for some in cells]
    )


class Diffusion:
    """A walk through the cells of a domain beside the bubbles on its boundary, block by block."""

    def __init__(self, to_boundary: "NearLines") -> None:
        self._to_boundary, self._passed = to_boundary, 0.0

    def chosen(self, cells: Leaves, lacking: Floats) -> Booleans:
        """The next cells (n,) that get a bubble, where the part ``lacking`` (n,) of the bubbles is not there yet."""
        distance = self._to_boundary(cells.centers, cells.d)
        # A cell that reaches into the strip of the boundary bubbles counts in part.
        share = np.clip((distance - HALF_A_ROW * cells.d) / cells.sides + 0.5, 0, 1) * lacking
        passed = np.cumsum(np.append(self._passed, share * cells.sides**2 / (AREA * cells.d**2)))
        self._passed = passed[-1]
        return np.diff(np.floor(passed + 0.5)) > 0


def boundary_bubbles(domain: Domain, spacing: Spacing, halved: Booleans | None = None) -> Bubbles:
    """The bubbles on the boundary alone, equidistributed as `equidistributed` does it."""
    boundary = domain.boundary
    piece, s = equidistributed(domain, spacing, halved)
    x = np.vstack([boundary.corners, boundary.points(piece, s)])
    shell = Bubbles(x, spacing(x), piece, s, len(boundary.corners), touched=np.zeros(len(x), bool))
    return split_cutting_edges(shell, domain, spacing)


def equidistributed(domain: Domain, spacing: Spacing, halved: Booleans | None = None) -> tuple[Integers, Floats]:
    """Pieces (m,) and arc lengths (m,) that divide each boundary piece equally in the integral of ds / d.

    A piece gets as many intervals as the integral says, to the nearest whole number and at least one; pieces that are
    to be ``halved`` (p,), none by default, to the nearest number that can be halved again and again. What the domain
    holds is as it is there, and for coarser spacings every second, fourth, ... bubble of it, if there are as many.
    """
    boundary = domain.boundary
    piece, begin, length = short_intervals(domain, spacing)
    weight = length / 2 * sum(1 / finer_of_both_sides(domain, spacing, piece, begin + t * length) for t in GAUSS)
    total = np.asarray(np.bincount(piece, weight, minlength=len(boundary.lengths)), np.float64)
    fewest = np.where(boundary.closed, FEWEST_ON_A_CLOSED_CURVE, 1)
    unit = np.ones(len(total), np.int64) if halved is None else np.where(halved, _halvable(total), 1)
    intervals = np.maximum(np.rint(total / unit).astype(np.int64) * unit, fewest)
    held = domain.held
    given = np.bincount(held.piece, minlength=len(total)) + 1
    least = np.zeros(len(total)) if spacing.in_metric else HELD * given / intervals  # a metric has no coarser levels
    step = _powers_of_two(least)
    from_held = np.zeros(len(total), bool)
    from_held[held.pieces] = (given % step == 0)[held.pieces]
    # A closed curve has a bubble at its start, an open piece a corner.
    count = np.where(from_held, 0, np.where(boundary.closed, intervals, intervals - 1))
    owner, rank = members(count)
    rank = rank + ~boundary.closed[owner]
    before = np.cumsum(total) - total
    target = before[owner] + total[owner] * rank / intervals[owner]
    reached = np.cumsum(weight)
    last = np.searchsorted(piece, np.arange(len(count)), side="right") - 1
    panel = np.minimum(np.searchsorted(reached, target, side="right"), last[owner])
    share = (target - (reached - weight)[panel]) / weight[panel]
    # Sums over all pieces round: what should be a panel of this piece may come out as the end of the one before.
    s = np.where(piece[panel] == owner, begin[panel] + share * length[panel], 0.0)
    mine = from_held[held.piece] & ((members(given - 1)[1] + 1) % step[held.piece] == 0)
    owner, s = np.append(owner, held.piece[mine]), np.append(boundary.wrapped(owner, s), held.s[mine])
    order = np.argsort(owner, kind="stable")
    return _mirrored(domain, owner[order], s[order])


def _halvable(intervals: Floats) -> Integers:
    """Powers of two (p,) of which numbers of intervals (p,) are to be multiples: as large as `FEWEST_HALVED` allows."""
    return 2 ** np.floor(np.log2(np.maximum(intervals / FEWEST_HALVED, 1))).astype(np.int64)


def _powers_of_two(least: Floats) -> Integers:
    """The smallest powers of two (p,), from one on, that are not less than these."""
    return 2 ** np.ceil(np.log2(np.maximum(least, 1))).astype(np.int64)


def _mirrored(domain: Domain, piece: Integers, s: Floats) -> tuple[Integers, Floats]:
    """Pieces and arc lengths with those of periodic sides taken from their counterparts, which run the other way."""
    pairs = domain.periodic
    if len(pairs) == 0:
        return piece, s
    own = ~np.isin(piece, pairs[:, 1])
    piece, s = piece[own], s[own]
    _, other, at = counterparts(domain.boundary, pairs, piece, s)
    piece, s = np.append(piece, other), np.append(s, at)
    order = np.lexsort((s, piece))
    return piece[order], s[order]


def distance_to_facets(shell: Bubbles, domain: Domain, points: Floats, d: Floats) -> Floats:
    """Distances (n,) of points (n, 2) to facets and embedded points, infinite beyond d (n,): see `NearLines`."""
    return near_facets(shell, domain)(points, d)


def near_facets(shell: Bubbles, domain: Domain) -> "NearLines":
    """Distances to facets and embedded points, where these are near."""
    facets, _ = domain.boundary.edges(shell.piece, shell.s)
    alone = np.flatnonzero(np.bincount(facets.ravel(), minlength=shell.corners)[: shell.corners] == 0)
    return NearLines.between(shell.x[np.concatenate([facets, np.column_stack([alone, alone])])])


@record
class NearLines:
    """Distances to straight lines, where these are near."""

    runs: ChordRuns

    @classmethod
    def between(cls, ends: Floats) -> "NearLines":
        """Lines between these ends (k, 2, 2)."""
        return cls(ChordRuns.of(ends[:, 0], ends[:, 1]))

    def __call__(self, points: Floats, d: Floats) -> Floats:
        """Distances (n,) of points (n, 2) along a Hilbert curve or another one like it, infinite beyond d (n,)."""
        result = np.full(len(points), np.inf)
        near = np.flatnonzero(distance_at_least(self.runs, points, along_curve=True) <= d)
        some = taken(points, near)
        foot = self.runs.feet(some, nearest_chord(self.runs, some))[1]
        distance = np.hypot(*(some - foot).T)
        within = distance <= d[near]
        result[near[within]] = distance[within]
        return result
