"""The spacing in the metrics of a problem: below a spacing, graded, and with warnings."""

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import CaseError, Key, at_key
from bubblemesh.geometry.arrangement import TOUCHING
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.periodic import counterparts
from bubblemesh.kernels.tensors import intersections
from bubblemesh.meshes.tensors import (
    Axes,
    area_sizes,
    axes,
    require_positive_definite,
    size_ratios,
    turned,
)
from bubblemesh.messages import place, two_places
from bubblemesh.problem.ellipses import Scaled
from bubblemesh.problem.metric import MetricRequest
from bubblemesh.records import record
from bubblemesh.spacing.cover import Cover
from bubblemesh.spacing.metric.field import TensorField
from bubblemesh.spacing.metric.gradation import graded
from bubblemesh.spacing.metric.metric import EllipsesAt, MetricSpacing
from bubblemesh.spacing.metric.short_edges import BesideEdges
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.survey import ESTIMATE, Survey, ideal_nodes, surveyed

ANY_SIGN = "angle", "m12"  # numbers of a metric that may be negative
STATIONS, DIFFERENT = 17, 1.5  # places looked at on periodic sides, and times that a size may differ there
EXCEEDED = 1.001  # of the largest aspect: a larger one has a warning
LARGER = 1.1  # times: the most that sizes grow to save the nodes that shorter ellipses take
SAVED = 0.7  # share of these nodes, on a logarithmic scale
GRADINGS, SAME_SIZES = 5, 1.2  # one after the other, at most, and times that sizes may differ in the end
MANY_MORE = 2.0  # times as many nodes by a gradation have a warning


class InMetric(NamedTuple):
    """Metrics of a problem, the spacing in them that is asked for, what is known of it, and warnings."""

    metrics: tuple[MetricRequest, ...]  # with a gradation one, that is graded: what is packed is nowhere coarser
    requested: MetricSpacing
    survey: Survey
    warnings: tuple[str, ...]

    def packing(
        self, domain: Domain, spacing: Spacing, max_nodes: int, short: tuple[Spacing, Floats] | None = None
    ) -> MetricSpacing:
        """The spacing in the metrics for a packing of a domain, below one that is as fine as its boundary needs.

        Beside ``short`` edges, which have a limit and their ends (k, 2, 2), it is finer. Where straight edges cannot
        follow it ellipses are shorter, and none is longer than the domain.
        """
        ellipses: EllipsesAt = Intersection(self.metrics, spacing, domain.size)
        ellipses = ellipses if short is None else BesideEdges(ellipses, *short)
        bent = MetricSpacing.of(ellipses, self.requested.aspect)
        return _with_fewer_nodes(bent.straightened(), bent, domain, max_nodes)


def spacing_in_metrics(
    domain: Domain, metrics: Sequence[MetricRequest], spacing: Spacing, max_nodes: int, cover: Cover
) -> InMetric:
    """The spacing in metrics and below the given one.

    CaseError where a metric is not positive, with its key and the place; LimitError if there would be more than
    ``max_nodes`` nodes.
    """
    points = np.vstack([domain.polygonal_copy.points, cover.points, cover.corners.mean(axis=1)])
    _require_metrics(metrics, points)
    too_long = tuple(_too_long(metrics, spacing, points))
    requested = metric_below(metrics, spacing)
    survey = surveyed(domain, requested, max_nodes, cover)
    idle = tuple(_without_effect(metrics, spacing, np.vstack([points, survey.extremes.minimum_at])))
    aspect = _aspect(requested, np.vstack([points, survey.extremes.minimum_at]))
    requested = replace(requested, aspect=aspect)
    graded_one, costly = _graded(domain, requested, metrics, max_nodes), tuple[str, ...]()
    if graded_one is not requested:
        before, requested, survey = survey, graded_one, surveyed(domain, graded_one, max_nodes, cover)
        costly = tuple(_costly_gradation(before.ideal_nodes, survey.ideal_nodes))
        metrics = [MetricRequest(requested.ellipses, np.inf, Key(["metric"]))]
    told = (*too_long, *idle, *costly, *_differing_sides(domain, requested))
    return InMetric(tuple(metrics), requested, survey, told)


