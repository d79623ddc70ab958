"""The metric in which a solution's interpolation error is least for a number of nodes, by its recovered Hessian."""

import numpy as np

from bubblemesh.adaptivity.estimate import gradients, recovered_gradients
from bubblemesh.arrays import Floats, Integers
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.meshes.tensors import Axes, axes, determinants, intersections

FLATTEST = 1e-6  # least second derivative in terms of the largest one in the domain
HALVINGS = 60  # of an interval that holds a scale
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


def best_metric(points: Floats, triangles: Integers, values: Floats) -> Floats:
    """Tensors (n, 3), but for a common factor, of the metric for k fields with values (n, k) at the points (n, 2).

    With |H| the Hessian with its eigenvalues made positive it is det(|H|)^(-1/6) |H| for each field, which makes the
    interpolation error in L2 least for any number of nodes; several fields are intersected.

    References
    ----------
    A. Loseille, F. Alauzet, "Continuous mesh framework. Part II: Validations and applications", SIAM J. Numer. Anal. 49
    (2011).
    """
    found = hessians(points, triangles, values)
    metrics = [_of_hessian(points, triangles, found[:, k]) for k in range(found.shape[1])]
    result = metrics[0]
    for other in metrics[1:]:
        result = intersections(result, other)
    return result


def _of_hessian(points: Floats, triangles: Integers, hessian: Floats) -> Floats:
    h11, h12, h22 = hessian.T
    half, apart = (h11 + h22) / 2, np.hypot((h11 - h22) / 2, h12)
    angle = np.arctan2(h12, (h11 - h22) / 2) / 2
    first, second = np.abs(half + apart), np.abs(half - apart)
    least = max(FLATTEST * float(np.maximum(first, second).max()), np.finfo(float).tiny ** 0.25)
    first, second = np.maximum(first, least), np.maximum(second, least)
    c, s = np.cos(angle), np.sin(angle)
    bent = np.column_stack([first * c * c + second * s * s, (first - second) * c * s, first * s * s + second * c * c])
    tensors = bent * ((first * second) ** (-1 / 6))[:, None]
    return tensors / area_in(points, triangles, tensors)


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
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        limited = _limited(np.exp(middle) * start * tensors, sizes, aspect)
        if area_in(points, triangles, limited) > nodes * PER_NODE:
            high = middle
        else:
            low = middle
    return _limited(np.exp(low) * start * tensors, sizes, aspect)


def _limited(tensors: Floats, sizes: tuple[float, float], aspect: float) -> Floats:
    across, along, direction = axes(tensors)
    return Axes(np.clip(across, *sizes), np.clip(along, *sizes), direction).wider(aspect).tensors
