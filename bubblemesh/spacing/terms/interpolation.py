"""Linear interpolation of what is known at the nodes of a mesh."""

from functools import cached_property

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.records import record
from bubblemesh.spacing.terms.locator import MeshRim, TriangleLocator


@record
class MeshInterpolation:
    """Linear interpolation in the triangles of a mesh; outside, what is at the nearest point of the mesh."""

    points: Floats  # (n, 2)
    triangles: Integers  # (t, 3): each has an area

    def __call__(self, values: Floats, places: Floats) -> Floats:
        """Values (m,) or (m, k) at places (m, 2), of those (n,) or (n, k) at the nodes."""
        triangle, shares = self._locator.located(places)
        second, third = (_of_rows(share, values) for share in shares)
        a, b, c = (values[self.triangles[triangle, k]] for k in range(3))
        found = a + second * (b - a) + third * (c - a)
        outside = np.flatnonzero(triangle < 0)
        if len(outside):
            nodes, share = self._rim.nearest(places[outside])
            first, last = values[nodes[:, 0]], values[nodes[:, 1]]
            found[outside] = first + _of_rows(share, values) * (last - first)
        return np.asarray(found, float)

    def holds(self, places: Floats) -> Booleans:
        """Whether places (m, 2) lie in the mesh."""
        return np.asarray(self._locator.located(places)[0] >= 0)

    @cached_property
    def _locator(self) -> TriangleLocator:
        return TriangleLocator.of(self.points[self.triangles])

    @cached_property
    def _rim(self) -> MeshRim:
        return MeshRim.of(self.points, self.triangles)


def _of_rows(share: Floats, values: Floats) -> Floats:
    """Shares (m,) in a shape that multiplies whole rows of values (n,) or (n, k)."""
    return share.reshape(-1, *(1,) * (values.ndim - 1))
