"""The metric in which a solution's interpolation error is least for a number of nodes, by its recovered Hessian."""

import numpy as np

from bubblemesh.adaptivity.estimate import gradients, recovered_gradients, split_nodes
from bubblemesh.arrays import Floats, Integers
from bubblemesh.geometry.arrangement import TOUCHING
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.periodic import counterparts
from bubblemesh.kernels.tensors import intersected_at
from bubblemesh.meshes.edges import rim_nodes
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.meshes.tensors import Axes, axes, determinants, eigen, size_ratios, symmetric, turned
from bubblemesh.spacing.metric.field import TensorField
from bubblemesh.spacing.metric.gradation import graded

LEAST_DERIVATIVE = 1e-6  # least second derivative in terms of the largest one in the domain
NOISE = 1e-14  # the same in terms of the largest value over the square of a triangle's size: less is rounding
SCALE_HALVINGS = 60  # of an interval that holds a scale
TURNS, ALIKE = 8, 1.02  # across periodic sides, at most, and times that sizes may differ in the end
PER_NODE = np.sqrt(3) / 2  # area of a perfect packing, in the metric


def hessians(points: Floats, triangles: Integers, values: Floats) -> Floats:
    """Second derivatives (n, k, 3), by x and x, x and y, y and y, of k fields with values (n, k) at the points (n, 2).

    The gradient is recovered at the nodes, and the gradient of that again.
    """
    n, fields = values.shape
    slopes = recovered_gradients(points, triangles, gradients(points, triangles, values - values[0]))
    bends = recovered_gradients(points, triangles, gradients(points, triangles, slopes.reshape(n, -1)))
    by_x, by_y = np.moveaxis(bends.reshape(n, fields, 2, 2), 2, 0)
    return np.stack([by_x[..., 0], (by_x[..., 1] + by_y[..., 0]) / 2, by_y[..., 1]], axis=-1)


def best_metric(points: Floats, triangles: Integers, values: Floats, part: Integers | None = None) -> Floats:
    """Tensors (n, 3), but for a common factor, of the metric for k components with values (n, k) at the points (n, 2).

    With |H| the Hessian with its eigenvalues made positive it is det(|H|)^(-1/6) |H|, which makes the interpolation
    error in L2 least for any number of nodes. Of several components |H| is (sum of H^2)^(1/2), as their errors add in
    squares. Second derivatives that are rounding of the values, or a millionth of the largest ones, ask for nothing.
    Gradients may jump where the material ``part`` (t,) of the triangles changes: each side has its own Hessian there,
    and a point the intersection of the metrics of its sides.

    References
    ----------
    A. Loseille, F. Alauzet, "Continuous mesh framework. Part II: Validations and applications", SIAM J. Numer. Anal. 49
    (2011).
    """
    if part is not None:
        split, corners = split_nodes(points, triangles, part)
        origin = np.empty(len(split), np.int64)
        origin[corners] = triangles
        of_sides = best_metric(split, corners, values[origin])
        _, one_side = np.unique(origin, return_index=True)
        return intersected_at(of_sides[one_side], origin, of_sides)
    first, second, direction = _positive(hessians(points, triangles, values))
    size = np.sqrt(np.abs(signed_areas(points, triangles)).mean())
    noise = NOISE * float(np.abs(values).max()) / size**2
    least = max(LEAST_DERIVATIVE * float(first.max()), noise, np.finfo(float).tiny ** 0.25)
    first, second = np.maximum(first, least), np.maximum(second, least)
    tensors = symmetric(first, second, direction) * ((first * second) ** (-1 / 6))[:, None]
    return tensors / area_in(points, triangles, tensors)


def _positive(hessian: Floats) -> tuple[Floats, Floats, Floats]:
    """Eigenvalues (n,) of |H| for Hessians (n, k, 3), the larger ones first, and unit vectors (n, 2) of the smaller."""
    if hessian.shape[1] == 1:  # the square would lose half of the digits
        larger, smaller, direction = eigen(hessian[:, 0])
        first, second = np.abs(larger), np.abs(smaller)
        across = np.column_stack([direction[:, 1], -direction[:, 0]])
        turned = second > first
        return np.maximum(first, second), np.minimum(first, second), np.where(turned[:, None], across, direction)
    h11, h12, h22 = np.moveaxis(hessian, 2, 0)
    squares = (h11 * h11 + h12 * h12, h12 * (h11 + h22), h12 * h12 + h22 * h22)
    larger, smaller, direction = eigen(np.stack([part.sum(axis=1) for part in squares], axis=-1))
    return np.sqrt(larger), np.sqrt(np.maximum(smaller, 0.0)), direction


