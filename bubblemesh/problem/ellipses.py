"""Ellipses of the kinds of metrics that a case can give, as functions of the place."""

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.geometry.corners import bends_of, turns
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.plane import Plane
from bubblemesh.meshes.tensors import Axes, axes
from bubblemesh.records import Uncached, record
from bubblemesh.spacing.expression import Expression, together
from bubblemesh.spacing.metric.metric import EllipsesAt

if TYPE_CHECKING:
    from scipy.spatial import KDTree

NumberAt = Callable[[Floats, Floats], Floats]  # (n,) at x (n,) and y (n,)
NumbersAt = Callable[[Floats, Floats], list[Floats]]
AT_WALL = 1e-4  # of the domain's size: nearer to a wall the direction is that of its tangent
SQUARE = 1e-3  # cosine of the angle between a wall and the way to it that is a right one, but for rounding on curves
INFINITE = 1e100  # size that asks for nothing
LEAST = 1e-140  # entry that asks for nothing: of smaller ones the determinant would be no number above zero
TURNED = 0.5  # radians by which ellipses turn around a corner that makes them rounder
LONGER = 0.7  # growth of their length away from it


def numbers_together(numbers: Sequence[NumberAt]) -> NumbersAt:
    """Several numbers as one function; what expressions have in common is evaluated once."""
    expressions = [number for number in numbers if isinstance(number, Expression)]
    if len(expressions) == len(numbers):
        return together(expressions)
    return lambda x, y: [number(x, y) for number in numbers]


@record
class Directed(Uncached):
    """Ellipses of sizes across and along a direction, given by its angle."""

    angle: NumberAt
    across: NumberAt
    along: NumberAt | None

    def __call__(self, x: Floats, y: Floats) -> Axes:
        """Axes of the ellipses at x (n,) and y (n,)."""
        angle, across, *limits = self._numbers(x, y)
        (along,) = limits or [np.full(len(x), INFINITE)]
        across = np.where((across > 0) & (along > 0) & np.isfinite(angle), across, np.nan)
        direction = np.empty((len(x), 2))
        with np.errstate(invalid="ignore"):
            np.cos(angle, out=direction[:, 0])
            np.sin(angle, out=direction[:, 1])
        wide = across > along
        if wide.any():
            direction[wide] = np.column_stack([-direction[wide, 1], direction[wide, 0]])
            across, along = np.minimum(across, along), np.maximum(across, along)
        return Axes(across, along, direction)

    @cached_property
    def _numbers(self) -> NumbersAt:
        return numbers_together([self.angle, self.across, *([] if self.along is None else [self.along])])


@record
class Entries(Uncached):
    """Ellipses of tensors, given by their entries."""

    m11: NumberAt
    m12: NumberAt
    m22: NumberAt

    def __call__(self, x: Floats, y: Floats) -> Axes:
        """Axes of the ellipses at x (n,) and y (n,)."""
        m11, m12, m22 = self._numbers(x, y)
        with np.errstate(invalid="ignore", over="ignore"):
            positive = (m11 > 0) & (m22 > 0)
            m11, m22 = np.maximum(m11, LEAST), np.maximum(m22, LEAST)
            positive &= m11 * m22 > m12 * m12
        return axes(np.where(positive[:, None], np.column_stack([m11, m12, m22]), np.nan))

    @cached_property
    def _numbers(self) -> NumbersAt:
        return numbers_together([self.m11, self.m12, self.m22])


