"""A spacing given by values on a triangle mesh, or at scattered points."""

from dataclasses import replace
from functools import cached_property
from typing import Self

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import CaseError
from bubblemesh.meshes.checks import finite, indices, real_numbers
from bubblemesh.meshes.quality import doubled_areas
from bubblemesh.messages import place
from bubblemesh.records import record
from bubblemesh.spacing.spacing import require_positive, spots
from bubblemesh.spacing.terms.interpolation import MeshInterpolation

FLAT = 1e-13  # height in terms of the longest side
THINNEST_HULL = 1e-9  # width of scattered points' hull in terms of its length


@record
class MeshField:
    """Linear interpolation of values at the nodes of a mesh; outside the mesh, the value at its nearest point.

    The mesh may have holes and several parts, and its triangles may turn either way. Made by `of` and `of_triangles`.
    """

    points: Floats  # (n, 2)
    triangles: Integers  # (t, 3): each has an area
    values: Floats  # (n,): positive and finite at the nodes of triangles

    @classmethod
    def of(cls, points: Floats, triangles: Integers, values: Floats) -> Self:
        """Field of values (n,) at the points (n, 2) of triangles (t, 3), those without an area left out.

        CaseError if the shapes do not fit, a value is not positive and finite (the text names the node and its place),
        or no triangle is left.
        """
        points = finite(points, "points", ("n", 2))
        triangles = indices(triangles, "triangles", len(points), "node", ("t", 3))
        values = real_numbers(values, "values", (len(points),))
        used = np.unique(triangles)
        require_positive(values[used], lambda k: f"at node {used[k]} (from 0), {place(points[used[k]])}")
        return cls(points, _with_area(points, triangles), values)

    @classmethod
    def of_triangles(cls, points: Floats, triangles: Integers, values: Floats, cells: Integers | None = None) -> Self:
        """Field of values (t,) of the triangles, or (c,) of cells that they are parts of, averaged at the points.

        ``cells`` (t,) are the numbers of the cells that the triangles are parts of. So that the number of bubbles
        stays the same, it is 1/d^2 that is averaged, by the area around each point. CaseError if the shapes do not
        fit, a value is not positive and finite (the text names the cell's place), or no triangle has an area.
        """

        def where(cell: int) -> str:
            corners = np.unique(triangles[cells == cell])
            what = "triangle" if len(corners) == 3 else "cell"
            return f"in the {what} around {place(points[corners].mean(axis=0))}"

        points = finite(points, "points", ("n", 2))
        triangles = indices(triangles, "triangles", len(points), "node", ("t", 3))
        t = len(triangles)
        values = real_numbers(values, "values", (t if cells is None else "c",))
        cells = np.arange(t) if cells is None else indices(cells, "cells", len(values), "value", (t,))
        require_positive(values, where)
        values = values[cells]
        areas = np.abs(doubled_areas(points[triangles]))
        corner = triangles.ravel()
        area = np.bincount(corner, np.repeat(areas, 3), len(points))
        bubbles = np.bincount(corner, np.repeat(areas / values**2, 3), len(points))
        with np.errstate(divide="ignore", invalid="ignore"):  # points of no triangle
            return cls(points, _with_area(points, triangles), np.sqrt(area / bubbles))

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Bounding box (x0, y0, x1, y1) of the triangles."""
        corners = self.points[self.triangles.ravel()]
        (x0, y0), (x1, y1) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
        return x0, y0, x1, y1

    @property
    def spots(self) -> Floats:
        """Nodes (k, 2) at which it is fine over a short distance."""
        return spots(self.points, self.triangles.ravel(), np.roll(self.triangles, -1, axis=1).ravel(), self.values)

    def scaled(self, factor: float) -> Self:
        """The field with all values multiplied."""
        return replace(self, values=factor * self.values)

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Values (m,) at x (m,) and y (m,)."""
        return self._interpolation(self.values, np.column_stack([x, y]))

    @cached_property
    def _interpolation(self) -> MeshInterpolation:
        return MeshInterpolation(self.points, self.triangles)


def _with_area(points: Floats, triangles: Integers) -> Integers:
    """The triangles but those whose corners lie on a line."""
    corners = points[triangles]
    longest = ((corners - np.roll(corners, 1, axis=1)) ** 2).sum(axis=2).max(axis=1)
    real = triangles[np.abs(doubled_areas(corners)) > FLAT * longest]
    if len(real) == 0:
        raise CaseError("none of the triangles has an area")
    return real


def scattered(points: Floats, values: Floats) -> MeshField:
    """Linear interpolation of values (n,) on the Delaunay triangulation of points (n, 2).

    Outside the points' hull, the value at its nearest place. CaseError if the shapes do not fit, a coordinate is no
    number, a value is not positive and finite, points at one place have different values, or all lie on a line; the
    text names the point, from 0, and its place.
    """
    points = finite(points, "points", ("n", 2))
    values = real_numbers(values, "values", (len(points),))
    # Imported here since it takes as long as meshing a small case, and other spacings do without.
    from scipy.spatial import Delaunay, QhullError

    require_positive(values, lambda k: f"at point {k} (from 0), {place(points[k])}")
    apart, first, number = np.unique(points, axis=0, return_index=True, return_inverse=True)
    twice = np.flatnonzero(values != values[first][number])
    if len(twice):
        k, other = twice[0], first[number[twice[0]]]
        raise CaseError(
            f"points {other} and {k} (from 0) are both at {place(points[k])}, with the values {values[other]:g} and "
            f"{values[k]:g}: keep one of them"
        )
    centered = apart - apart.mean(axis=0)
    extent = np.linalg.svd(centered, compute_uv=False) if len(apart) > 2 else np.zeros(2)
    if extent[1] <= THINNEST_HULL * extent[0]:
        raise CaseError("the points lie on a line, or are fewer than three: triangles between them are needed")
    try:
        triangles = Delaunay(centered / extent[0]).simplices
    except QhullError as error:  # its first line says enough
        raise CaseError(f"the points cannot be triangulated: {str(error).splitlines()[0]}") from error
    return MeshField.of(apart, triangles.astype(np.int64), values[first])
