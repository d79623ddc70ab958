"""Measures of triangles in a metric, and what of it a mesh keeps."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.meshes.quality import Measures
from bubblemesh.spacing.metric.metric import MetricSpacing
from bubblemesh.spacing.metric.tensors import mapped, roots
from bubblemesh.spacing.spacing import Spacing

SHORTEST, LONGEST = 0.5**0.5, 2.0**0.5  # edges between are as long as they should be: none is better halved or joined
ENTRIES = ("metric_11", "metric_12", "metric_22")  # names of the tensors of triangles in mesh files


@dataclass(frozen=True, eq=False)
class MeasuresInMetric(Measures):
    """Measures of triangles whose shape is that in the tensors at their centroids; lengths and angles are in space."""

    tensors: Floats  # (t, 3)

    @cached_property
    def radius_ratios(self) -> Floats:
        """Twice the ratio (t,) of the inscribed to the circumscribed circle's radius, in the metric."""
        return radius_ratios_in(self.tensors, self.points, self.triangles)


def radius_ratios_in(tensors: Floats, points: Floats, triangles: Integers) -> Floats:
    """Radius ratios (t,) of triangles (t, 3) between points (n, 2) in tensors (t, 3)."""
    apart = mapped(np.repeat(roots(tensors), 3, axis=0), points[triangles].reshape(-1, 2))
    return Measures(apart, np.arange(len(apart)).reshape(-1, 3)).radius_ratios


def measures_in(spacing: Spacing, points: Floats, triangles: Integers) -> Measures:
    """Measures of triangles (t, 3) between points (n, 2), in the metric of a spacing if it has one."""
    if not isinstance(spacing, MetricSpacing):
        return Measures(points, triangles)
    return MeasuresInMetric(points, triangles, spacing.at(points[triangles].mean(axis=1)))
