"""Smoothing in a metric: triangles of the best shape in the metric at their centroids, edges of length 1."""

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.kernels.ellipses import moved
from bubblemesh.kernels.shapes import WORST, eta
from bubblemesh.meshes.edges import SideTable, edge_keys
from bubblemesh.meshes.tensors import area_sizes, lengths, mapped, mean_lengths, multiplied, roots, solved
from bubblemesh.packing.ellipses.net import EllipseNet
from bubblemesh.packing.net import Net
from bubblemesh.packing.smoothing import MOMENTUM, MOST_MOVE, Smoothing
from bubblemesh.spacing.metric.metric import MetricSpacing

FLATTEST = 0.05  # area in the metric: what is flatter is pushed like that
MOST_PASSES = 10  # of flips
GAIN = 1e-6  # relative, of a shape measure, for which an edge is flipped


def smoothed(ellipses: EllipseNet, spacing: MetricSpacing, smoothing: Smoothing) -> EllipseNet:
    """The net after a pass of gradient descent and flips by the circle test."""
    return ellipses.moved(_descended(ellipses, spacing, smoothing), spacing)


def shaped(ellipses: EllipseNet, spacing: MetricSpacing, smoothing: Smoothing) -> EllipseNet:
    """The net after flips that better the worse of two triangles, and a pass of gradient descent.

    Where the metric changes much from node to node the circle test, in a mean metric, does not find these.
    """
    net = with_better_shapes(ellipses.net, spacing)
    ellipses = EllipseNet(net, ellipses.tensors, ellipses.known)
    x = _descended(ellipses, spacing, smoothing)
    tensors = spacing.at(x)
    return EllipseNet(net.of(net.bubbles.moved(x, area_sizes(tensors))), tensors, x)


def _descended(ellipses: EllipseNet, spacing: MetricSpacing, smoothing: Smoothing) -> Floats:
    """Places (n, 2) of the bubbles after the steps of a pass, in which no triangle is inverted."""
    net, tensors, x, free = ellipses.net, ellipses.tensors, ellipses.net.bubbles.x, ellipses.interior
    of_triangles = roots(spacing.at(x[net.triangles].mean(axis=1)))
    v = np.zeros_like(x)
    for _ in range(smoothing.shape_steps):
        gradient = shape_gradient(x, net.triangles, of_triangles)
        gradient += smoothing.spacing_weight * length_gradient(x, tensors, net.edges)
        downhill = solved(tensors, gradient)
        downhill[~free] = 0
        v = MOMENTUM * v - smoothing.shape_step * downhill
        v *= (MOST_MOVE / np.maximum(lengths(tensors, v), MOST_MOVE))[:, None]
        x, share = moved(x, v, net.triangles)
        v *= share[:, None]
    return x


def shape_gradient(x: Floats, triangles: Integers, root: Floats) -> Floats:
    """Gradient (n, 2) of the sum of eta^4 over triangles (t, 3) of nodes x (n, 2), in metrics with roots (t, 3).

    The shape measure eta is (a^2 + b^2 + c^2) / (4 sqrt(3) A) for sides and area in the metric.
    """
    r11, r12, r22 = root.T
    (px, py), n = x[triangles].transpose(2, 1, 0), len(x)
    px, py = r11 * px + r12 * py, r22 * py
    ux, uy, wx, wy = px[1] - px[0], py[1] - py[0], px[2] - px[0], py[2] - py[0]
    zx, zy = px[2] - px[1], py[2] - py[1]
    area = np.maximum((ux * wy - uy * wx) / 2, FLATTEST)
    to_eta = 1 / (4 * np.sqrt(3) * area)
    eta = (ux * ux + uy * uy + wx * wx + wy * wy + zx * zx + zy * zy) * to_eta
    steep = 4 * np.minimum(eta, WORST) ** 3
    by_squares, by_area = 2 * steep * to_eta, steep * eta / (2 * area)
    pull = ((-ux - wx, -uy - wy), (ux - zx, uy - zy), (wx + zx, wy + zy))
    push = ((-zy, zx), (wy, -wx), (-uy, ux))
    result = np.zeros((n, 2))
    for node, (toward_x, toward_y), (off_x, off_y) in zip(triangles.T, pull, push, strict=True):
        gx, gy = by_squares * toward_x - by_area * off_x, by_squares * toward_y - by_area * off_y
        result[:, 0] += np.bincount(node, r11 * gx, n)
        result[:, 1] += np.bincount(node, r12 * gx + r22 * gy, n)
    return result


