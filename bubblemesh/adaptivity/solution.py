"""A finite element solution on a triangle mesh."""

from dataclasses import dataclass

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import CaseError
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.messages import place


@dataclass(frozen=True)
class Solution:
    """A solution of first order; made by `Solution.of`.

    Attributes
    ----------
    points : (n, 2)
    triangles : (t, 3)
        Counter-clockwise.
    values : (n, k)
        Its k components at the points.
    name : str
    """

    points: Floats
    triangles: Integers
    values: Floats
    name: str = "u"

    @property
    def unit(self) -> float:
        """Power of two near the largest value, in terms of which squares are neither huge nor tiny."""
        _, exponent = np.frexp(np.abs(self.values).max())
        return float(np.ldexp(1.0, int(exponent) - 1))

    @classmethod
    def of(cls, points: Floats, triangles: Integers, values: Floats, name: str = "u") -> "Solution":
        """Solution with real or complex values (n,) or (n, k) at points (n, 2) of triangles (t, 3) of any orientation.

        Raises
        ------
        CaseError
            If the shapes do not fit together, a value is no number, or a triangle has no area; with its place.
        """
        points, triangles, values = np.asarray(points, float), np.asarray(triangles), np.asarray(values)
        _check_shapes(points, triangles, values)
        values = values.reshape(len(values), -1)
        values = np.hstack([values.real, values.imag]) if np.iscomplexobj(values) else values.astype(float)
        bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
        if len(bad):
            raise CaseError(f"{name} is no number at node {bad[0]} (from 0), {place(points[bad[0]])}")
        areas = signed_areas(points, triangles)
        flat = np.flatnonzero(areas == 0)
        if len(flat):
            raise CaseError(f"the triangle around {place(points[triangles[flat[0]]].mean(axis=0))} has no area")
        return cls(points, np.where(areas[:, None] < 0, triangles[:, ::-1], triangles), values, name)


def _check_shapes(points: Floats, triangles: Integers, values: Floats) -> None:
    n = len(points)
    if points.ndim != 2 or points.shape[1:] != (2,) or not np.isfinite(points).all():
        raise CaseError(f"points: must be finite coordinates of shape (n, 2) (found the shape {points.shape})")
    if triangles.ndim != 2 or triangles.shape[1:] != (3,) or triangles.dtype.kind not in "iu" or len(triangles) == 0:
        raise CaseError(f"triangles: must be node numbers of shape (t, 3) (found the shape {triangles.shape})")
    if triangles.min() < 0 or triangles.max() >= n or len(np.unique(triangles)) < n:
        raise CaseError(f"triangles: must use all of the nodes 0 to {n - 1}, and no others")
    if values.ndim not in (1, 2) or len(values) != n or values.size == 0 or values.dtype.kind not in "iufc":
        raise CaseError(f"values: must be numbers of shape ({n},) or ({n}, k) (found the shape {values.shape})")
