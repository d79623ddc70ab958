"""Grading: a spacing that grows away from where it is fine by no more than a given rate."""

from collections.abc import Callable
from dataclasses import field, replace

import numpy as np

from bubblemesh.arrays import Floats, Integers, each_once, least_of_rows, side_by_side, taken
from bubblemesh.geometry.domain import Domain
from bubblemesh.kernels.lookup import SquareCells, interpolated, ranks
from bubblemesh.records import record
from bubblemesh.spacing.grid.cells import LARGEST_IN_SPACINGS, Samples
from bubblemesh.spacing.grid.quadtree import Quadtree
from bubblemesh.spacing.rules.eikonal import limited_values
from bubblemesh.spacing.rules.resolution import (
    SteepestPlace,
    resolved,
    steepest,
    surely_slow,
    thin_walls,
    too_steep,
    unresolved,
)
from bubblemesh.spacing.rules.sources import SOURCE_CELL, Sources, short_intervals
from bubblemesh.spacing.spacing import Spacing

STEEPEST_GROWTH = 0.4  # of the spacing per length: faster, no packing can follow
ROUNDS = 60
MUCH_LARGER = 2.0  # larger than they should be by a factor above this, cells are split
DEEPEST_FALL = 0.5  # of a source's size, outside
LOWERED = 1e-3  # relative change of the spacing that counts


@record
class Ground:
    """Ground that limits of a spacing in a domain begin with, whatever more sources they have."""

    sources: Sources  # that it was made with, and the spacing's own spots
    samples: Samples  # that resolve the spacing, the sources, and thin walls of the domain
    given: Floats  # (v,): the spacing at the vertices in the domain, infinite at others
    along: Sources  # the spacing along the boundary

    @classmethod
    def of(cls, domain: Domain, spacing: Spacing, samples: Samples, sources: Sources) -> "Ground":
        """Ground on samples that resolve the spacing and the sources."""
        intervals = short_intervals(domain, spacing)
        places, sides = thin_walls(domain, spacing, intervals)
        walls = Sources(places, np.full(len(places), np.inf), sides)
        samples = resolved(samples, domain, spacing, walls)
        given = _in_domain(samples.grid.vertices.points, domain, spacing)
        return cls(sources, samples, given, _on_boundary(domain, spacing, intervals))

    def with_sources(self, domain: Domain, spacing: Spacing, more: Sources) -> "Ground":
        """The ground with more sources."""
        samples = resolved(self.samples, domain, spacing, more)
        given = _at_vertices(samples.grid, domain, spacing, self.samples.grid, self.given)
        return replace(self, sources=self.sources.joined(more), samples=samples, given=given)


@record
class LimitedSpacing:
    """A gradient-limited spacing, and what limiting it has changed."""

    spacing: Spacing  # the largest below the given one, and the sources' sizes, that grows by at most the limit
    steepest: SteepestPlace | None = None  # where the given spacing grows fastest, if faster than the limit
    share: float = 0.0  # of the domain's area where it is finer than the given one
    ratio: float = 1.0  # largest one of the given spacing over it
    ratio_at: tuple[float, float] | None = None  # the place, if it is finer anywhere
    growth: float | None = None  # the limit, if there is one
    ground: Ground | None = field(default=None, repr=False, compare=False)  # for limits with more sources, if kept


@record
class Limit:
    """Upper limit of a spacing on a background grid."""

    cells: SquareCells
    vertices: Integers  # (n, 4): at the corners of the cells, -1 in those without a limit
    values: Floats  # (v,): at the vertices

    def __call__(self, points: Floats) -> Floats:
        """Limit (m,) at points (m, 2), infinite where there is none."""
        return interpolated(self.cells, self.vertices, self.values, points)


