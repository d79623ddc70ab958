"""Smoothing in a metric: triangles of the best shape in the metric at their centroids, edges of length 1.

The metric is the one that is asked for, by which quality is measured, where it bends as well.
"""

from typing import ClassVar

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.domain import Domain
from bubblemesh.kernels.ellipse_motion import moved
from bubblemesh.kernels.ellipse_shapes import Shaped, shape_measures
from bubblemesh.kernels.newton import Metrics, Newton, SmoothingTerms, costs_in
from bubblemesh.kernels.tensors import roots
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.meshes.tensors import area_sizes
from bubblemesh.packing.confinement import Sliding
from bubblemesh.packing.ellipses.net import EllipseNet
from bubblemesh.packing.net import Net
from bubblemesh.packing.newton import (
    RootsAt,
    axes_with,
    independent_groups,
    metrics_around,
    roots_around,
    side_weight,
    steady_metrics,
)
from bubblemesh.packing.smoothing import SmoothingPasses
from bubblemesh.records import record
from bubblemesh.spacing.metric.metric import MetricSpacing

MOST_PASSES = 10  # of flips
PERFECT = 0.5  # cost of a perfect triangle
FREE = 1.3  # times too long or too short: edges up to that are as good as any in the last passes, for better shapes
LAST_WEIGHT = 4.0  # times that of other passes: so many times as much the worst triangles count in the last ones


@record
class NoEllipseSmoothing:
    """No smoothing, and no mending either."""

    passes: ClassVar[int] = 0
    shape_steps: ClassVar[int] = 0
    spacing_weight: ClassVar[float] = 0.0

    def __call__(self, ellipses: EllipseNet, domain: Domain, spacing: MetricSpacing, last: bool = False) -> EllipseNet:
        """The ellipses as they are."""
        return ellipses


@record
class EllipseSmoothing(SmoothingPasses):
    """Newton's method, node by node, on the shapes of the triangles and the lengths of the edges in the metric."""

    def __call__(self, ellipses: EllipseNet, domain: Domain, spacing: MetricSpacing, last: bool = False) -> EllipseNet:
        """The net after flips that better the worse of two triangles, and a pass of smoothing.

        Where the metric changes much from node to node the circle test, in a mean metric, does not find these. Bubbles
        on the boundary go along its tangents where they were, and are put back on it in the end. Where that leaves too
        little of a triangle, or makes boundary edges cross, the boundary stays as it is. A ``last`` pass is for the
        shapes of the worst triangles.
        """
        requested, bubbles, moving = spacing.unstraightened, ellipses.net.bubbles, ellipses.interior
        inside_roots, own_roots = roots_around(bubbles.x, ellipses.net.triangles, roots_by(requested))
        net, inside_roots = _with_better_shapes(ellipses.net, requested, inside_roots)
        triangles = net.triangles
        moving[bubbles.sliding] = True
        inside, own = metrics_around(bubbles.x, triangles, inside_roots, own_roots, moving, roots_by(requested))
        axes = axes_with(own, bubbles.sliding, Sliding(domain.boundary, bubbles).tangents)
        for held in (domain.tied[bubbles.piece], np.ones(len(bubbles.piece), bool)):
            moving[bubbles.sliding] = ~held
            there = smoothed_places(bubbles.x, triangles, moving, inside, own, axes, self, last)
            sliding, x = Sliding(domain.boundary, bubbles), there.copy()
            sliding.follow(x)
            tensors = spacing.at(x)
            put_back = net.of(sliding.bubbles_at(x, area_sizes(tensors)))
            if held.all() or (_stand(there, x, triangles) and put_back.has_simple_rim):
                break
        return EllipseNet(put_back, tensors, x)


AnyEllipseSmoothing = NoEllipseSmoothing | EllipseSmoothing


def _stand(x: Floats, others: Floats, triangles: Integers) -> bool:
    """Whether triangles (t, 3) of nodes x (n, 2) keep enough of their areas if these go to other places (n, 2)."""
    _, shares = moved(x, others - x, triangles)
    return bool((shares == 1).all())


