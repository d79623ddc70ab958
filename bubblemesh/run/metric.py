"""Figures of a mesh in a metric, as reports hold them."""

from collections import Counter
from typing import TYPE_CHECKING

import numpy as np

from bubblemesh.arrays import Floats, quantile
from bubblemesh.meshes.metric import share_within
from bubblemesh.meshes.quality import Measures, edge_ratios
from bubblemesh.records import record
from bubblemesh.spacing.metric.metric import MetricSpacing
from bubblemesh.spacing.rules.grading import STEEPEST_GROWTH
from bubblemesh.spacing.rules.rules import limited_for_packing_across_sides
from bubblemesh.spacing.rules.sources import Sources

if TYPE_CHECKING:
    from bubblemesh.problem.problem import Problem

ROUND = 2.0  # aspect up to which an ellipse may turn as it likes
SHORTER = 0.95  # share of its length below which an ellipse is told to be shorter
TURNS = "the metric turns faster than straight edges can"
GROWS = f"the spacing grows faster than {STEEPEST_GROWTH:g} per length, to which it is held"
SMALL = "the domain is smaller than the ellipses"
FINER = "the boundary is finer"


@record
class ShortenedRow:
    """Where ellipses are shorter along than the metric asks for, and why."""

    share: float  # of the nodes
    ratio: float  # of the lengths, the largest one
    ratio_at: tuple[float, float]
    quality_mean: float  # of all triangles in the metric with these shorter ellipses
    quality_p01: float
    quality_min: float
    reasons: tuple[str, ...]  # from that of most of these nodes on


@record
class MetricRow:
    """Row of the report on how well a mesh keeps to a metric; quality and edge lengths are in the metric as well."""

    aspect: float  # of the longest ellipse at a node
    edges_within: float  # share of the edges whose length in the metric is from 0.71 to 1.41
    steepest: float  # ratio of the sizes across of ellipses at both ends of an edge, the largest one
    steepest_at: tuple[float, float]
    turn: float  # degrees between the long axes of ellipses at both ends of an edge, the most
    turn_at: tuple[float, float]
    shortened: ShortenedRow | None


def metric_row(measures: Measures, problem: "Problem") -> MetricRow | None:
    """Figures of a mesh in the metric of a problem; None if it has none."""
    requested, packed = problem.spacing, problem.packing_spacing
    if not (isinstance(requested, MetricSpacing) and isinstance(packed, MetricSpacing)):
        return None
    points, edges = measures.points, measures.edges[0]
    ellipses = requested.axes(points)
    lengths = edge_ratios(points, edges, requested.between(points, edges))
    ratio = np.exp(np.abs(np.diff(np.log(ellipses.across)[edges]))[:, 0])
    cosine = np.abs(np.prod(ellipses.direction[edges], axis=1).sum(axis=1))
    turn = np.degrees(np.arccos(np.minimum(cosine, 1.0)))
    turn[(ellipses.aspects < ROUND)[edges].any(axis=1)] = 0.0
    most = [(float(by.max()), _middle(points[edges[by.argmax()]])) for by in (ratio, turn)]
    (steepest, at), (turned, there) = most
    shorter = _shortened(measures, ellipses.along, packed, problem)
    return MetricRow(float(ellipses.aspects.max()), share_within(lengths), steepest, at, turned, there, shorter)


def _middle(ends: Floats) -> tuple[float, float]:
    x, y = ends.mean(axis=0).tolist()
    return x, y


def _shortened(measures: Measures, along: Floats, packed: MetricSpacing, problem: "Problem") -> ShortenedRow | None:
    ratio = along / packed.axes(measures.points).along
    shorter = ratio > 1 / SHORTER
    if not shorter.any():
        return None
    q = packed.measures(measures.points, measures.triangles).radius_ratios
    x, y = measures.points[ratio.argmax()].tolist()
    figures = float(q.mean()), quantile(q, 0.01), float(q.min())
    reasons = _reasons(measures.points[shorter], along[shorter], 1 / ratio[shorter], packed, problem)
    return ShortenedRow(float(shorter.mean()), float(ratio.max()), (x, y), *figures, reasons)


def _reasons(
    points: Floats, along: Floats, share: Floats, packed: MetricSpacing, problem: "Problem"
) -> tuple[str, ...]:
    """Why ellipses at points (k, 2), ``along`` (k,) as the metric asks for, have these shares (k,) of that length."""
    finer = share / packed.shares(points)  # the share but for what straight edges take
    turning = packed.shares(points) < finer
    held = limited_for_packing_across_sides(problem.domain, problem.after_periodic, Sources.none()).spacing
    growing = held.extended(points) * SHORTER < finer * along
    reason = np.select([turning, growing, along > problem.domain.size], [TURNS, GROWS, SMALL], FINER)
    return tuple(text for text, _ in Counter(reason.tolist()).most_common())
