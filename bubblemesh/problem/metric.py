"""Metrics of a case, bound to its domain, and the spacing in them."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.case.data_terms import several
from bubblemesh.case.metric import AnyMetric, DirectedMetric, TensorMetric, WallMetric
from bubblemesh.errors import Key, at_key
from bubblemesh.geometry.distance.distances import distance_to_labels, require_labels
from bubblemesh.geometry.domain import Domain
from bubblemesh.messages import place
from bubblemesh.spacing.expression import Expression
from bubblemesh.spacing.metric.metric import MetricSpacing, Tensors
from bubblemesh.spacing.metric.tensors import axes, intersections, of_axes
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.survey import ESTIMATE, Cover, Survey, ideal_nodes, surveyed

Value = float | Expression
Number = Callable[[Floats, Floats], Floats]  # (n,) at x (n,) and y (n,)

CLOSE = 1e-9  # of the domain's size: at a wall the direction is that of its tangent
TOLD = 1.001  # of the largest aspect: what is more of it is told
ROUNDING = 1e-12  # of a determinant, of a metric that asks for a size across only
INFINITE = 1e100  # size that asks for nothing


class MetricRequest(NamedTuple):
    """A metric of a case: its tensors, and the largest aspect of its ellipses, with the key of the case."""

    tensors: Tensors  # not positive where there is no metric
    aspect: float
    key: Key


class InMetric(NamedTuple):
    """The spacings of a problem in a metric: asked for and for the packing, what is known of them, and warnings."""

    asked: MetricSpacing
    packing: MetricSpacing
    survey: Survey
    expected_nodes: float
    warnings: tuple[str, ...]


def metric_requests(metric: AnyMetric | tuple[AnyMetric, ...], domain: Domain) -> tuple[MetricRequest, ...]:
    """The metrics of a case in a domain; CaseError, with the key, for labels that the domain has not."""
    models: tuple[AnyMetric, ...] = several(metric)
    return tuple(
        _request(model, domain, Key(["metric", *([number] if len(models) > 1 else [])]))
        for number, model in enumerate(models)
    )


def _request(model: AnyMetric, domain: Domain, key: Key) -> MetricRequest:
    def number(name: str) -> Number:
        value = getattr(model, name)
        with at_key(*key, name):
            expression = value if isinstance(value, Expression) else Expression.parse(repr(float(value)))
            return expression.measuring(partial(distance_to_labels, domain))

    along = None if isinstance(model, TensorMetric) or model.along is None else number("along")
    tensors: Tensors
    match model:
        case DirectedMetric():
            tensors = Directed(number("angle"), number("across"), along)
        case TensorMetric():
            tensors = Entries(number("m11"), number("m12"), number("m22"))
        case WallMetric():
            labels = several(model.label)
            with at_key(*key, "label"):
                require_labels(domain, labels)
            tensors = AlongWalls(domain, tuple(labels), model.across, model.growth, along)
    return MetricRequest(tensors, model.aspect, key)


@dataclass(frozen=True)
class Directed:
    """Tensors of sizes across and along a direction, given by its angle."""

    angle: Number
    across: Number
    along: Number | None

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Tensors (n, 3) at x (n,) and y (n,)."""
        angle, across = self.angle(x, y), self.across(x, y)
        along = np.full(len(x), INFINITE) if self.along is None else self.along(x, y)
        tensors = of_axes(across, along, np.column_stack([np.cos(angle), np.sin(angle)]))
        return np.where(((across > 0) & (along > 0))[:, None], tensors, np.nan)


