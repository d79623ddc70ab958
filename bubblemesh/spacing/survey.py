"""Survey of a spacing in a domain: its extremes, and the ideal number of nodes."""

from collections.abc import Callable
from dataclasses import field
from math import sqrt
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import LARGEST_NUMBER, Floats, Integers
from bubblemesh.errors import COARSEN, NODE_LIMIT, CaseError, NodeLimitError, at_key
from bubblemesh.geometry.domain import Domain
from bubblemesh.meshes.quality import doubled_areas
from bubblemesh.messages import place
from bubblemesh.records import record
from bubblemesh.spacing.cover import LARGEST_PART, Cover
from bubblemesh.spacing.integrals import IntegralParts, Intervals, Triangles
from bubblemesh.spacing.spacing import Spacing

TOLERANCE = 1e-3  # relative, of an integral
ESTIMATE = 0.05  # the same where it only limits and announces the number of nodes
SHARE = 1e-3  # of that: change on division below which a part of the integral stands
SETTLING = 0.1  # relative change of a part on division below which its size is believed
DIVISIONS = 60
LEFT = 1 / 3  # of the change on division: linear parts of half the size have a quarter of the error
NEGLIGIBLE = 1e-6  # nodes by which the integral of a part may change
MANY_TIMES = 4  # a limit: too many nodes even if much of the domain is left out later
MOST_PARTS = 500_000  # unsettled ones: a spacing that fine is noise, of which they are a fair sample
FEWEST = 3.0  # nodes of any ring and mesh, though the formulas give less where the spacing exceeds their size
VANISHING = 1e-9  # of the domain's size: a spacing that small is zero but for rounding
NEARLY_LEAST = 1e-4  # relative, above errors of distances: with that much at most, no search for a lower value is due
HALVINGS = 60  # of the reach of a search, at the most
RESOLVED = 1e-9  # reach, in terms of the spacing found, at which a search ends


Extreme = tuple[float, tuple[float, float]]  # a spacing, with its place


class Extremes(NamedTuple):
    """Least and largest spacing with their places (x, y)."""

    minimum: float
    minimum_at: tuple[float, float]
    maximum: float
    maximum_at: tuple[float, float]

    @property
    def both(self) -> tuple[Extreme, Extreme]:
        """The least and the largest one."""
        return (self.minimum, self.minimum_at), (self.maximum, self.maximum_at)


@record
class Survey:
    """Extremes of the spacing, and the ideal number of nodes."""

    extremes: Extremes
    ideal_nodes: float
    cover: Cover = field(repr=False, compare=False)  # of the domain, for surveys of other spacings


def surveyed(domain: Domain, spacing: Spacing, max_nodes: int, cover: Cover | None = None) -> Survey:
    """Survey of the spacing over the domain, of which several surveys may share the ``cover``.

    CaseError where the spacing is not positive and finite, with the point; LimitError if it needs more than
    ``max_nodes`` nodes.
    """
    cover = cover or Cover(domain)
    found = extremes(domain, spacing, cover)
    if found.minimum < VANISHING * min(domain.size, found.maximum):  # one that is small everywhere exceeds the limit
        with at_key(*spacing.keys(np.array([found.minimum_at]))[0]):
            where = f"falls to {found.minimum:.3g} at {place(found.minimum_at)}"
            raise CaseError(
                f"{where}: it has to be positive in the whole domain, and at least {VANISHING:g} of its size or of the "
                "largest spacing"
            )
    return Survey(found, ideal_nodes(domain, spacing, max_nodes, TOLERANCE, cover), cover)


def extremes(domain: Domain, spacing: Spacing, cover: Cover) -> Extremes:
    """Extremes of the spacing over the domain, on its ``cover``."""
    constant = _constant(domain, spacing)
    if constant is not None:
        x, y = domain.polygonal_copy.points[0].tolist()
        return Extremes(constant, (x, y), constant, (x, y))
    spots = spacing.spots[domain.contains(spacing.spots)]
    points = np.vstack([domain.polygonal_copy.points, cover.points, cover.corners.mean(axis=1), spots])
    d = spacing(points)
    x, y = points[d.argmax()]
    return Extremes(*_minimised(domain, spacing, points[d.argmin()]), float(d.max()), (float(x), float(y)))


def ideal_nodes(
    domain: Domain, spacing: Spacing, max_nodes: int, tolerance: float, cover: Cover | None = None
) -> float:
    """Number of nodes of a perfect packing.

    It is the sum of

    - the integral of 2 / (sqrt(3) d^2) over the area,
    - half the integral of 1 / d along the boundary, or half of three where that of a ring is less,
    - Euler's characteristic of the domain.

    The integrals are taken on a ``cover`` of the domain, with the relative accuracy ``tolerance``. LimitError if the
    number is more than ``max_nodes``.
    """
    ideal = _counted_nodes(domain, spacing, max_nodes, tolerance, cover or Cover(domain))
    if ideal > max_nodes:
        raise _too_many(ideal, max_nodes, spacing)
    return ideal


def require_not_many_times(domain: Domain, spacing: Spacing, max_nodes: int) -> None:
    """Check that a spacing needs no more than some times ``max_nodes`` where it is defined; LimitError if it does.

    This is for domains of which a part may be left out later.
    """

    def known(x: Floats, y: Floats) -> Floats:
        d = spacing.anywhere(np.column_stack([x, y]))
        return np.where(np.isnan(d), LARGEST_NUMBER, d)

    many = MANY_TIMES * max_nodes
    needed = _counted_nodes(domain, Spacing(known), many, ESTIMATE, Cover(domain))
    if needed > many:
        raise _too_many(needed, max_nodes, spacing)


