"""Metrics with known answers, and cases with them."""

import numpy as np

from bubblemesh.case.models import Case
from bubblemesh.meshes.tensors import axes, of_axes
from bubblemesh.spacing.metric.metric import MetricSpacing

FRONT = {
    "angle": "atan2(0.4*pi*cos(2*pi*x), 1)",
    "across": "min(0.02 + 0.2*abs(y - 0.5 - 0.2*sin(2*pi*x))/hypot(1, 0.4*pi*cos(2*pi*x)), 0.06)",
}


def tensor_metric(tensors, aspect=1.0):
    """The spacing of tensors (n, 3) at x (n,) and y (n,)."""
    return MetricSpacing.of(lambda x, y: axes(tensors(x, y)), aspect)


def uniform_metric(across, along, angle):
    """The same ellipse everywhere."""

    def tensors(x, y):
        direction = np.broadcast_to([np.cos(angle), np.sin(angle)], (len(x), 2))
        return of_axes(np.full(len(x), across), np.full(len(x), along), direction)

    return tensor_metric(tensors, along / across)


def random_tensors(random, count, aspect=50.0):
    """Positive tensors (n, 3) of any direction."""
    angle, along = random.uniform(0, 2 * np.pi, count), random.uniform(0.1, 2, count)
    direction = np.column_stack([np.cos(angle), np.sin(angle)])
    return of_axes(along / random.uniform(1, aspect, count), along, direction)


def matrices(tensors):
    """Tensors (n, 3) as matrices (n, 2, 2)."""
    m11, m12, m22 = tensors.T
    return np.moveaxis(np.array([[m11, m12], [m12, m22]]), 2, 0)


def metric_case(metric, outer=None, holes=(), spacing=0.06, **keys):
    """A case with a metric, by default in the unit square and with little effort."""
    outer = {"rectangle": [0, 0, 1, 1]} if outer is None else outer
    data = {"name": "m", "domain": {"outer": outer, "holes": list(holes)}, "spacing": spacing, "metric": metric}
    return Case.model_validate(data | {"packing": {"effort": "fast"}} | keys)