def gradient_limited(
    domain: Domain, spacing: Spacing, growth: float, sources: Sources, ground: Ground | None = None
) -> LimitedSpacing:
    """The spacing, made to grow by at most ``growth`` per length, and from the sources' sizes on.

    Distances are taken within the domain. A spacing that grows slowly everywhere is left as it is; any other keeps its
    ``ground``. One that is given has been made of the same spacing, and its sources count as well. The method is that
    of Persson (see `limited_values`).
    """
    if ground is None:
        fine = sources.joined(_spots(domain, spacing))
        if len(fine) == 0 and surely_slow(domain, spacing, growth):
            return LimitedSpacing(spacing, growth=growth)
        samples = resolved(unresolved(domain, spacing), domain, spacing, fine)
        if len(sources) == 0 and steepest(samples, domain, growth) is None:
            return LimitedSpacing(spacing, growth=growth)
        ground = Ground.of(domain, spacing, samples, fine)
    else:
        ground = ground.with_sources(domain, spacing, sources)
    fine, samples, given = ground.sources, ground.samples, ground.given
    grid = samples.grid
    values = np.full(len(given), np.inf)
    for _ in range(ROUNDS):
        # The vertices beside the boundary may all lie outside.
        start = _at(domain, grid, _beside(grid, given, ground.along, growth), fine, growth)
        values = limited_values(grid, np.minimum(start, values), growth, samples.inside)
        largest = _largest_sides(samples, domain, growth, given, values)
        if (grid.sides <= largest).all():
            break
        samples = resolved(samples, domain, spacing, Sources.none(), largest)
        coarser, grid = grid, samples.grid
        given = _at_vertices(grid, domain, spacing, coarser, given)
        values = _carried(coarser, values, grid)
    lowered = values < given * (1 - LOWERED)
    active = lowered[grid.vertices.corners].any(axis=1, keepdims=True)
    limited = _below(spacing, Limit(grid.cells, np.where(active, grid.vertices.corners, -1), values))
    change = _change(samples, given, values)
    return LimitedSpacing(limited, steepest(samples, domain, growth), *change, growth, ground)


def compared(domain: Domain, limited: LimitedSpacing, spacing: Spacing) -> LimitedSpacing:
    """The limited spacing, which has a ground, with what limiting has changed of another spacing."""
    if limited.ground is None:
        return limited
    samples = limited.ground.samples
    given, values = (_in_domain(samples.grid.vertices.points, domain, some) for some in (spacing, limited.spacing))
    share, ratio, ratio_at = _change(samples, given, np.where(np.isfinite(given), values, 1.0))
    return replace(limited, share=share, ratio=ratio, ratio_at=ratio_at)


def limited_for_packing(
    domain: Domain,
    before: LimitedSpacing,
    sources: Sources,
    growth: float,
    ground: Ground | None,
) -> LimitedSpacing:
    """The spacing, made to grow slowly enough for a packing, and from the sources on by ``growth`` at most.

    It keeps its ``ground``, with which the next one begins that is made of the same spacing and more sources: only
    these are given then.
    """
    if before.growth is None or before.growth > STEEPEST_GROWTH:
        return gradient_limited(domain, before.spacing, STEEPEST_GROWTH, sources, ground)
    if len(sources) == 0:
        return before
    # It grows slowly but for the cells in which it is interpolated.
    return replace(gradient_limited(domain, before.spacing, growth, sources, ground), steepest=before.steepest)


def _spots(domain: Domain, spacing: Spacing) -> Sources:
    """The spacing's own spots that lie in the domain."""
    points = spacing.spots[domain.contains(spacing.spots)]
    return Sources(points, spacing(points))


def _on_boundary(domain: Domain, spacing: Spacing, intervals: tuple[Integers, Floats, Floats]) -> Sources:
    """The spacing along the boundary, at the begin of intervals (see `short_intervals`)."""
    piece, begin, _ = intervals
    points = domain.boundary.points(piece, begin)
    return Sources(points, spacing(points))


def _largest_sides(samples: Samples, domain: Domain, growth: float, given: Floats, values: Floats) -> Floats:
    """Largest sides (n,) of the cells for values (v,) at the vertices in place of the ``given`` ones (v,).

    Where the spacing leaves the limit, its place decides on all that is farther off.
    """
    grid, inside = samples.grid, samples.inside
    mine = values[grid.vertices.corners]
    largest = np.where(inside, LARGEST_IN_SPACINGS * least_of_rows(mine), np.inf)
    if (grid.sides <= MUCH_LARGER * largest).all():
        largest = grid.sides.copy()
    steep = np.flatnonzero(inside & too_steep(samples, growth).any(axis=1))
    kept = (values >= given * (1 - LOWERED))[grid.vertices.corners[steep]].any(axis=1)
    kept |= (samples.d[steep, 0] < mine[steep].mean(axis=1)) & domain.contains(grid.centers[steep])
    leaving = steep[kept]
    finest = SOURCE_CELL * np.minimum(samples.d[leaving].min(axis=1), mine[leaving].min(axis=1))
    largest[leaving] = np.minimum(largest[leaving], np.maximum(finest, grid.sides[leaving] / 2))
    return np.where(grid.divisible, np.minimum(largest, grid.sides), grid.sides)


