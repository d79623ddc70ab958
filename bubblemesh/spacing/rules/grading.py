"""LimitedSpacing spacing: it grows away from where it is fine by no more than a given rate."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.domain import Domain
from bubblemesh.spacing.grid.quadtree import Quadtree
from bubblemesh.spacing.grid.sampled import CELL, PAIRS, Sampled, places, resolved, whole
from bubblemesh.spacing.rules.eikonal import limited_values
from bubblemesh.spacing.rules.sources import SOURCE_CELL, Sources, panels
from bubblemesh.spacing.rules.thin_walls import thin_walls
from bubblemesh.spacing.spacing import Spacing

GROWTH = 0.4  # of the spacing per length: faster, no packing can follow
ROUNDS = 60
LOWERED = 1e-3  # relative change of the spacing that counts
TOLERANCE = 1e-3  # relative excess of the growth that does not


class SteepestPlace(NamedTuple):
    """Place (x, y) where a spacing grows fastest, the spacing on its fine side, and the growth per length."""

    at: tuple[float, float]
    size: float
    growth: float


@dataclass(frozen=True)
class LimitedSpacing:
    """A gradient-limited spacing, and what limiting it has changed.

    Attributes
    ----------
    spacing : Spacing
        The largest one below the given one, and below the sources' sizes, that grows by at most the limit.
    steepest : SteepestPlace or None
        Where the given one grows fastest, if faster than the limit.
    share : float
        Part of the domain's area where it is finer than the given one.
    ratio : float
        Given spacing over it, where that is largest.
    ratio_at : tuple of float or None
        That place (x, y), if it is finer anywhere.
    growth : float or None
        The limit, if there is one.
    """

    spacing: Spacing
    steepest: SteepestPlace | None = None
    share: float = 0.0
    ratio: float = 1.0
    ratio_at: tuple[float, float] | None = None
    growth: float | None = None


@dataclass(frozen=True)
class Limit:
    """Upper limit of a spacing on a background grid: values (v,) at the vertices, in the ``active`` cells (n,)."""

    grid: Quadtree
    values: Floats
    active: Booleans

    def __call__(self, points: Floats) -> Floats:
        """Limit (m,) at points (m, 2), infinite where there is none."""
        cells = self.grid.located(points)
        found = np.flatnonzero(self.active[cells])
        limit = np.full(len(points), np.inf)
        limit[found] = self.grid.interpolated(self.values, points[found], cells[found])
        return limit


def gradient_limited(domain: Domain, spacing: Spacing, growth: float, sources: Sources) -> LimitedSpacing:
    """The spacing, made to grow by at most ``growth`` per length, and from the sources' sizes on.

    Distances are taken within the domain. A spacing that grows slowly everywhere is left as it is.

    References
    ----------
    P.-O. Persson, "Mesh size functions for implicit geometries and PDE-based gradient limiting", Engineering with
    Computers 22 (2006).
    """
    fine = sources.joined(_spots(domain, spacing))
    sampled = resolved(whole(domain), domain, spacing, fine, np.inf)
    if len(sources) == 0 and _steepest(sampled, domain, growth) is None:
        return LimitedSpacing(spacing, growth=growth)
    # The vertices beside the boundary may all lie outside.
    rim = _on_boundary(domain, spacing)
    walls, sides = thin_walls(domain, spacing)
    small = fine.joined(Sources(walls, np.full(len(walls), np.inf), sides))
    sampled = resolved(sampled, domain, spacing, small, np.inf)
    grid, values = sampled.grid, np.full(len(sampled.grid.vertices.key), np.inf)
    for _ in range(ROUNDS):
        before, grid = (grid, values), sampled.grid
        wanted = _wanted(grid, domain, spacing)
        start = _at(grid, _beside(grid, wanted, rim, growth), fine, growth)
        start = np.minimum(start, _carried(*before, grid))
        values = limited_values(grid, start, growth, sampled.inside)
        largest = _largest(sampled, domain, growth, wanted, values)
        if (grid.sides <= largest).all():
            break
        sampled = resolved(sampled, domain, spacing, small, largest)
    lowered = values < wanted * (1 - LOWERED)
    active: Booleans = np.asarray(lowered[grid.vertices.corners].any(axis=1))
    limited = _limited(spacing, Limit(grid, values, active))
    return LimitedSpacing(limited, _steepest(sampled, domain, growth), *_change(sampled, wanted, values), growth)


def limited_for_packing(domain: Domain, before: LimitedSpacing, sources: Sources) -> LimitedSpacing:
    """The spacing, made to grow slowly enough for a packing, from the sources on as well."""
    if before.growth is None or before.growth > GROWTH:
        return gradient_limited(domain, before.spacing, GROWTH, sources)
    if len(sources) == 0:
        return before
    # It grows slowly but for the cells in which it is interpolated.
    return replace(gradient_limited(domain, before.spacing, GROWTH, sources), steepest=before.steepest)


def _spots(domain: Domain, spacing: Spacing) -> Sources:
    """The spacing's own spots that lie in the domain."""
    points = spacing.spots[domain.contains(spacing.spots)]
    return Sources(points, spacing(points))


def _on_boundary(domain: Domain, spacing: Spacing) -> Sources:
    """The spacing along the boundary."""
    piece, begin, _ = panels(domain, spacing)
    points = domain.boundary.points(piece, begin)
    return Sources(points, spacing(points))


