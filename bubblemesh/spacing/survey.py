"""Survey of a spacing in a domain: its extremes, and the ideal number of nodes."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple, TypeVar

import numpy as np

from bubblemesh.arrays import GAUSS, Floats, Integers, different_rows, members, select, taken
from bubblemesh.errors import CaseError, LimitError, at_key
from bubblemesh.geometry.domain import Domain
from bubblemesh.meshes.quality import doubled_areas
from bubblemesh.meshes.triangulation import triangulated
from bubblemesh.messages import node_limit, place
from bubblemesh.spacing.spacing import Spacing

Parts = TypeVar("Parts", "Triangles", "Intervals")

LARGEST_PART = 1 / 32  # of the domain's size: parts that large are halved before they are trusted
TOLERANCE = 1e-3  # relative, of an integral
ESTIMATE = 0.05  # the same where it only limits and announces the number of nodes
SHARE = 1e-3  # of that: change on halving below which a part of the integral stands
SETTLING = 0.1  # relative change of a part on halving below which its size is believed
HALVINGS = 60
NEGLIGIBLE = 1e-6  # nodes by which the integral of a part may change
MOST_PARTS = 1_000_000  # unsettled ones: a spacing that fine is noise, of which they are a fair sample
FEWEST = 3.0  # nodes of any mesh, though the formula may give less where the spacing exceeds the domain
VANISHING = 1e-9  # of the domain's size: a spacing that small is zero but for rounding


class Cover(NamedTuple):
    """Parts of a domain that are up to a fraction of its size, over which spacings are looked at."""

    triangles: Floats  # (t, 3, 2): they cover the domain
    intervals: Floats  # (k, 3): piece, begin and end arc length of parts of the boundary but for its inner pieces

    @classmethod
    def of(cls, domain: Domain) -> "Cover":
        """Cover of a domain; inner pieces lie in the area and count there."""
        return cls(_triangles(domain), _intervals(domain))


class Triangles(NamedTuple):
    """Triangles with the spacing on their edges."""

    corners: Floats  # (t, 3, 2)
    d: Floats  # (t, 3): at the middles of the edges from each corner to the next


class Intervals(NamedTuple):
    """Parts of the boundary with the spacing on them."""

    ends: Floats  # (k, 3): piece, begin and end arc length
    d: Floats  # (k, 2): at the places of the Gauss rule


class Extremes(NamedTuple):
    """Least and largest spacing with their places (x, y)."""

    minimum: float
    minimum_at: tuple[float, float]
    maximum: float
    maximum_at: tuple[float, float]


@dataclass(frozen=True)
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
    cover = cover or Cover.of(domain)
    found = extremes(domain, spacing, cover)
    if found.minimum < VANISHING * min(domain.size, found.maximum):  # one that is small everywhere exceeds the limit
        with at_key(*spacing.keys(np.array([found.minimum_at]))[0]):
            raise CaseError(
                f"falls to {found.minimum:.3g} at {place(found.minimum_at)}: it has to be positive in the whole domain"
            )
    return Survey(found, ideal_nodes(domain, spacing, max_nodes, TOLERANCE, cover), cover)


def extremes(domain: Domain, spacing: Spacing, cover: Cover) -> Extremes:
    """Extremes of the spacing over the domain, on its ``cover``."""
    triangles = cover.triangles
    spots = spacing.spots[domain.contains(spacing.spots)]
    points = np.vstack([domain.polygonal_copy.points, triangles.reshape(-1, 2), triangles.mean(axis=1), spots])
    d = spacing(points)
    x, y = points[d.argmax()]
    return Extremes(*_minimised(domain, spacing, points[d.argmin()]), float(d.max()), (float(x), float(y)))


def ideal_nodes(
    domain: Domain, spacing: Spacing, max_nodes: int, tolerance: float, cover: Cover | None = None
) -> float:
    """Number of nodes of a perfect packing.

    It is the integral of 2 / (sqrt(3) d^2) over the area, plus half the integral of 1 / d along the boundary, plus the
    number of separate areas, minus that of holes; ``tolerance`` is the relative accuracy of the integrals, which are
    taken on a ``cover`` of the domain. LimitError if it is more than ``max_nodes``.
    """
    cover, limits = cover or Cover.of(domain), (tolerance, max_nodes)
    triangles, intervals = _sampled_triangles(cover.triangles, spacing), _sampled(cover.intervals, domain, spacing)
    over_area = _integral(triangles, _over_triangles, lambda some: _halves(some, spacing), *limits)
    along = _integral(
        intervals, _over_intervals, lambda some: _sampled(_halved_intervals(some.ends), domain, spacing), *limits
    )
    ideal = max(over_area + along + domain.piece_count - domain.hole_count, FEWEST)
    if ideal > max_nodes:
        raise _too_many(ideal, max_nodes)
    return ideal


def rough_nodes(domain: Domain) -> Callable[[Spacing], float]:
    """About as many nodes as a perfect packing has, for many spacings: by the same few points for each of them."""
    triangles, intervals = Cover.of(domain)
    middles, piece = triangles.mean(axis=1), intervals[:, 0].astype(np.int64)
    sides = domain.boundary.points(piece, intervals[:, 1:].mean(axis=1))
    weight, lengths = np.abs(doubled_areas(triangles)) / np.sqrt(3), intervals[:, 2] - intervals[:, 1]

    def count(spacing: Spacing) -> float:
        inverse = 1 / spacing(np.vstack([middles, sides]))
        over_area, along = weight @ inverse[: len(weight)] ** 2, lengths @ inverse[len(weight) :] / 2
        return max(float(over_area + along) + domain.piece_count - domain.hole_count, FEWEST)

    return count


def _integral(
    parts: Parts,
    over: Callable[[Parts], Floats],
    halved: Callable[[Parts], Parts],
    tolerance: float,
    max_nodes: int,
) -> float:
    """Sum of the integrals over ``parts``, halving those whose integral changes by that, as measured by the sum.

    It counts nodes, and is given up where these are clearly more than ``max_nodes``. Only parts that have settled are
    sure: next to a spot of small spacing the integral of a large part comes out far too large.
    """
    total, coarse = 0.0, over(parts)
    for _ in range(HALVINGS):
        halves = halved(parts)
        fine = over(halves).reshape(2, -1)
        both = fine.sum(axis=0)
        with np.errstate(invalid="ignore"):  # of what is infinite nothing is unsure
            change = np.abs(both - coarse)
        settling = total + float(both[change < SETTLING * both].sum())
        unsure = change > max(SHARE * tolerance * settling, NEGLIGIBLE)
        total += float(both[~unsure].sum())
        parts, coarse = select(halves, np.tile(unsure, 2)), fine[:, unsure].ravel()
        if total > 2 * max_nodes:
            raise _too_many(total + float(coarse.sum()), max_nodes)
        if len(coarse) == 0 or len(coarse) > MOST_PARTS:
            break
    return total + float(coarse.sum())


def _too_many(needed: float, max_nodes: int) -> LimitError:
    return LimitError(
        f"{node_limit()}: the spacing needs about {needed:.3g} nodes, more than the limit of {max_nodes}: "
        "coarsen the spacing or raise the limit"
    )


def _triangles(domain: Domain) -> Floats:
    """Triangles (t, 3, 2) that cover the domain, with edges up to a fraction of its size."""
    longest = LARGEST_PART * domain.size
    outline, edges = _outline(domain, longest)
    points = np.vstack([outline, _lattice(domain, 0.99 * longest)])
    triangles = taken(points, triangulated(points, edges))
    return _refined(triangles, lambda t: _cut(t, _from_longest(t)), lambda t: _edge_lengths(t).max(axis=1), longest)


def _outline(domain: Domain, longest: float) -> tuple[Floats, Integers]:
    """Points (m, 2) along the boundary, and edges (e, 2) between them that are no longer than ``longest``."""
    line = domain.polygonal_copy
    corners, number = different_rows(line.points)
    begin, end = number, number[line.successor]
    parts = np.ceil(np.hypot(*(corners[end] - corners[begin]).T) / longest).astype(np.int64)
    chord, rank = members(parts)
    inner = rank > 0
    share = (rank / parts[chord])[inner, None]
    between = corners[begin[chord[inner]]] * (1 - share) + corners[end[chord[inner]]] * share
    first = np.where(inner, len(corners) + np.cumsum(inner) - 1, begin[chord])
    last = np.where(rank + 1 < parts[chord], np.roll(first, -1), end[chord])
    return np.vstack([corners, between]), np.column_stack([first, last])


def _lattice(domain: Domain, step: float) -> Floats:
    """Points (m, 2) of a hexagonal lattice inside; without them triangles would reach from wall to wall."""
    x0, y0, x1, y1 = domain.bounds
    i, j = np.meshgrid(np.arange(int((x1 - x0) / step) + 2), np.arange(int((y1 - y0) / (step * np.sqrt(0.75))) + 1))
    points = np.column_stack([x0 + step * (i + j % 2 / 2).ravel(), y0 + step * np.sqrt(0.75) * (j + 0.5).ravel()])
    return points[domain.surely_inside(points, np.full(len(points), step / 2))]


def _intervals(domain: Domain) -> Floats:
    """Boundary intervals (k, 3) as piece, begin and end arc length, without inner pieces."""
    piece = np.flatnonzero(~domain.boundary.inner)
    whole = np.column_stack([piece, np.zeros(len(piece)), domain.boundary.lengths[piece]])
    return _refined(whole, _halved_intervals, lambda p: p[:, 2] - p[:, 1], LARGEST_PART * domain.size)


def _refined(
    parts: Floats, halved: Callable[[Floats], Floats], lengths: Callable[[Floats], Floats], longest: float
) -> Floats:
    done = []
    while len(parts):
        short = lengths(parts) <= longest
        done.append(taken(parts, short))
        parts = halved(parts[~short])
    return np.concatenate(done)


def _edge_lengths(triangles: Floats) -> Floats:
    """Lengths (t, 3) of the edges from each corner to the next."""
    delta = triangles - np.roll(triangles, -1, axis=1)
    return np.hypot(delta[..., 0], delta[..., 1])


def _cut(triangles: Floats, order: Integers) -> Floats:
    """Halves (2 t, 3, 2) of triangles cut across their first edge in an order (t, 3), all first halves first."""
    rows = np.arange(len(triangles))
    a, b, c = (triangles[rows, corner] for corner in order.T)
    middle = (a + b) / 2
    return np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])


def _from_longest(triangles: Floats) -> Integers:
    """Numbers (t, 3) of the corners of triangles, in turn from where the longest edge begins."""
    return (_edge_lengths(triangles).argmax(axis=1)[:, None] + np.arange(3)) % 3


def _sampled_triangles(triangles: Floats, spacing: Spacing) -> Triangles:
    """Triangles (t, 3, 2) with the spacing on their edges."""
    middles = (triangles + np.roll(triangles, -1, axis=1)) / 2
    return Triangles(triangles, spacing(middles.reshape(-1, 2)).reshape(-1, 3))


def _halves(whole: Triangles, spacing: Spacing) -> Triangles:
    """Halves of triangles cut across their longest edge: they have two edges of the whole ones, and one in common."""
    order = _from_longest(whole.corners)
    corners = _cut(whole.corners, order)
    first, second = np.split(corners, 2)
    fresh = np.stack([first[:, 0] + first[:, 1], first[:, 1] + first[:, 2], second[:, 0] + second[:, 1]]) / 2
    cut_1, common, cut_2 = spacing(fresh.reshape(-1, 2)).reshape(3, -1)
    _, onwards, back = np.take_along_axis(whole.d, order, axis=1).T
    d = [np.stack([cut_1, common, back], axis=1), np.stack([cut_2, onwards, common], axis=1)]
    return Triangles(corners, np.concatenate(d))


def _over_triangles(triangles: Triangles) -> Floats:
    """Integrals (t,) of 2 / (sqrt(3) d^2), by the midpoints of the edges (exact to second order)."""
    with np.errstate(over="ignore", divide="ignore"):  # no nodes, or more than any limit
        return np.abs(doubled_areas(triangles.corners)) / np.sqrt(3) * (1 / triangles.d**2).mean(axis=1)


def _halved_intervals(intervals: Floats) -> Floats:
    piece, begin, end = intervals.T
    middle = (begin + end) / 2
    return np.concatenate([np.column_stack([piece, begin, middle]), np.column_stack([piece, middle, end])])


def _sampled(intervals: Floats, domain: Domain, spacing: Spacing) -> Intervals:
    """Boundary intervals (k, 3) with the spacing at their two Gauss points."""
    piece: Integers = intervals[:, 0].astype(np.int64)
    begin, end = intervals[:, 1], intervals[:, 2]
    d = [spacing.along(domain.boundary, piece, begin + t * (end - begin)) for t in GAUSS]
    return Intervals(intervals, np.stack(d, axis=1))


def _over_intervals(intervals: Intervals) -> Floats:
    """Integrals (k,) of 1 / (2 d) along boundary intervals."""
    _, begin, end = intervals.ends.T
    inverse = 1 / intervals.d
    return (end - begin) * (inverse[:, 0] + inverse[:, 1]) / 4


def _minimised(domain: Domain, spacing: Spacing, start: Floats) -> tuple[float, tuple[float, float]]:
    """Local minimum of the spacing next to ``start`` (2,), by a pattern search on shrinking grids."""
    steps = np.linspace(-1, 1, 9)
    grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    best, value = start, float(spacing(start[None])[0])
    reach = LARGEST_PART * domain.size
    for _ in range(HALVINGS):
        around = best + reach * grid
        around = around[domain.contains(around)]
        if len(around):
            d = spacing(around)
            if d.min() < value:
                best, value = around[d.argmin()], float(d.min())
        reach /= 2
    return value, (float(best[0]), float(best[1]))
