"""Grids whose cells resolve a spacing, the sources around which it is finer, and thin walls of the domain."""

from functools import partial
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, largest_of_rows, least_of_rows, members, taken, turned_left
from bubblemesh.geometry.domain import Domain
from bubblemesh.kernels.lookup import ranks
from bubblemesh.spacing.bounds import bounds_of
from bubblemesh.spacing.grid.cells import LARGEST_IN_DOMAIN, LARGEST_IN_SPACINGS, Samples
from bubblemesh.spacing.grid.quadtree import GRID_LEVELS, Quadtree
from bubblemesh.spacing.rules.sources import Sources
from bubblemesh.spacing.spacing import Spacing

SPLITS = 1000
PLACES = np.array([[0, 0], [-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]])  # of samples, from a cell's centre
# Places of quarters: from 0 to 3 the corners of the whole, from 4 on where the quarters meet, from 9 on their centres.
QUARTERS = np.array([[9, 0, 4, 5, 6], [10, 4, 1, 6, 7], [11, 5, 6, 2, 8], [12, 6, 7, 8, 3]])
PAIRS = np.array([[0, 1], [0, 2], [0, 3], [0, 4], [1, 2], [3, 4], [1, 3], [2, 4]])
NEAREST = 0.7  # sides: less than the distance of any pair
TOLERANCE = 1e-3  # relative excess of the growth that does not count
WIDEST_WALL = 4.0  # spacings: radius of the discs outside that a coarse cell cannot overlook
FITTING = 0.9  # depth of a disc's centre in terms of its radius
WALL_CELL = 0.5  # radii: side of the cells that part one side of a wall from the other
THINNEST_WALL = 1e-9  # of the domain's size
MOST_UNSURE = 1 << 11  # cells of one level, which bounds of the spacing say nothing on
MOST_WALL_PLACES = 5_000  # places: walls that would need more are seen as thicker than they are


class SteepestPlace(NamedTuple):
    """Place (x, y) where a spacing grows fastest, the spacing on its fine side, and the growth per length."""

    at: tuple[float, float]
    size: float
    growth: float


def unresolved(domain: Domain, spacing: Spacing) -> Samples:
    """A cell around the domain, which is to be split in any case."""
    return _sampled(Quadtree.around(domain.bounds), spacing)


def _sampled(grid: Quadtree, spacing: Spacing) -> Samples:
    """Cells that reach into the domain, with samples of their own."""
    places = _places(grid, np.arange(len(grid)))
    d = spacing.extended(places.reshape(-1, 2)).reshape(places.shape[:2])
    return Samples(grid, np.ones(len(grid), bool), d)


def resolved(
    samples: Samples, domain: Domain, spacing: Spacing, sources: Sources, largest: Floats | float = np.inf
) -> Samples:
    """Cells split until they resolve the spacing, none is above ``largest`` (n,), and their sizes are balanced.

    Those of the given samples have to be balanced already.
    """
    key = samples.grid.cells.keys_of(sources.points)
    order = np.argsort(key, kind="stable")
    key, cells = key[order], np.append(sources.cells[order], np.inf)

    def coarse(some: Samples) -> Booleans:
        grid, sides = some.grid, _largest_sides(some, domain)
        begin, end = ranks(key, grid.key), ranks(key, grid.ends)
        held = np.flatnonzero(begin < end)
        if len(held):
            least = np.minimum.reduceat(cells, np.column_stack([begin, end])[held].ravel())[::2]
            sides[held] = np.minimum(sides[held], least)
        split = some.inside & grid.divisible & (grid.sides > sides)
        return split | (grid.sides > largest) if some is samples else split

    values, split = partial(_of_quarters, spacing=spacing), coarse(samples)
    if not split.any():  # balanced as it was
        return samples
    parts = [samples.select(~split), samples.quarters(split, domain, values).refined(domain, coarse, values)]
    for _ in range(SPLITS):
        needed = parts[-1].grid.unbalanced()  # only what is new may be too small for what is beside it
        large = [part.grid.among(needed) for part in parts]
        if not any(some.any() for some in large):
            break

        def larger(some: Samples, needed: Integers = needed) -> Booleans:
            return coarse(some) | some.grid.among(needed)

        fresh = Samples.merged([part.quarters(some, domain, values) for part, some in zip(parts, large, strict=True)])
        parts = [part.select(~some) if some.any() else part for part, some in zip(parts, large, strict=True)]
        parts.append(fresh.refined(domain, larger, values))
    return Samples.merged(parts)


def _largest_sides(samples: Samples, domain: Domain) -> Floats:
    """Largest sides (n,) of cells that resolve a spacing by itself."""
    return np.minimum(LARGEST_IN_SPACINGS * least_of_rows(samples.d), LARGEST_IN_DOMAIN * domain.size)


def surely_slow(domain: Domain, spacing: Spacing, growth: float) -> bool:
    """Whether the spacing grows by at most ``growth`` per length for sure, as most do that grow so slowly.

    Bounds of its function show that for large cells. Only cells without bounds, as around the root of zero, are
    sampled, and divided until they resolve the spacing, so that their samples show it.
    """
    grid = Quadtree.around(domain.bounds)
    for _ in range(GRID_LEVELS + 1):
        low = grid.centers - grid.sides[:, None] / 2
        bounds = bounds_of(spacing.function, low, low + grid.sides[:, None])
        if bounds is None:
            return False
        unsure = grid.select(~(bounds.steepest <= growth))
        if len(unsure) == 0:
            break
        if len(unsure) > MOST_UNSURE:
            return False
        samples = _sampled(unsure, spacing)
        if steepest(samples, domain, growth) is not None:
            return False
        large = unsure.divisible & (unsure.sides > _largest_sides(samples, domain))
        if not large.any():
            break
        # Three times at once: a look at more cells takes less time than two more looks.
        grid = unsure.select(large).quarters().quarters().quarters()
        grid = grid.select(domain.reaches(grid.centers, grid.sides * np.sqrt(0.5)))
    return True


