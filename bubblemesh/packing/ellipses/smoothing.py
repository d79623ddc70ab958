"""Smoothing in a metric: triangles of the best shape in the metric at their centroids, edges of length 1.

The metric is the one that is asked for, by which quality is measured, where it bends as well.
"""

from typing import ClassVar

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.domain import Domain
from bubblemesh.kernels.ellipse_motion import moved
from bubblemesh.kernels.ellipse_shapes import Shaped, shape_measures
from bubblemesh.kernels.ellipse_smoothing import Metrics, Newton, SmoothingTerms, costs_in
from bubblemesh.kernels.library import or_numpy
from bubblemesh.kernels.patches import first_groups
from bubblemesh.kernels.tensors import mapped, roots, unmapped
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.meshes.tensors import area_sizes
from bubblemesh.packing.confinement import Sliding
from bubblemesh.packing.ellipses.net import EllipseNet
from bubblemesh.packing.neighbours import maximal_independent_set
from bubblemesh.packing.net import Net
from bubblemesh.packing.smoothing import SmoothingPasses
from bubblemesh.records import record
from bubblemesh.spacing.metric.metric import MetricSpacing

MOST_PASSES = 10  # of flips
PERFECT = 0.5  # cost of a perfect triangle
FREE = 1.3  # times too long or too short: edges up to that are as good as any in the last passes, for better shapes
LAST_WEIGHT = 4.0  # times that of other passes: so many times as much the worst triangles count in the last ones
STEP = 0.1  # length of the differences by which it is known how the metric changes


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
        inside_roots, own_roots = roots_around(bubbles.x, ellipses.net.triangles, requested)
        net, inside_roots = _with_better_shapes(ellipses.net, requested, inside_roots)
        triangles = net.triangles
        moving[bubbles.sliding] = True
        inside, own = metrics_around(bubbles.x, triangles, inside_roots, own_roots, moving, requested)
        axes = own.axes
        axes[bubbles.sliding] = _along(Sliding(domain.boundary, bubbles).tangents, own.roots[bubbles.sliding])
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


def _along(tangents: Floats, roots: Floats) -> Floats:
    """Axes (b, 4) of nodes that go along tangents (b, 2) only: the second one is 0."""
    lengths = np.hypot(*mapped(roots, tangents).T)
    return np.column_stack([tangents / lengths[:, None], np.zeros_like(tangents)])


def _stand(x: Floats, others: Floats, triangles: Integers) -> bool:
    """Whether triangles (t, 3) of nodes x (n, 2) keep enough of their areas if these go to other places (n, 2)."""
    _, shares = moved(x, others - x, triangles)
    return bool((shares == 1).all())


def metrics_around(
    x: Floats,
    triangles: Integers,
    inside: Floats,
    own: Floats,
    moving: Booleans,
    spacing: MetricSpacing,
) -> tuple[Metrics, Metrics]:
    """Metrics inside triangles (t, 3), and around their nodes x (n, 2), by their roots there, (t, 3) and (n, 3).

    Around nodes that are not moving (n,) the changes of the metric are left out.
    """
    places, root = _centroids_and(x, triangles), np.concatenate([inside, own])
    changing = np.flatnonzero(np.append(np.ones(len(triangles), bool), moving))
    slopes = np.zeros((len(places), 6))
    slopes[changing] = changes_at(places[changing], root[changing], spacing)
    return _split(Metrics(places, root, slopes), len(triangles))


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
    """What smoothing lessens; its term of a side, (l - 1 / l)^2, is about 4 (l - 1)^2."""
    weight = smoothing.spacing_weight / 8
    return SmoothingTerms(LAST_WEIGHT * weight, FREE, worst=True) if last else SmoothingTerms(weight)


def changes_at(places: Floats, root: Floats, spacing: MetricSpacing) -> Floats:
    """Changes (k, 6) of the metric, by differences, at places (k, 2) where it has roots (k, 3): those of `Metrics`."""
    steps = [unmapped(root, np.broadcast_to(STEP * axis, places.shape)) for axis in np.eye(2)]
    beside = roots(spacing.at(np.concatenate([places + step for step in steps])))
    ahead, over = np.split(beside, 2)
    return np.column_stack([ahead - root, over - root]) / STEP


def costs(x: Floats, triangles: Integers, spacing: MetricSpacing, smoothing: AnyEllipseSmoothing) -> Floats:
    """Costs (t,) of the triangles (t, 3) of nodes x (n, 2) beyond perfect ones, in the sum that smoothing lessens."""
    return costs_by(x, triangles, *roots_around(x, triangles, spacing.unstraightened), smoothing)


def costs_by(x: Floats, triangles: Integers, inside: Floats, own: Floats, smoothing: AnyEllipseSmoothing) -> Floats:
    """The same as `costs`, by roots of the metric inside triangles (t, 3) and at nodes (n, 3)."""
    places, root = _centroids_and(x, triangles), np.concatenate([inside, own])
    steady = _split(Metrics(places, root, np.zeros((len(places), 6))), len(triangles))
    return costs_in(x, triangles, *steady, _terms(smoothing)) - PERFECT


def roots_around(x: Floats, triangles: Integers, spacing: MetricSpacing) -> tuple[Floats, Floats]:
    """Roots of the metric at the centroids of triangles (t, 3), and at their nodes x (n, 2)."""
    root = roots(spacing.at(_centroids_and(x, triangles)))
    return root[: len(triangles)], root[len(triangles) :]


def _centroids_and(x: Floats, triangles: Integers) -> Floats:
    """Centroids of triangles (t, 3), and their nodes x (n, 2) after them: a metric takes less time for both at once."""
    return np.concatenate([x[triangles].mean(axis=1), x])


def _split(metrics: Metrics, count: int) -> tuple[Metrics, Metrics]:
    """The first so many metrics, and the others."""
    return Metrics(*(part[:count] for part in metrics)), Metrics(*(part[count:] for part in metrics))


def independent_groups_in_numpy(chosen: Booleans, triangles: Integers) -> list[Integers]:
    """The same as `independent_groups`, in NumPy."""
    left, rank, edges, groups = chosen, np.arange(len(chosen)), unique_edges(triangles)[0], list[Integers]()
    while left.any():
        found = maximal_independent_set(left, edges, rank)
        groups.append(np.flatnonzero(found))
        left = left & ~found
    return groups


@or_numpy(independent_groups_in_numpy)
def independent_groups(chosen: Booleans, triangles: Integers) -> list[Integers]:
    """Groups (k,) of the chosen nodes (n,) of triangles (t, 3), no two of which are neighbours.

    Each node, in the order of their numbers, is in the first group in which none of its neighbours is.
    """
    groups = first_groups(chosen, triangles)
    return [np.flatnonzero(groups == number) for number in range(groups.max(initial=-1) + 1)]


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
    return roots(spacing.at(x[triangles].mean(axis=1)))


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
