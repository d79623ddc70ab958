"""Graded spacing: it grows away from where it is fine by no more than a given rate."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.domain import Domain
from bubblemesh.spacing.background import Background
from bubblemesh.spacing.eikonal import slowed
from bubblemesh.spacing.panels import panels
from bubblemesh.spacing.refinement import Sources
from bubblemesh.spacing.spacing import Spacing

__all__ = ["GROWTH", "Graded", "Steepest", "graded", "reaching"]

GROWTH = 0.4  # of the spacing per length: faster, no packing can follow
CELL = 2.0  # spacings: largest side of a cell
COARSEST = 1 / 32  # of the domain's size: spots as large as that are not passed over
FINEST = 0.25  # spacings: largest side of a cell from which the limit starts
ROUNDS = 60
SPLITS = 1000
LOWERED = 1e-3  # relative change of the spacing that counts
TOLERANCE = 1e-3  # relative excess of the growth that does not
SAMPLES = np.array([[0, 0], [-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]])  # of a cell, from its centre
PAIRS = np.array([[0, 1], [0, 2], [0, 3], [0, 4], [1, 2], [3, 4], [1, 3], [2, 4]])


class Steepest(NamedTuple):
    """Where the spacing grows fastest: place (x, y) and spacing on the fine side, and the growth per length."""

    at: tuple[float, float]
    size: float
    growth: float


@dataclass(frozen=True)
class Graded:
    """A spacing that is graded.

    Attributes
    ----------
    spacing : Spacing
        The largest one below the wanted one, and below the sources' sizes, that grows by at most the limit.
    steepest : Steepest or None
        Where the wanted one grows fastest, if faster than the limit.
    share : float
        Part of the domain's area where it is finer than the wanted one.
    ratio : float
        Wanted spacing over it, where that is largest.
    ratio_at : tuple of float or None
        That place (x, y), if it is finer anywhere.
    """

    spacing: Spacing
    steepest: Steepest | None = None
    share: float = 0.0
    ratio: float = 1.0
    ratio_at: tuple[float, float] | None = None


@dataclass(frozen=True)
class Limit:
    """Upper limit of a spacing on a background grid: values (v,) at the vertices, in the ``active`` cells (n,)."""

    grid: Background
    values: Floats
    active: Booleans

    def __call__(self, points: Floats) -> Floats:
        """Limit (m,) at points (m, 2), infinite where there is none."""
        cells = self.grid.located(points)
        found = np.flatnonzero(self.active[cells])
        limit = np.full(len(points), np.inf)
        limit[found] = self.grid.interpolated(self.values, points[found], cells[found])
        return limit


@dataclass(frozen=True)
class Sampled:
    """A grid and the wanted spacing in its cells.

    Attributes
    ----------
    grid : Background
    inside : (n,)
        Which cells reach into the domain.
    d : (n, 5)
        Spacing at the centres and corners, whether or not they lie in the domain.
    finest : (n,)
        Size of the finest source in each cell, infinite where there is none.
    """

    grid: Background
    inside: Booleans
    d: Floats
    finest: Floats

    def largest(self, coarsest: float) -> Floats:
        """Largest sides (n,) of cells that resolve the spacing and the sources."""
        wanted = np.minimum(CELL * self.d.min(axis=1), FINEST * self.finest)
        return np.where(self.inside & self.grid.divisible, np.minimum(wanted, coarsest), np.inf)

    def slopes(self) -> Floats:
        """Growth (n, 8) of the spacing per length between the `PAIRS` of samples."""
        lengths = self.grid.sides[:, None] * np.hypot(*(SAMPLES[PAIRS[:, 1]] - SAMPLES[PAIRS[:, 0]]).T)
        return np.abs(self.d[:, PAIRS[:, 1]] - self.d[:, PAIRS[:, 0]]) / lengths


def graded(domain: Domain, spacing: Spacing, growth: float, sources: Sources) -> Graded:
    """The spacing, made to grow by at most ``growth`` per length, and from the sources' sizes on.

    Distances are taken within the domain. A spacing that grows slowly everywhere is left as it is.
    """
    sampled = _resolved(_root(domain), domain, spacing, sources, np.inf)
    if len(sources) == 0 and _steepest(sampled, domain, growth) is None:
        return Graded(spacing)
    # The vertices beside the boundary may all lie outside.
    limits = sources.joined(_on_boundary(domain, spacing))
    for _ in range(ROUNDS):
        grid = sampled.grid
        wanted = _wanted(grid, domain, spacing)
        values = slowed(grid, _with_sources(grid, wanted, limits, growth), growth, sampled.inside)
        largest = _largest(sampled, domain, growth, wanted, values)
        if (grid.sides <= largest).all():
            break
        sampled = _resolved(sampled, domain, spacing, sources, largest)
    lowered = values < wanted * (1 - LOWERED)
    active: Booleans = np.asarray(lowered[grid.vertices.corners].any(axis=1))
    limited = _limited(spacing, Limit(grid, values, active))
    return Graded(limited, _steepest(sampled, domain, growth), *_change(sampled, wanted, values))


def _root(domain: Domain) -> Sampled:
    grid = Background.around(domain.bounds)
    return Sampled(grid, np.ones(1, bool), np.zeros((1, len(SAMPLES))), np.zeros(1))


def _resolved(sampled: Sampled, domain: Domain, spacing: Spacing, sources: Sources, largest: Floats | float) -> Sampled:
    """Cells split until they resolve the spacing, none is above ``largest`` (n,), and their sizes are balanced."""
    split = sampled.grid.sides > largest
    for _ in range(SPLITS):
        split |= sampled.grid.sides > sampled.largest(COARSEST * domain.size)
        if not split.any():
            split = sampled.grid.unbalanced()
        if not split.any():
            break
        grid, origin, fresh = sampled.grid.split(split)
        mine = np.flatnonzero(fresh)
        inside, d, finest = sampled.inside[origin], sampled.d[origin], np.full(len(grid), np.inf)
        inside[mine] = reaching(domain, grid.centers[mine], grid.sides[mine])
        d[mine] = spacing.extended(_places(grid, mine).reshape(-1, 2)).reshape(-1, len(SAMPLES))
        np.minimum.at(finest, grid.located(sources.points), sources.sizes)
        sampled = Sampled(grid, inside, d, finest)
        split = np.zeros(len(grid), bool)
    return sampled


def _places(grid: Background, cells: Integers) -> Floats:
    """Samples (k, 5, 2) of some cells: centre and corners."""
    return grid.centers[cells, None] + grid.sides[cells, None, None] * SAMPLES


def reaching(domain: Domain, centers: Floats, sides: Floats) -> Booleans:
    """Which square cells (k,) reach into the domain, or nearly so."""
    reaching = domain.contains(centers)
    outside = np.flatnonzero(~reaching)
    reaching[outside] = domain.signed_distance(centers[outside]) > -sides[outside] * np.sqrt(0.5)
    return reaching


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
    finest = FINEST * np.minimum(sampled.d[leaving].min(axis=1), mine[leaving].min(axis=1))
    largest[leaving] = np.minimum(largest[leaving], np.maximum(finest, grid.sides[leaving] / 2))
    return np.where(grid.divisible, np.minimum(largest, grid.sides), grid.sides)


def _steepest(sampled: Sampled, domain: Domain, growth: float) -> Steepest | None:
    """Where the spacing grows fastest between samples of a cell that lie in the domain, if faster than ``growth``."""
    slopes = sampled.slopes() * sampled.inside[:, None]
    cell, pair = np.nonzero(slopes > growth * (1 + TOLERANCE))
    ends = _places(sampled.grid, cell)[np.arange(len(cell))[:, None], PAIRS[pair]]
    real = domain.contains(ends[:, 0]) & domain.contains(ends[:, 1])
    cell, pair, ends = cell[real], pair[real], ends[real]
    if len(cell) == 0:
        return None
    k = slopes[cell, pair].argmax()
    d = sampled.d[cell[k], PAIRS[pair[k]]]
    x, y = ends[k, d.argmin()].tolist()
    return Steepest((x, y), float(d.min()), float(slopes[cell[k], pair[k]]))


def _wanted(grid: Background, domain: Domain, spacing: Spacing) -> Floats:
    """Spacing (v,) at the vertices in the domain, infinite at the others."""
    points = grid.vertices.points
    inside = np.flatnonzero(domain.contains(points))
    wanted = np.full(len(points), np.inf)
    wanted[inside] = spacing.extended(points[inside])
    return wanted


def _with_sources(grid: Background, values: Floats, sources: Sources, growth: float) -> Floats:
    """Values (v,) that respect the sources in the cells around."""
    mine = grid.vertices.corners[grid.located(sources.points)]
    away = grid.vertices.points[mine] - sources.points[:, None]
    result = values.copy()
    np.minimum.at(result, mine, sources.sizes[:, None] + growth * np.hypot(away[..., 0], away[..., 1]))
    return result


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