def too_steep(samples: Samples, growth: float) -> Booleans:
    """Whether the spacing grows by more than ``growth`` per length, (n, 8), between the `PAIRS` of places of a cell."""
    limit, steep = growth * (1 + TOLERANCE), np.zeros((len(samples.d), len(PAIRS)), bool)
    # A quick look, which is generous: no pair is nearer than the centre and a corner.
    rise = largest_of_rows(samples.d) - least_of_rows(samples.d)
    may_be = np.flatnonzero(rise > NEAREST * limit * samples.grid.sides)
    steep[may_be] = _slopes(samples, may_be) > limit
    return steep


def steepest(samples: Samples, domain: Domain, growth: float) -> SteepestPlace | None:
    """Place where the spacing grows fastest between samples that lie in the domain, if faster than ``growth``."""
    cell, pair = np.nonzero(too_steep(samples, growth) & samples.inside[:, None])
    if len(cell) == 0:
        return None
    ends = _places(samples.grid, cell)[np.arange(len(cell))[:, None], PAIRS[pair]]
    real = domain.contains(ends[:, 0]) & domain.contains(ends[:, 1])
    cell, pair, ends = cell[real], pair[real], ends[real]
    if len(cell) == 0:
        return None
    slopes = _slopes(samples, cell)[np.arange(len(cell)), pair]
    k = slopes.argmax()
    d = samples.d[cell[k], PAIRS[pair[k]]]
    x, y = ends[k, d.argmin()].tolist()
    return SteepestPlace((x, y), float(d.min()), float(slopes[k]))


def _slopes(samples: Samples, cells: Integers) -> Floats:
    """Growth (k, 8) of the spacing per length between the `PAIRS` of places in some cells (k,)."""
    lengths = samples.grid.sides[cells, None] * np.hypot(*(PLACES[PAIRS[:, 1]] - PLACES[PAIRS[:, 0]]).T)
    d = taken(samples.d, cells)
    return np.asarray(np.abs(d[:, PAIRS[:, 1]] - d[:, PAIRS[:, 0]]) / lengths)


def _places(grid: Quadtree, cells: Integers) -> Floats:
    """Places (k, 5, 2) of samples in some cells: centre and corners."""
    return np.concatenate([grid.centers[cells, None], grid.corners(cells)], axis=1)


def _of_quarters(grid: Quadtree, whole: Floats, spacing: Spacing) -> Floats:
    """Spacing (4 k, 5) at the places in quarters of cells, from that at the places (k, 5) in the cells as wholes.

    It is asked for at the centres and where quarters meet: their other corners are those of the cells.
    """
    places = np.concatenate([grid.between_quarters(), grid.centers.reshape(-1, 4, 2)], axis=1)
    fresh = spacing.extended(places.reshape(-1, 2)).reshape(places.shape[:2])
    return np.concatenate([whole[:, 1:], fresh], axis=1).take(QUARTERS, axis=1).reshape(-1, len(PLACES))


def thin_walls(domain: Domain, spacing: Spacing, intervals: tuple[Integers, Floats, Floats]) -> tuple[Floats, Floats]:
    """Places (k, 2) on thin walls and in their middles, and sides (k,) of cells there that keep both sides apart.

    They are looked for from the middles of short ``intervals`` (see `short_intervals`). A wall is as thick as the
    largest disc that touches the boundary from outside, up to one as large as the domain.
    """
    boundary = domain.boundary
    piece, begin, length = intervals
    outer = ~boundary.inner[piece]
    piece, begin, length = piece[outer], begin[outer], length[outer]
    points, tangents = boundary.points(piece, begin + length / 2), boundary.tangents(piece, begin + length / 2)
    outward = -turned_left(tangents)  # the domain is on the left
    radius = np.minimum(WIDEST_WALL * spacing(points), domain.size)
    widest = radius.copy()
    tried, foot = np.arange(len(points)), np.full((len(points), 2), np.inf)
    while len(tried):
        centers = taken(points, tried) + radius[tried, None] * taken(outward, tried)
        depth = FITTING * radius[tried]
        # What was in the way of a disc twice as large often is in that of this one.
        unsure = np.flatnonzero(np.hypot(*(taken(foot, tried) - centers).T) >= depth)
        free, foot[tried[unsure]] = domain.deep_outside(taken(centers, unsure), depth[unsure])
        tried = np.delete(tried, unsure[free])
        radius[tried] /= 2
        tried = tried[radius[tried] > THINNEST_WALL * domain.size]
    thin = np.flatnonzero(radius < widest)
    radius = np.maximum(radius, length[thin].sum() / (WALL_CELL * MOST_WALL_PLACES))
    parts = np.ceil(length[thin] / (WALL_CELL * radius[thin])).astype(np.int64)
    wall, part = members(parts)
    mine = thin[wall]
    on_wall = boundary.points(piece[mine], begin[mine] + (part + 0.5) / parts[wall] * length[mine])
    within = on_wall + radius[mine, None] * outward[mine]
    return np.vstack([on_wall, within]), np.tile(WALL_CELL * radius[mine], 2)