def metric_below(metrics: Sequence[MetricRequest], spacing: Spacing) -> MetricSpacing:
    """The spacing in metrics, which is nowhere above the given one."""
    return MetricSpacing.of(Intersection(tuple(metrics), spacing))


@record
class Intersection:
    """The intersection of metrics, their aspects limited, with circles of a spacing, and of a largest size."""

    metrics: tuple[MetricRequest, ...]
    spacing: Spacing
    largest: float = np.inf

    def __call__(self, x: Floats, y: Floats) -> Axes:
        """Axes of the ellipses at x (n,) and y (n,)."""
        d = self._limits(np.column_stack([x, y])) if self._limit is None else self._limit
        if not self.metrics:
            d = np.broadcast_to(d, len(x))
            return Axes(d, d, np.column_stack([np.ones(len(d)), np.zeros(len(d))]))
        first, *others = (metric.ellipses(x, y).within(d).wider(metric.aspect) for metric in self.metrics)
        for other in others:
            first = axes(intersections(first.tensors, other.tensors))
        return first

    def _limits(self, points: Floats) -> Floats:
        """Largest sizes (n,) at points (n, 2)."""
        return np.minimum(self.spacing.extended(points), self.largest)

    @cached_property
    def _limit(self) -> float | None:
        """The largest size, if it is the same everywhere: most metrics have no more than that."""
        return float(self._limits(np.zeros((1, 2)))[0]) if self.spacing.is_uniform else None


def _with_fewer_nodes(straight: MetricSpacing, bent: MetricSpacing, domain: Domain, max_nodes: int) -> MetricSpacing:
    """A straightened metric with larger sizes: most of the nodes that it takes beyond the bent one are saved.

    Sizes grow by 10 % at most: a metric that is impossible in most of the domain takes more nodes.
    """
    cover = Cover(domain)
    nodes, fewer = (ideal_nodes(domain, spacing, max_nodes, ESTIMATE, cover) for spacing in (straight, bent))
    scale = min((nodes / fewer) ** (SAVED / 2), LARGER)
    return straight if scale <= 1 else MetricSpacing.of(Scaled(straight.ellipses, scale), straight.aspect, bent)


def _graded(domain: Domain, spacing: MetricSpacing, metrics: Sequence[MetricRequest], max_nodes: int) -> MetricSpacing:
    """The spacing in metrics that grow between nodes no faster than their gradation, if they have one.

    The nodes are those of a mesh in the metric, as dense as that varies. Where it jumps these are too few: then come
    those of a mesh in what was graded by them, until that changes no more.
    """
    growth = min((metric.gradation for metric in metrics), default=np.inf)
    if growth == np.inf:
        return spacing
    # Imported here since few metrics are graded.
    from bubblemesh.packing.ellipses.annealing import NoEllipseAnnealing
    from bubblemesh.packing.ellipses.smoothing import NoEllipseSmoothing
    from bubblemesh.packing.methods import ELLIPSES
    from bubblemesh.packing.rounds import rounds

    # Tensors are interpolated between the nodes, and for that these need not be in order.
    method = replace(ELLIPSES, annealing=NoEllipseAnnealing(), smoothing=NoEllipseSmoothing())
    result, cover = spacing, Cover(domain)
    for _ in range(GRADINGS):
        ideal_nodes(domain, result, max_nodes, ESTIMATE, cover)  # so that too many are told before they are packed
        levels, start = method.started(domain, result, 0, max_nodes)
        (last,) = deque(rounds(start, domain, levels, method), maxlen=1)
        x, triangles = last.net.bubbles.x, last.net.triangles
        before, tensors = result(x), graded(x, triangles, spacing.at(x), growth)
        result = MetricSpacing.of(TensorField.of(x, triangles, tensors), spacing.aspect)
        if (before <= SAME_SIZES * area_sizes(tensors)).all():
            break
    return result


