"""A spacing given by values on a triangle mesh."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import CaseError
from bubblemesh.meshes.quality import doubled_areas
from bubblemesh.messages import place
from bubblemesh.spacing.terms.locator import MeshRim, TriangleLocator
from bubblemesh.spacing.terms.values import require_positive, spots

FLAT = 1e-13  # height in terms of the longest side


@dataclass(frozen=True)
class Field:
    """Linear interpolation of values at the nodes of a mesh; outside the mesh, the value at its nearest point.

    The mesh may have holes and several parts, and its triangles may turn either way. Made by `of` and `of_triangles`.

    Attributes
    ----------
    points : (n, 2)
    triangles : (t, 3)
        Each has an area.
    values : (n,)
        Positive and finite at the nodes of triangles.
    """

    points: Floats
    triangles: Integers
    values: Floats

    @classmethod
    def of(cls, points: Floats, triangles: Integers, values: Floats) -> Self:
        """Field of values (n,) at the points (n, 2) of triangles (t, 3), those without an area left out.

        Raises
        ------
        CaseError
            If a value is not positive and finite (the text names the node and its place), or no triangle is left.
        """
        points, values = np.asarray(points, float), np.asarray(values, float)
        used = np.unique(triangles)
        require_positive(values[used], lambda k: f"at node {used[k]} (from 0), {place(points[used[k]])}")
        return cls(points, _with_area(points, triangles), values)

    @classmethod
    def of_triangles(cls, points: Floats, triangles: Integers, values: Floats, cells: Integers | None = None) -> Self:
        """Field of values (t,) of the triangles, or (c,) of cells that they are parts of, averaged at the points.

        So that the number of bubbles stays the same, it is 1/d^2 that is averaged, by the area around each point.

        Parameters
        ----------
        points : (n, 2)
        triangles : (t, 3)
        values : (t,) or (c,)
        cells : (t,), optional
            Number of the cell that each triangle is a part of.

        Raises
        ------
        CaseError
            If a value is not positive and finite (the text names the cell's place), or no triangle has an area.
        """

        def where(cell: int) -> str:
            corners = np.unique(triangles[cells == cell])
            what = "triangle" if len(corners) == 3 else "cell"
            return f"in the {what} around {place(points[corners].mean(axis=0))}"

        points, values = np.asarray(points, float), np.asarray(values, float)
        cells = np.arange(len(triangles)) if cells is None else cells
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
        points = np.column_stack([x, y])
        triangle, (second, third) = self._locator.located(points)
        a, b, c = self.values[self.triangles[triangle]].T
        d = a + second * (b - a) + third * (c - a)
        outside = np.flatnonzero(triangle < 0)
        if len(outside):
            nodes, share = self._rim.nearest(points[outside])
            first, last = self.values[nodes].T
            d[outside] = first + share * (last - first)
        return d

    @cached_property
    def _locator(self) -> TriangleLocator:
        return TriangleLocator.of(self.points[self.triangles])

    @cached_property
    def _rim(self) -> MeshRim:
        return MeshRim.of(self.points, self.triangles)


def _with_area(points: Floats, triangles: Integers) -> Integers:
    """The triangles but those whose corners lie on a line."""
    corners = points[triangles]
    longest = ((corners - np.roll(corners, 1, axis=1)) ** 2).sum(axis=2).max(axis=1)
    real = triangles[np.abs(doubled_areas(corners)) > FLAT * longest]
    if len(real) == 0:
        raise CaseError("none of the triangles has an area")
    return real
