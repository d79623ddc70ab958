"""A metric given by tensors at the nodes of a mesh."""

from functools import cached_property
from typing import Self

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.meshes.tensors import Axes, logarithms, of_logarithms
from bubblemesh.records import record
from bubblemesh.spacing.terms.interpolation import MeshInterpolation


@record
class TensorField:
    """Interpolation of tensors in the triangles of a mesh; outside, the tensor at its nearest point.

    The logarithms of the tensors are linear: sizes change geometrically from node to node, and stay positive.

    References
    ----------
    V. Arsigny, P. Fillard, X. Pennec, N. Ayache, "Log-Euclidean metrics for fast and simple calculus on diffusion
    tensors", Magn. Reson. Med. 56 (2006).
    """

    points: Floats  # (n, 2)
    triangles: Integers  # (t, 3): each has an area
    logarithms: Floats  # (n, 3): entries 11, 12 and 22 of the tensors' logarithms

    @classmethod
    def of(cls, points: Floats, triangles: Integers, tensors: Floats) -> Self:
        """Field of positive tensors (n, 3) at the points (n, 2) of triangles (t, 3)."""
        return cls(points, triangles, logarithms(tensors))

    def __call__(self, x: Floats, y: Floats) -> Axes:
        """Axes of the ellipses at x (n,) and y (n,)."""
        return of_logarithms(self._interpolation(self.logarithms, np.column_stack([x, y])))

    def holds(self, places: Floats) -> Booleans:
        """Whether places (m, 2) lie in the mesh."""
        return self._interpolation.holds(places)

    @cached_property
    def _interpolation(self) -> MeshInterpolation:
        return MeshInterpolation(self.points, self.triangles)