def _costly_gradation(before: float, after: float) -> Iterator[str]:
    """Warning of a gradation that takes many times the nodes of the metric alone."""
    if after > MANY_MORE * before:
        yield (
            f"metric: it changes so fast that gradation takes about {after:.0f} nodes in place of {before:.0f}: "
            "a larger gradation takes fewer"
        )


def _differing_sides(domain: Domain, spacing: MetricSpacing) -> Iterator[str]:
    """Warning of a metric that differs between periodic sides."""
    boundary, pairs = domain.boundary, domain.periodic
    if len(pairs) == 0:
        return
    piece = np.repeat(pairs[:, 0], STATIONS)
    share = np.tile(np.linspace(0, 1, STATIONS), len(pairs))
    s = share * boundary.lengths[piece]
    mine, other, at = counterparts(boundary, pairs, piece, s)
    here, there = boundary.points(piece[mine], s[mine]), boundary.points(other, at)
    # About the tip of a wedge, its own counterpart, all but circles differ.
    apart = np.hypot(*(there - here).T) > TOUCHING * domain.size
    here, there, turn = here[apart], there[apart], domain.turn[piece[mine[apart]]]
    times = size_ratios(turned(spacing.checked(here), turn), spacing.checked(there))
    k = int(times.argmax())
    if times[k] > DIFFERENT:
        first, second = two_places(here[k], there[k])
        yield (
            f"metric: its sizes in one direction differ {times[k]:.3g} times between periodic sides, at {first} and "
            f"{second}: nodes there follow the smaller ones, and sizes jump beside the other side: make the metric the "
            "same on both"
        )


def _aspect(spacing: MetricSpacing, points: Floats) -> float:
    """Largest aspect at points (n, 2)."""
    return float(spacing.axes(points).aspects.max())


def _require_metrics(metrics: Sequence[MetricRequest], points: Floats) -> None:
    """Check metrics, and the numbers of which they are made, at points (n, 2); CaseError with key, value and place."""
    for metric in metrics:
        for name, number in metric.numbers.items():
            values = number(*points.T)
            good = np.isfinite(values) & ((values > 0) | (name in ANY_SIGN))
            if not good.all():
                k = int(good.argmin())
                allowed = "a finite number" if name in ANY_SIGN else "positive and finite"
                with at_key(*metric.key, name):
                    raise CaseError(
                        f"is {values[k]:g} at {place(points[k])}: it has to be {allowed} in the whole domain"
                    )
        with at_key(*metric.key):
            require_positive_definite(metric.ellipses(*points.T).diameters, lambda k: points[k])


def _too_long(metrics: Sequence[MetricRequest], spacing: Spacing, points: Floats) -> Iterator[str]:
    """Warnings of metrics whose ellipses are longer than their aspect allows at points (n, 2)."""
    for metric in metrics:
        aspects = metric.ellipses(*points.T).within(spacing.extended(points)).aspects
        k = int(np.where(np.isnan(aspects), 0.0, aspects).argmax())
        if aspects[k] > EXCEEDED * metric.aspect:
            longest = min(aspects[k], np.finfo(float).max)  # of sizes that are all but zero the ratio is infinite
            yield (
                f"{metric.key}: the ellipses are up to {longest:.4g} times as long as wide, at {place(points[k])}: "
                f"they are made wider than that, {metric.aspect:g} times at most; aspect raises it"
            )


def _without_effect(metrics: Sequence[MetricRequest], spacing: Spacing, points: Floats) -> Iterator[str]:
    """Warnings of metrics that are nowhere finer than the spacing, as those in other units than the domain."""
    d = spacing.extended(points)
    for metric in metrics:
        across = metric.ellipses(*points.T).across
        if (across > d).all():
            k = int((across / d).argmin())
            yield (
                f"{metric.key}: its least size is {across[k]:.3g} where the spacing is {d[k]:.3g}, at "
                f"{place(points[k])}, and it is nowhere below that: without any effect; is it in the units of the "
                "domain?"
            )
