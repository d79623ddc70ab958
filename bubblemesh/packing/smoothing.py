"""Smoothing: the finished packing is moved to triangles of the best shape and edges as long as the spacing."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from annotated_types import Ge, Gt, Le
from typing_extensions import Doc

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.confinement import Sliding
from bubblemesh.packing.net import Net, connect_inside
from bubblemesh.spacing.spacing import Spacing

MOMENTUM = 0.8
MOST_MOVE = 0.1  # spacings in a step
FLATTEST = 0.05  # area in units of d^2: what is flatter, or inverted, is pushed like that
SHORTEST = 1e-6  # spacings: bubbles nearer to each other have no direction to part in
WORST = 3.0  # shape measure, beyond which its power grows no more


@dataclass(frozen=True)
class NoSmoothing:
    """No smoothing: the bubbles relax once more, and again while some are lost at the boundary."""

    last_relaxations: ClassVar[int] = 4
    passes: ClassVar[int] = 1
    shape_steps: ClassVar[int] = 0

    def __call__(self, net: Net, domain: Domain, spacing: Spacing) -> Net:
        """The net of the bubbles where they are, with the spacing there."""
        return connect_inside(net.bubbles, domain, spacing)

    def moved(self, net: Net, domain: Domain, free: Booleans) -> Bubbles:
        """The bubbles of a net as they are."""
        return net.bubbles


@dataclass(frozen=True)
class Smoothing:
    """Gradient descent, with momentum, on the shapes of the triangles and the lengths of the edges.

    It lessens the sum over triangles of eta^4 + spacing_weight * the sum over edges of (l/d - 1)^2. The shape measure
    eta = (a^2 + b^2 + c^2) / (4 sqrt(3) A) is 1 for an equilateral triangle; its fourth power makes
    the worst triangles count most. Bubbles on the boundary slide along it, corners stay.

    References
    ----------
    L. Freitag, P. Knupp, "Tetrahedral mesh improvement via optimization of the element condition number",
    Int. J. Numer. Meth. Eng. 53 (2002), for the measure.
    """

    last_relaxations: ClassVar[int] = 0

    passes: Annotated[int, Ge(0), Doc("passes of the polish, with population control in between")] = 3
    shape_steps: Annotated[int, Gt(0), Doc("steps of a pass")] = 10
    shape_step: Annotated[float, Gt(0), Le(0.1), Doc("length of a step, in units where the spacing is 1")] = 0.015
    spacing_weight: Annotated[float, Ge(0), Le(20), Doc("weight of edges' lengths beside triangles' shapes")] = 7.0

    def __call__(self, net: Net, domain: Domain, spacing: Spacing) -> Net:
        """Net after one pass, connected anew.

        Where two walls are near, bubbles that slide may make boundary edges that cross, or next to each other: then
        the boundary stays as it is.
        """
        allowed = max(float(eta(net.bubbles.x, net.triangles).max()), WORST)
        for held in (net.bubbles.corners, net.bubbles.boundary_count):
            try:
                smoothed = connect_inside(self.moved(net, domain, np.arange(len(net.bubbles)) >= held), domain, spacing)
            except GeometryError:
                continue
            if eta(smoothed.bubbles.x, smoothed.triangles).max() <= allowed:
                return smoothed
        return net

    def moved(self, net: Net, domain: Domain, free: Booleans) -> Bubbles:
        """The bubbles of a net after one pass in which only those that are ``free`` (n,) move."""
        bubbles = net.bubbles
        sliding = Sliding(domain.boundary, bubbles)
        x, v, d = bubbles.x.copy(), np.zeros_like(bubbles.x), bubbles.d
        corners, ends = np.ascontiguousarray(net.triangles.T), np.ascontiguousarray(net.edges.T)
        contact = (d[ends[0]] + d[ends[1]]) / 2
        free = free.copy()
        free[bubbles.sliding] &= ~domain.on_periodic_side[bubbles.piece]
        scale = np.where(free, d * d, 0.0)[:, None]
        for _ in range(self.shape_steps):
            gradient = shape_gradient(x, corners, d) + self.spacing_weight * spacing_gradient(x, ends, contact)
            v = MOMENTUM * v - self.shape_step * sliding.project(gradient * scale)
            length = np.sqrt(np.einsum("ij,ij->i", v, v))
            v *= (MOST_MOVE * d / np.maximum(length, MOST_MOVE * d))[:, None]
            x, v = sliding.advance(x + v, v)
        return sliding.bubbles_at(x, d)


def eta(x: Floats, triangles: Integers) -> Floats:
    """Shape measure (t,) of triangles with their nodes at x (n, 2); infinite for a flat or inverted one."""
    a, b, c = np.moveaxis(x[triangles], 1, 0)
    u, v = b - a, c - a
    area = (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / 2
    squares = ((b - a) ** 2 + (c - a) ** 2 + (c - b) ** 2).sum(axis=1)
    return np.divide(squares, 4 * np.sqrt(3) * area, out=np.full(len(area), np.inf), where=area > 0)


def shape_gradient(x: Floats, corners: Integers, d: Floats) -> Floats:
    """Gradient (n, 2) of the sum of eta^4 over triangles with the nodes ``corners`` (3, t), at positions x (n, 2)."""
    px, py = (column.take(corners) for column in np.ascontiguousarray(x.T))
    ux, uy = px[1] - px[0], py[1] - py[0]
    wx, wy = px[2] - px[0], py[2] - py[0]
    zx, zy = px[2] - px[1], py[2] - py[1]
    area = np.maximum((ux * wy - uy * wx) / 2, FLATTEST * d.take(corners[0]) ** 2)
    squares = ux * ux + uy * uy + wx * wx + wy * wy + zx * zx + zy * zy
    to_eta = 1 / (4 * np.sqrt(3) * area)
    eta = squares * to_eta
    steep = 4 * np.minimum(eta, WORST) ** 3
    by_squares, by_area = 2 * steep * to_eta, steep * eta / (2 * area)
    # The sum of squares pulls each corner to the others, the area pushes it off the side across.
    pull = ((-ux - wx, -uy - wy), (ux - zx, uy - zy), (wx + zx, wy + zy))
    push = ((-zy, zx), (wy, -wx), (-uy, ux))
    result = np.zeros((len(x), 2))
    for axis in range(2):
        for node, toward, off in zip(corners, pull, push, strict=True):
            weight = by_squares * toward[axis] - by_area * off[axis]
            result[:, axis] += np.bincount(node, weight, minlength=len(x))
    return result


def spacing_gradient(x: Floats, ends: Integers, contact: Floats) -> Floats:
    """Gradient (n, 2) of the sum of (l / l0 - 1)^2 over edges ``ends`` (2, m), with l0 = ``contact`` (m,)."""
    i, j = ends
    delta = [column.take(i) - column.take(j) for column in np.ascontiguousarray(x.T)]
    length = np.maximum(np.sqrt(delta[0] * delta[0] + delta[1] * delta[1]), SHORTEST * contact)
    weight = 2 * (length / contact - 1) / (contact * length)
    columns = [
        np.bincount(i, weight * part, minlength=len(x)) - np.bincount(j, weight * part, minlength=len(x))
        for part in delta
    ]
    return np.column_stack(columns)
