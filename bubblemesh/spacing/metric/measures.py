"""Measures of triangles in the metric of a spacing."""

from bubblemesh.arrays import Floats, Integers
from bubblemesh.meshes.metric import MeasuresInMetric
from bubblemesh.meshes.quality import Measures
from bubblemesh.spacing.metric.metric import MetricSpacing
from bubblemesh.spacing.spacing import Spacing


def measures_in(spacing: Spacing, points: Floats, triangles: Integers) -> Measures:
    """Measures of triangles (t, 3) between points (n, 2), in the metric of a spacing if it has one."""
    if not isinstance(spacing, MetricSpacing):
        return Measures(points, triangles)
    return MeasuresInMetric(points, triangles, spacing.at(points[triangles].mean(axis=1)))