def smoothed_places(
    x: Floats,
    triangles: Integers,
    moving: Booleans,
    inside: Metrics,
    own: Metrics,
    axes: Floats,
    smoothing: AnyEllipseSmoothing,
    last: bool = False,
) -> Floats:
    """Nodes (n, 2) after a pass over those that are moving (n,), which go along their axes (n, 4).

    The metrics are those `metrics_around` the nodes; a ``last`` pass is for the shapes of the worst triangles.
    """
    groups = independent_groups(moving, triangles)
    newton = Newton(triangles, inside, own, axes, groups, _terms(smoothing, last))
    return newton.moved(x, smoothing.shape_steps)


def _terms(smoothing: AnyEllipseSmoothing, last: bool = False) -> SmoothingTerms:
    """What smoothing lessens."""
    weight = side_weight(smoothing.spacing_weight)
    return SmoothingTerms(LAST_WEIGHT * weight, FREE, worst=True) if last else SmoothingTerms(weight)


def costs(x: Floats, triangles: Integers, spacing: MetricSpacing, smoothing: AnyEllipseSmoothing) -> Floats:
    """Costs (t,) of the triangles (t, 3) of nodes x (n, 2) beyond perfect ones, in the sum that smoothing lessens."""
    return costs_by(x, triangles, *roots_around(x, triangles, roots_by(spacing.unstraightened)), smoothing)


def costs_by(x: Floats, triangles: Integers, inside: Floats, own: Floats, smoothing: AnyEllipseSmoothing) -> Floats:
    """The same as `costs`, by roots of the metric inside triangles (t, 3) and at nodes (n, 3)."""
    return costs_in(x, triangles, *steady_metrics(x, triangles, inside, own), _terms(smoothing)) - PERFECT


def roots_by(spacing: MetricSpacing) -> RootsAt:
    """The roots of the metric of a spacing."""
    return lambda places: roots(spacing.at(places))


def with_better_shapes(net: Net, spacing: MetricSpacing) -> Net:
    """The net after flips of edges, but facets, that lessen the larger shape measure of the two triangles there."""
    return _with_better_shapes(net, spacing, roots_inside(net.bubbles.x, net.triangles, spacing))[0]


def _with_better_shapes(net: Net, spacing: MetricSpacing, inside: Floats) -> tuple[Net, Floats]:
    """The net after such flips, and roots (t, 3) of the metric at the centroids, of which those before are given."""
    triangles, inside = better_shapes(net.bubbles.x, net.triangles, net.facets, spacing, inside)
    edges, _ = unique_edges(triangles)
    return Net(net.bubbles, net.facets, net.facet_piece, net.two_sided, triangles, edges), inside


def roots_inside(x: Floats, triangles: Integers, spacing: MetricSpacing) -> Floats:
    """Roots (t, 3) of the metric at the centroids of triangles (t, 3) of nodes x (n, 2)."""
    return roots_by(spacing)(x[triangles].mean(axis=1))


def better_shapes(
    x: Floats, triangles: Integers, facets: Integers, spacing: MetricSpacing, inside: Floats
) -> tuple[Integers, Floats]:
    """Triangles (t, 3) of nodes x (n, 2) after such flips, but of facets (f, 2), and roots (t, 3) of the metric.

    The roots are those at the centroids; before the flips they are the given ones.
    """
    shaped = Shaped(triangles.copy(), shape_measures(x, triangles, inside), inside.copy())
    fresh = np.ones(len(triangles), bool)
    for _ in range(MOST_PASSES):
        flips = shaped.flips(len(x), facets, fresh)
        turned = flips.turned.reshape(-1, 3)
        there = roots_inside(x, turned, spacing)
        fresh = shaped.flip(flips, shape_measures(x, turned, there), there)
        if not fresh.any():
            break
    return shaped.triangles, shaped.inside