def _counted_nodes(domain: Domain, spacing: Spacing, enough: int, tolerance: float, cover: Cover) -> float:
    """Number of nodes as of `ideal_nodes`, or a lower one where that is clearly more than ``enough``."""
    constant = _constant(domain, spacing)
    if constant is not None:
        over_area = 2 / sqrt(3) * float(domain.polygon.area) / constant / constant
        if over_area > 2 * enough:
            return over_area
        piece = np.flatnonzero(~domain.boundary.inner)
        on_pieces = domain.boundary.lengths[piece] / (2 * constant)
        return _total(domain, over_area, float(on_pieces.sum()), piece, on_pieces)
    over_area = _integral(Triangles.of(cover, spacing), tolerance, enough)
    if over_area > 2 * enough:
        return over_area
    intervals = Intervals.of(cover, spacing, domain.boundary)
    along = _integral(intervals, tolerance, enough)
    if along > 2 * enough:
        return along
    return _total(domain, over_area, along, intervals.piece, intervals.nodes())


def _constant(domain: Domain, spacing: Spacing) -> float | None:
    """The value of a spacing that surely is the same in the whole domain, and no wrong one; None if it may not be."""
    bounds = None if spacing.in_metric else spacing.bounds_in(domain.bounds)
    if bounds is None:
        return None
    low, high = float(np.min(bounds.low)), float(np.max(bounds.high))
    return low if low == high and 0 < low <= LARGEST_NUMBER else None


def _total(domain: Domain, over_area: float, along: float, piece: Integers, on_pieces: Floats) -> float:
    """Number of nodes by both integrals, that along the boundary also ``on_pieces`` (k,) or parts of them."""
    lacking = _lacking(domain.boundary.ring[piece], on_pieces)
    return max(over_area + along + lacking + domain.euler_characteristic, FEWEST)


def _lacking(ring: Integers, nodes: Floats) -> float:
    """What the integrals along rings are below half of the fewest nodes, by the ring (k,) and ``nodes`` (k,) of parts.

    A hole takes one node off the number. Without this many that are small beside the spacing would take all of them.
    """
    return float(np.maximum(FEWEST / 2 - np.bincount(ring, nodes), 0).sum())


def rough_nodes(domain: Domain) -> Callable[[Spacing], float]:
    """About as many nodes as a perfect packing has, for many spacings: by the same few points for each of them."""
    cover = Cover(domain)
    corners, (piece, begin, end) = cover.corners, cover.intervals.T
    middles = corners.mean(axis=1)
    piece = piece.astype(np.int64)
    ring, sides = domain.boundary.ring[piece], domain.boundary.points(piece, (begin + end) / 2)
    weight, lengths = np.abs(doubled_areas(corners)) / np.sqrt(3), end - begin

    def count(spacing: Spacing) -> float:
        inverse = 1 / spacing(np.vstack([middles, sides]))
        over_area, along = weight @ inverse[: len(weight)] ** 2, lengths @ inverse[len(weight) :] / 2
        lacking = _lacking(ring, lengths * inverse[len(weight) :] / 2)
        return max(float(over_area + along) + lacking + domain.euler_characteristic, FEWEST)

    return count


def _integral(parts: IntegralParts, tolerance: float, enough: int) -> float:
    """Sum of the nodes on ``parts``, dividing those whose number changes by that, as measured by the sum.

    It ends early where these are clearly more than ``enough``. Only parts that have settled are sure: next to a
    spot of small spacing the number on a large part comes out far too large.
    """
    total, coarse = 0.0, parts.nodes()
    for _ in range(DIVISIONS):
        parts = parts.divided()
        fine = parts.nodes().reshape(-1, len(coarse))
        both = fine.sum(axis=0)
        change = np.subtract(both, coarse, out=np.zeros_like(both), where=both < np.inf)  # of infinite ones none
        settling = total + float(both[np.abs(change) < SETTLING * both].sum())
        unsure = np.abs(change) > max(SHARE * tolerance * settling, NEGLIGIBLE)
        total += float((both + LEFT * change)[~unsure].sum())
        parts, coarse = parts.select(np.tile(unsure, len(fine))), fine[:, unsure].ravel()
        if total > 2 * enough or len(coarse) == 0 or len(coarse) > MOST_PARTS:
            break
    return total + float(coarse.sum())


def _too_many(needed: float, max_nodes: int, spacing: Spacing) -> NodeLimitError:
    many = f"about {needed:.3g} nodes" if np.isfinite(needed) else "more nodes than can be counted"
    return NodeLimitError(
        f"{NODE_LIMIT}: {spacing.noun} needs {many}, more than the limit of {max_nodes}: {COARSEN} or raise the limit",
        spacing.noun,
    )


def _minimised(domain: Domain, spacing: Spacing, start: Floats) -> tuple[float, tuple[float, float]]:
    """Local minimum of the spacing next to ``start`` (2,), by a pattern search on shrinking grids."""
    steps = np.linspace(-1, 1, 9)
    grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    best, value = start, float(spacing(start[None])[0])
    bounds = spacing.bounds_in(domain.bounds)
    if bounds is not None and np.all(bounds.low >= (1 - NEARLY_LEAST) * value):  # as on what it grows from
        return value, (float(best[0]), float(best[1]))
    reach = LARGEST_PART * domain.size
    for _ in range(HALVINGS):
        around = best + reach * grid
        # Few places have less, and only of these it matters whether they lie in the domain.
        d = spacing.anywhere(around)
        less = np.flatnonzero(~(d >= value))
        less = less[domain.contains(around[less])]
        if len(less):
            k = less[d[less].argmin()]  # the first one that has no spacing, if any
            best, value = around[k], float(d[k] if d[k] > 0 else spacing(around[k : k + 1])[0])
        reach /= 2
        if reach < RESOLVED * value:
            break
    return value, (float(best[0]), float(best[1]))