def length_gradient(x: Floats, tensors: Floats, edges: Integers) -> Floats:
    """Gradient (n, 2) of the sum of (l - 1)^2 over edges (m, 2), whose lengths l are as of `edge_lengths`."""
    (i, j), n = edges.T, len(x)
    along = x[j] - x[i]
    first, last = lengths(tensors[i], along), lengths(tensors[j], along)
    weight = 2 * (mean_lengths(first, last) - 1) / 3
    by_first = weight * (np.sqrt(last / first) + 0.5) / first  # derivatives of the mean by both lengths
    by_last = weight * (np.sqrt(first / last) + 0.5) / last
    pull = by_first[:, None] * multiplied(tensors[i], along) + by_last[:, None] * multiplied(tensors[j], along)
    return np.column_stack([np.bincount(j, part, n) - np.bincount(i, part, n) for part in pull.T])


def shape_measures(x: Floats, triangles: Integers, spacing: MetricSpacing) -> Floats:
    """Shape measure (t,), as of `eta`, of triangles (t, 3) of nodes x (n, 2) in the metric at their centroids."""
    corners = x[triangles]
    root = np.repeat(roots(spacing.at(corners.mean(axis=1))), 3, axis=0)
    return eta(mapped(root, corners.reshape(-1, 2)), np.arange(3 * len(triangles)).reshape(-1, 3))


def with_better_shapes(net: Net, spacing: MetricSpacing) -> Net:
    """The net after flips of edges, but facets, that lessen the larger shape measure of the two triangles there."""
    x, triangles, n, t = net.bubbles.x, net.triangles.copy(), len(net.bubbles), len(net.triangles)
    held = np.concatenate([edge_keys(net.facets, n), edge_keys(net.facets[:, ::-1], n)])
    measures = shape_measures(x, triangles, spacing)
    for _ in range(MOST_PASSES):
        # 1. What both triangles of each edge would be after its flip.
        table = SideTable.of(triangles, n)
        other = table.opposite()
        side = np.flatnonzero((other > np.arange(3 * t)) & ~np.isin(edge_keys(table.sides, n), held))
        (one, k), (two, k2) = table.owner(side), table.owner(other[side])
        (a, b), c, e = table.sides[side].T, triangles[one, (k + 2) % 3], triangles[two, (k2 + 2) % 3]
        turned = np.stack([np.column_stack([a, e, c]), np.column_stack([e, b, c])])
        after = shape_measures(x, turned.reshape(-1, 3), spacing).reshape(2, -1)
        # 2. Those that gain most are flipped, none of which share a triangle.
        gain = 1 - after.max(axis=0) / np.maximum(measures[one], measures[two])
        better = np.flatnonzero(gain > GAIN)
        better = better[np.argsort(-gain[better], kind="stable")]
        rank, first = np.arange(len(better)), np.full(t, len(better))
        for owner in (one, two):
            np.minimum.at(first, owner[better], rank)
        chosen = better[(first[one[better]] == rank) & (first[two[better]] == rank)]
        if len(chosen) == 0:
            break
        for owner, which in ((one, 0), (two, 1)):
            triangles[owner[chosen]], measures[owner[chosen]] = turned[which, chosen], after[which, chosen]
    edges = table.sides[(other < 0) | (other > np.arange(3 * t))]
    return Net(net.bubbles, net.facets, net.facet_piece, net.two_sided, triangles, edges)