def _largest(sampled: Sampled, domain: Domain, growth: float, wanted: Floats, values: Floats) -> Floats:
    """Largest sides (n,) of the cells for values (v,) at the vertices in place of the wanted ones.

    Where the spacing leaves the limit, its place decides on all that is farther off.
    """
    grid, inside = sampled.grid, sampled.inside
    mine = values[grid.vertices.corners]
    largest = np.where(inside, CELL * mine.min(axis=1), np.inf)
    steep = np.flatnonzero(inside & (sampled.slopes() > growth * (1 + TOLERANCE)).any(axis=1))
    kept = (values >= wanted * (1 - LOWERED))[grid.vertices.corners[steep]].any(axis=1)
    kept |= (sampled.d[steep, 0] < mine[steep].mean(axis=1)) & domain.contains(grid.centers[steep])
    leaving = steep[kept]
    finest = SOURCE_CELL * np.minimum(sampled.d[leaving].min(axis=1), mine[leaving].min(axis=1))
    largest[leaving] = np.minimum(largest[leaving], np.maximum(finest, grid.sides[leaving] / 2))
    return np.where(grid.divisible, np.minimum(largest, grid.sides), grid.sides)


def _steepest(sampled: Sampled, domain: Domain, growth: float) -> SteepestPlace | None:
    """Where the spacing grows fastest between samples of a cell that lie in the domain, if faster than ``growth``."""
    slopes = sampled.slopes() * sampled.inside[:, None]
    cell, pair = np.nonzero(slopes > growth * (1 + TOLERANCE))
    ends = places(sampled.grid, cell)[np.arange(len(cell))[:, None], PAIRS[pair]]
    real = domain.contains(ends[:, 0]) & domain.contains(ends[:, 1])
    cell, pair, ends = cell[real], pair[real], ends[real]
    if len(cell) == 0:
        return None
    k = slopes[cell, pair].argmax()
    d = sampled.d[cell[k], PAIRS[pair[k]]]
    x, y = ends[k, d.argmin()].tolist()
    return SteepestPlace((x, y), float(d.min()), float(slopes[cell[k], pair[k]]))


def _wanted(grid: Quadtree, domain: Domain, spacing: Spacing) -> Floats:
    """Spacing (v,) at the vertices in the domain, infinite at the others."""
    points = grid.vertices.points
    inside = np.flatnonzero(domain.contains(points))
    wanted = np.full(len(points), np.inf)
    wanted[inside] = spacing.extended(points[inside])
    return wanted


def _carried(coarse: Quadtree, values: Floats, grid: Quadtree) -> Floats:
    """Values (v,) at the vertices of a grid from those of the coarse one that it stems from; infinite at new ones.

    They are upper limits still: smaller cells only find finer places.
    """
    result = np.full(len(grid.vertices.key), np.inf)
    same = np.searchsorted(grid.vertices.key, coarse.vertices.key)
    result[same] = values
    result[same[coarse.vertices.hanging[:, 0]]] = np.inf
    return result


def _beside(grid: Quadtree, values: Floats, sources: Sources, growth: float) -> Floats:
    """Values (v,) that respect the sources at the vertices around them."""
    mine = grid.vertices.corners[grid.located(sources.points)]
    result = values.copy()
    np.minimum.at(result, mine, sources.sizes[:, None] + growth * _away(grid, mine, sources))
    return result


def _at(grid: Quadtree, values: Floats, sources: Sources, growth: float) -> Floats:
    """Values (v,) whose interpolation respects the sources where they are; their cells are small."""
    cells = grid.located(sources.points)
    mine = grid.vertices.corners[cells]
    rise = growth * _away(grid, mine, sources)
    excess = grid.bilinear(rise, sources.points, cells)
    result = values.copy()
    np.minimum.at(result, mine, sources.sizes[:, None] + np.maximum(rise - excess[:, None], 0))
    return result


def _away(grid: Quadtree, vertices: Integers, sources: Sources) -> Floats:
    """Distances (k, 4) of the sources from vertices (k, 4)."""
    away = grid.vertices.points[vertices] - sources.points[:, None]
    return np.hypot(away[..., 0], away[..., 1])


def _limited(spacing: Spacing, limit: Limit) -> Spacing:
    def function(x: Floats, y: Floats) -> Floats:
        wanted = np.broadcast_to(np.asarray(spacing.function(x, y), float), np.shape(x))
        return np.minimum(wanted, limit(np.column_stack([x, y])))  # no number stays none

    return replace(spacing, function=function, floor=min(spacing.floor, float(limit.values.min()) / 2))


def _change(sampled: Sampled, wanted: Floats, values: Floats) -> tuple[float, float, tuple[float, float] | None]:
    """Share of the area where values (v,) at the vertices are below the wanted ones, the largest ratio, its place."""
    ratio = np.where(np.isfinite(wanted), wanted / values, 1.0)
    corners = sampled.grid.vertices.corners[sampled.inside]
    area = sampled.grid.sides[sampled.inside] ** 2
    lower = (ratio > 1 / (1 - LOWERED))[corners].mean(axis=1)
    most = ratio.argmax()
    x, y = sampled.grid.vertices.points[most].tolist()
    return float((area * lower).sum() / area.sum()), float(ratio[most]), (x, y) if ratio[most] > 1 else None
