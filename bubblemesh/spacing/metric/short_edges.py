"""A metric beside edges that are shorter than it asks for: finer along them, and across as far as it has to be."""

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from bubblemesh.arrays import Floats, turned_left
from bubblemesh.kernels.tensors import intersections, lengths
from bubblemesh.meshes.tensors import Axes, axes, of_axes
from bubblemesh.records import record
from bubblemesh.spacing.metric.metric import EllipsesAt
from bubblemesh.spacing.spacing import Spacing

if TYPE_CHECKING:
    from scipy.spatial import KDTree


@record
class BesideEdges:
    """Ellipses that are smaller beside short edges, by a limit of the size along these.

    Across an edge they may be longer than the limit by as much as the metric is longer there than along it: an edge
    along the short axis does not make the long one as short as itself.
    """

    ellipses: EllipsesAt
    limit: Spacing
    edges: Floats  # (k, 2, 2): their ends

    def __call__(self, x: Floats, y: Floats) -> Axes:
        """Axes of the ellipses at x (n,) and y (n,)."""
        whole, points = self.ellipses(x, y), np.column_stack([x, y])
        d = self.limit.extended(points)
        smaller = np.flatnonzero(d < whole.along)
        if len(smaller) == 0 or len(self.edges) == 0:
            return whole
        tensors, d = whole.tensors, d[smaller]
        along = self._directions[self._tree.query(points[smaller])[1]]
        beside = turned_left(along)
        stretch = lengths(tensors[smaller], along) / lengths(tensors[smaller], beside)
        limited = intersections(tensors[smaller], of_axes(d, d * np.maximum(stretch, 1.0), beside))
        tensors[smaller] = limited
        return axes(tensors)

    @cached_property
    def _directions(self) -> Floats:
        """Unit vectors (k, 2) along the edges."""
        along = self.edges[:, 1] - self.edges[:, 0]
        return np.asarray(along / np.hypot(*along.T)[:, None])

    @cached_property
    def _tree(self) -> "KDTree":
        """Tree of the edges' middles: they are short, and near to what they make smaller."""
        from scipy.spatial import KDTree  # takes longer to load than to mesh a small case without it

        return KDTree(self.edges.mean(axis=1))
