"""Measures of triangles in a metric, which mesh files may hold, and its ellipses."""

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.kernels.tensors import lengths, mapped, roots
from bubblemesh.meshes.edges import numbered_edges
from bubblemesh.meshes.quality import Measures, edge_ratios, mesh_figures
from bubblemesh.meshes.tensors import axes, determinants, logarithms, of_logarithms
from bubblemesh.records import record

SHORTEST, LONGEST = 0.5**0.5, 2.0**0.5  # of edges in the metric: halving or joining makes them no better
ENTRIES = ("metric_11", "metric_12", "metric_22")  # names of the tensors of triangles in mesh files


@record(eq=False)
class MeasuresInMetric(Measures):
    """Measures of triangles: shapes are those in the tensors at the centroids, lengths and angles those in space."""

    tensors: Floats  # (t, 3)

    @cached_property
    def radius_ratios(self) -> Floats:
        """Twice the ratio (t,) of the inscribed to the circumscribed circle's radius, in the metric."""
        return self._stretched.radius_ratios

    @property
    def mean_sides(self) -> Floats:
        """Mean lengths (t,) of the sides in the metric."""
        return sum(self._stretched.sides, np.zeros(len(self.triangles))) / 3

    @cached_property
    def _stretched(self) -> Measures:
        """The triangles, each stretched by its metric."""
        apart = mapped(np.repeat(roots(self.tensors), 3, axis=0), self.points[self.triangles].reshape(-1, 2))
        return Measures(apart, np.arange(len(apart)).reshape(-1, 3))


def tensors_in(fields: Mapping[str, Floats]) -> Floats | None:
    """Tensors (t, 3) among the data of triangles; None if they are missing or not all positive."""
    if not all(name in fields and fields[name].ndim == 1 for name in ENTRIES):
        return None
    tensors = np.column_stack([fields[name] for name in ENTRIES])
    positive = (tensors[:, 0] > 0) & (determinants(tensors) > 0) & np.isfinite(tensors).all(axis=1)
    return tensors if positive.all() else None


def node_tensors(triangles: Integers, tensors: Floats, n: int) -> Floats:
    """Tensors (n, 3) of nodes: means, by logarithms, of those (t, 3) of the triangles around; NaN for unused nodes."""
    nodes, count = triangles[:, :3].T.ravel(), np.bincount(triangles[:, :3].ravel(), minlength=n)
    with np.errstate(invalid="ignore"):
        means = [np.bincount(nodes, np.tile(part, 3), n) / count for part in logarithms(tensors).T]
    return of_logarithms(np.column_stack(means)).tensors


def at_centroids(corners: Integers, tensors: Floats) -> Floats:
    """Tensors (k, 3) at the centroids of edges or triangles: means, by logarithms, of the tensors (n, 3) of the nodes.

    ``corners`` (k, 2) or (k, 3) are the nodes at the ends or corners.
    """
    return of_logarithms(logarithms(tensors)[corners].mean(axis=1)).tensors


def spacing_along_edges(measures: MeasuresInMetric) -> Floats:
    """Spacing (e,) in the direction of each edge of `unique_edges`, in the metric of the triangles there."""
    points, triangles = measures.points, measures.triangles
    edges, number = numbered_edges(triangles)
    along = points[edges[:, 1]] - points[edges[:, 0]]
    in_triangles = [lengths(measures.tensors, along[number[:, side]]) for side in range(3)]
    total = np.bincount(number.T.ravel(), np.concatenate(in_triangles), len(edges))
    return np.hypot(*along.T) * np.bincount(number.ravel(), minlength=len(edges)) / total


def measures_of(points: Floats, triangles: Integers, fields: Mapping[str, Floats]) -> Measures:
    """Measures of triangles (t, 3) between points (n, 2), in the metric among their data (t,) if there is one."""
    tensors = tensors_in(fields)
    return Measures(points, triangles) if tensors is None else MeasuresInMetric(points, triangles, tensors)


def share_within(ratios: Floats) -> float:
    """Share of the edges whose lengths (e,) in the metric are between `SHORTEST` and `LONGEST`."""
    return float(((ratios >= SHORTEST) & (ratios <= LONGEST)).mean())


def figures_in_metric(measures: MeasuresInMetric) -> dict[str, Any]:
    """Figures of a mesh in the metric of its triangles, as a report holds them."""
    target = spacing_along_edges(measures)
    figures = mesh_figures(measures, lambda points, edges: target)
    within = share_within(edge_ratios(measures.points, measures.edges[0], target))
    return {**figures, "metric": {"aspect": float(axes(measures.tensors).aspects.max()), "edges_within": within}}