@record
class AlongWalls:
    """Ellipses that lie along the nearest of some walls, whose size across grows away from there; circles at points.

    Around the ends and corners of walls they turn: there they are circles, and away from there as long as the distance
    allows. Along round ones they are no longer than edges that at their ends go as far across as ellipses are wide: an
    edge of length L meets a circle of radius r at an angle of L / 2r, and goes L * L / 2r across it.
    """

    domain: Domain
    labels: tuple[str, ...]
    across: float
    growth: float
    along: NumberAt | None

    def __call__(self, x: Floats, y: Floats) -> Axes:
        """Axes of the ellipses at x (n,) and y (n,)."""
        points = np.column_stack([x, y])
        foot, tangent = self.domain.feet(points, *self.labels)
        ax, ay = x - foot[:, 0], y - foot[:, 1]
        distance = np.hypot(ax, ay)
        of_point = ~tangent.any(axis=1)  # which has no direction: around it they are circles
        tx, ty = tangent.T
        # Around corners and ends they turn; what is all but on a wall is too near to it to give a direction.
        close = AT_WALL * self.domain.size
        turning = np.flatnonzero((np.abs(tx * ax + ty * ay) > SQUARE * distance) & (distance > close))
        # Outside, where straight edges are looked at that end there, a wall goes on as it was.
        turning = turning[self.domain.reaches(points[turning], np.full(len(turning), close))]
        direction = tangent.copy()
        direction[turning] = np.column_stack([-ay, ax])[turning] / distance[turning, None]
        direction[of_point] = 1.0, 0.0
        along = np.full(len(x), INFINITE) if self.along is None else self.along(x, y)
        across = np.where(along > 0, np.minimum(self.across + self.growth * distance, along), np.nan)
        if self._turns is not None:
            tree, radius = self._turns
            away, nearest = tree.query(points)
            r = radius[nearest]
            along = np.minimum(along, np.maximum(across, np.sqrt(2 * r * across)) + LONGER * np.maximum(away - r, 0))
        return Axes(across, np.where(of_point, across, along), direction)

    @cached_property
    def _turns(self) -> "tuple[KDTree, Floats] | None":
        """Tree of the places around which ellipses turn, with the radii (k,) of walls there, if there are any.

        They are ends and corners, of radius 0, and outside the domain the centres of arcs.
        """
        from scipy.spatial import KDTree  # takes longer to load than to mesh a small case without it

        boundary = self.domain.boundary
        walls = np.isin(np.array(boundary.labels)[boundary.label], self.labels)
        corners, (centres, radii) = boundary.corners[turns(boundary, walls) > TURNED], bends_of(boundary, walls, TURNED)
        close, outside = AT_WALL * self.domain.size, ~self.domain.contains(centres)
        bends = np.unique(np.rint(np.column_stack([centres, radii])[outside] / close), axis=0) * close
        places = np.concatenate([corners, bends[:, :2]])
        return (KDTree(places), np.append(np.zeros(len(corners)), bends[:, 2])) if len(places) else None


@record
class Scaled:
    """Ellipses with all sizes multiplied."""

    ellipses: EllipsesAt
    scale: float

    def __call__(self, x: Floats, y: Floats) -> Axes:
        """Axes of the ellipses at x (n,) and y (n,)."""
        return self.ellipses(x, y).times(self.scale)


@record
class AtGivenPlaces:
    """Ellipses at coordinates as they were given, as those at places in the plane."""

    ellipses: EllipsesAt
    plane: Plane

    def __call__(self, x: Floats, y: Floats) -> Axes:
        """Axes of the ellipses at x (n,) and y (n,) in the plane."""
        return self.ellipses(*self.plane.given(np.column_stack([x, y])).T)


@record
class OnTheGround:
    """Ellipses in the plane for some in metres on the ground.

    Those that are ``turned`` have directions from the first axis of the given coordinates on: from the east for
    longitudes.
    """

    ellipses: EllipsesAt
    plane: Plane
    turned: bool

    def __call__(self, x: Floats, y: Floats) -> Axes:
        """Axes of the ellipses at x (n,) and y (n,) in the plane."""
        found = self.ellipses(x, y).times(self.plane.scale(x, y))
        if not self.turned:
            return found
        c, s = self.plane.first_axis(np.column_stack([x, y])).T
        tx, ty = found.direction.T
        return found._replace(direction=np.column_stack([c * tx - s * ty, s * tx + c * ty]))