@dataclass(frozen=True)
class Entries:
    """Tensors given by their entries."""

    m11: Number
    m12: Number
    m22: Number

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Tensors (n, 3) at x (n,) and y (n,)."""
        return np.column_stack([self.m11(x, y), self.m12(x, y), self.m22(x, y)])


@dataclass(frozen=True)
class AlongWalls:
    """Tensors of ellipses that lie along the nearest of some walls, whose size across grows away from there."""

    domain: Domain
    labels: tuple[str, ...]
    across: float
    growth: float
    along: Number | None

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Tensors (n, 3) at x (n,) and y (n,)."""
        points = np.column_stack([x, y])
        nearest = self.domain.nearest_with(points, *self.labels)
        away = points - nearest.foot
        at_wall = nearest.distance <= CLOSE * self.domain.size
        direction = np.column_stack([-away[:, 1], away[:, 0]]) / np.where(at_wall, 1.0, nearest.distance)[:, None]
        on = at_wall & (nearest.piece >= 0)
        direction[on] = self.domain.boundary.tangents(nearest.piece[on], nearest.s[on])
        along = np.full(len(x), INFINITE) if self.along is None else self.along(x, y)
        across = np.minimum(self.across + self.growth * nearest.distance, along)
        return of_axes(across, along, direction)


def in_metric(
    domain: Domain, metrics: Sequence[MetricRequest], spacing: Spacing, packing: Spacing, max_nodes: int, cover: Cover
) -> InMetric:
    """The spacings in metrics and below the given ones: ``packing`` is the finer one that the boundary needs.

    CaseError where a metric is not positive, with the place; LimitError if there would be more than ``max_nodes``
    nodes.
    """
    points = np.vstack([domain.polygonal_copy.points, cover.triangles.reshape(-1, 2), cover.triangles.mean(axis=1)])
    told = tuple(_too_long(metrics, spacing, points))
    asked = MetricSpacing.of(_together(metrics, spacing))
    survey = surveyed(domain, asked, max_nodes, cover)
    aspect = _aspect(asked, np.vstack([points, survey.extremes.minimum_at]))
    asked = MetricSpacing.of(asked.tensors, aspect)
    fitted = MetricSpacing.of(_together(metrics, packing), aspect).straightened()
    return InMetric(asked, fitted, survey, ideal_nodes(domain, fitted, max_nodes, ESTIMATE, cover), told)


def _together(metrics: Sequence[MetricRequest], spacing: Spacing) -> Tensors:
    """The intersection of metrics, their aspects limited, with circles of a spacing."""

    def tensors(x: Floats, y: Floats) -> Floats:
        d = spacing.extended(np.column_stack([x, y]))
        result = np.column_stack([d**-2, np.zeros(len(d)), d**-2])
        for metric in metrics:
            found = metric.tensors(x, y)
            (m11, m12, m22), whole = found.T, np.isfinite(found).all(axis=1)
            positive = (m11 > 0) & (m22 > 0) & (m11 * m22 * (1 + ROUNDING) >= m12 * m12) & whole
            found = np.where(positive[:, None], found, np.nan)
            result = limited_aspect(intersections(result, found), metric.aspect)
        return result

    return tensors


def limited_aspect(tensors: Floats, aspect: float) -> Floats:
    """Tensors (n, 3) with the sizes across no smaller than those along over the ``aspect``."""
    across, along, direction = axes(tensors)
    long = along > aspect * across
    if not long.any():
        return tensors
    limited = of_axes(np.maximum(across, along / aspect), along, direction)
    return np.where(long[:, None], limited, tensors)


def _aspect(spacing: MetricSpacing, points: Floats) -> float:
    """Largest aspect at points (n, 2)."""
    across, along, _ = axes(spacing.at(points))
    return float((along / across).max())


def _too_long(metrics: Sequence[MetricRequest], spacing: Spacing, points: Floats) -> Iterator[str]:
    """Warnings of metrics whose ellipses are longer than their aspect allows at points (n, 2)."""
    for metric in metrics:
        across, along, _ = axes(_together([metric._replace(aspect=np.inf)], spacing)(*points.T))
        k = int(np.nanargmax(along / across)) if np.isfinite(along / across).any() else 0
        if along[k] > TOLD * metric.aspect * across[k]:
            yield (
                f"{metric.key}: the ellipses are up to {along[k] / across[k]:.4g} times as long as wide, at "
                f"{place(points[k])}: they are made wider than that, {metric.aspect:g} times at most; aspect raises it"
            )