def _at_vertices(grid: Quadtree, domain: Domain, spacing: Spacing, coarse: Quadtree, known: Floats) -> Floats:
    """Spacing (v,) at the vertices in the domain, infinite at others, known at those of the grid that it stems from."""
    result, fresh = np.empty(len(grid.vertices.key)), np.ones(len(grid.vertices.key), bool)
    same = ranks(grid.vertices.key, coarse.vertices.key)
    result[same], fresh[same] = known, False
    result[fresh] = _in_domain(grid.vertices.points[fresh], domain, spacing)
    return result


def _in_domain(points: Floats, domain: Domain, spacing: Spacing) -> Floats:
    """Spacing (m,) at the points (m, 2) that lie in the domain, infinite at the others."""
    inside = np.flatnonzero(domain.contains(points))
    d = np.full(len(points), np.inf)
    d[inside] = spacing.extended(taken(points, inside))
    return d


def _carried(coarse: Quadtree, values: Floats, grid: Quadtree) -> Floats:
    """Values (v,) at the vertices of a grid from those of the coarse one that it stems from; infinite at new ones.

    They are upper limits still: smaller cells only find finer places.
    """
    result = np.full(len(grid.vertices.key), np.inf)
    same = ranks(grid.vertices.key, coarse.vertices.key)
    result[same] = values
    result[same[coarse.vertices.hanging[:, 0]]] = np.inf
    return result


def _beside(grid: Quadtree, values: Floats, sources: Sources, growth: float) -> Floats:
    """Values (v,) that respect the sources at the vertices around them."""
    mine = taken(grid.vertices.corners, grid.located(sources.points))
    result = values.copy()
    np.minimum.at(result, mine, sources.sizes[:, None] + growth * _away(grid, mine, sources))
    return result


def _at(domain: Domain, grid: Quadtree, values: Floats, sources: Sources, growth: float) -> Floats:
    """Values (v,) whose interpolation respects the sources where they are; their cells are small.

    Infinite values lie outside. Beside sources on the rim the spacing falls there as it rises inside: what is
    interpolated between both is as large all along the boundary.
    """
    cells = grid.located(sources.points)
    mine = taken(grid.vertices.corners, cells)
    rise = growth * _away(grid, mine, sources)
    falling = np.isinf(values[mine]) & sources.on_rim[:, None]
    outside = each_once(mine[falling])
    depth = np.zeros(len(values))
    depth[outside] = -domain.signed_distance(grid.vertices.points[outside])
    deepest = np.broadcast_to(DEEPEST_FALL * sources.sizes[:, None], mine.shape)
    rise[falling] = -np.minimum(growth * depth[mine], deepest)[falling]
    excess = grid.cells.bilinear(rise, sources.points, cells)[:, None]
    result = values.copy()
    np.minimum.at(result, mine, sources.sizes[:, None] + np.where(falling, rise - excess, np.maximum(rise - excess, 0)))
    return result


def _away(grid: Quadtree, vertices: Integers, sources: Sources) -> Floats:
    """Distances (k, 4) of the sources from vertices (k, 4)."""
    away = taken(grid.vertices.points, vertices) - sources.points[:, None]
    return np.hypot(away[..., 0], away[..., 1])


@record
class _Lower:
    """The smaller one of a spacing's function and a limit."""

    function: Callable[[Floats, Floats], Floats]
    limit: Limit

    def __call__(self, x: Floats, y: Floats) -> Floats:
        return np.minimum(self.function(x, y), self.limit(side_by_side(x, y)))  # no number stays none


def _below(spacing: Spacing, limit: Limit) -> Spacing:
    """The spacing where it is below a limit, else the limit."""
    return replace(
        spacing, function=_Lower(spacing.function, limit), floor=min(spacing.floor, float(limit.values.min()) / 2)
    )


def _change(samples: Samples, given: Floats, values: Floats) -> tuple[float, float, tuple[float, float] | None]:
    """Share of the area where values (v,) at the vertices are below the given ones, the largest ratio, its place."""
    ratio = np.where(np.isfinite(given), given / values, 1.0)
    corners = taken(samples.grid.vertices.corners, samples.inside)
    area = samples.grid.sides[samples.inside] ** 2
    lower = (ratio > 1 / (1 - LOWERED))[corners].mean(axis=1)
    most = ratio.argmax()
    x, y = samples.grid.vertices.points[most].tolist()
    return float((area * lower).sum() / area.sum()), float(ratio[most]), (x, y) if ratio[most] > 1 else None