def area_in(points: Floats, triangles: Integers, tensors: Floats) -> float:
    """Area of a mesh in the metric of tensors (n, 3) at its points (n, 2)."""
    density = np.sqrt(np.maximum(determinants(tensors), 0.0))[triangles].mean(axis=1)
    return float(np.abs(signed_areas(points, triangles)) @ density)


def scaled_for(
    points: Floats, triangles: Integers, tensors: Floats, nodes: float, sizes: tuple[float, float], aspect: float
) -> Floats:
    """Tensors (n, 3) times the factor with which a perfect packing has about so many nodes, within limits.

    The least and the largest of the ``sizes``, and the ``aspect``, hold for all ellipses.
    """
    low, high = -80.0, 80.0  # of the factor's logarithm
    start = nodes * PER_NODE / area_in(points, triangles, tensors)
    for _ in range(SCALE_HALVINGS):
        middle = (low + high) / 2
        limited = _limited(np.exp(middle) * start * tensors, sizes, aspect)
        if area_in(points, triangles, limited) > nodes * PER_NODE:
            high = middle
        else:
            low = middle
    return _limited(np.exp(low) * start * tensors, sizes, aspect)


def graded_across_sides(domain: Domain, points: Floats, triangles: Integers, tensors: Floats, growth: float) -> Floats:
    """Tensors (n, 3) at points (n, 2) of a mesh of a domain, `graded` also across its periodic sides.

    What is finer on one side goes on from its counterpart, in turns until sizes change little.
    """
    result = graded(points, triangles, tensors, growth)
    for _ in range(TURNS if len(domain.periodic) else 0):
        finer = intersected_across_sides(domain, points, triangles, result)
        if (size_ratios(result, finer) < ALIKE).all():
            break
        result = graded(points, triangles, finer, growth)
    return result


def intersected_across_sides(domain: Domain, points: Floats, triangles: Integers, tensors: Floats) -> Floats:
    """Tensors (n, 3) at points (n, 2) of a mesh, on periodic sides the intersections with those of the other side.

    At a corner these are the ones of both sides that meet there.
    """
    rim = rim_nodes(triangles)
    node, piece, s = _places_on_sides(domain, points[rim])
    mine, other, s = counterparts(domain.boundary, domain.periodic, piece, s)
    opposite = TensorField.of(points, triangles, tensors)(*domain.boundary.points(other, s).T)
    return intersected_at(tensors, rim[node[mine]], turned(opposite.tensors, domain.turn[other]))


def _places_on_sides(domain: Domain, points: Floats) -> tuple[Integers, Integers, Floats]:
    """Numbers (k,) of points (n, 2) on the boundary, with their pieces (k,) and arc lengths (k,).

    A point at a corner comes once for each periodic side that ends there.
    """
    boundary = domain.boundary
    sides = domain.periodic.ravel()
    nearest = domain.nearest(points)
    length = boundary.lengths[nearest.piece]
    inside = np.minimum(nearest.s, length - nearest.s) > TOUCHING * domain.size
    corner = np.where(nearest.s < length / 2, boundary.start[nearest.piece], boundary.end[nearest.piece])
    begins, ends = (~inside[:, None] & (corner[:, None] == of[sides]) for of in (boundary.start, boundary.end))
    first, starting = np.nonzero(begins)
    last, ending = np.nonzero(ends)
    between = np.flatnonzero(inside)
    return (
        np.concatenate([between, first, last]),
        np.concatenate([nearest.piece[between], sides[starting], sides[ending]]),
        np.concatenate([nearest.s[between], np.zeros(len(first)), boundary.lengths[sides[ending]]]),
    )


def _limited(tensors: Floats, sizes: tuple[float, float], aspect: float) -> Floats:
    across, along, direction = axes(tensors)
    return Axes(np.clip(across, *sizes), np.clip(along, *sizes), direction).wider(aspect).tensors
