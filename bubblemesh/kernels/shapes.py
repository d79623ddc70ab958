"""Shapes of triangles and lengths of edges: their gradients by the places of nodes, and steps that improve them."""

from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers, gathered
from bubblemesh.kernels.library import call, or_numpy

FLATTEST = 0.05  # area in units of d^2: flatter and inverted triangles are pushed as if they had this area
SHORTEST = 1e-6  # spacings: bubbles nearer to each other have no direction to part in
WORST = 1.5  # shape measure beyond which the push grows no more


class Descent(NamedTuple):
    """How n nodes go down the gradient of the sums over triangles of eta^8 / 2 and over edges of (l / l0 - 1)^2.

    Each triangle counts as often as is given. The shape measure eta = (a^2 + b^2 + c^2) / (4 sqrt(3) A) is 1 for an
    equilateral triangle. The first nodes stay, those that follow may slide along tangents.
    """

    triangles: Integers  # (t, 3)
    counts: Floats  # (t,): how often each triangle counts
    edges: Integers  # (m, 2)
    d: Floats  # (n,): spacing at the nodes; edges should have the mean length l0 of both ends
    scale: Floats  # (n,): factors of the gradient, 0 for nodes that stay
    most: Floats  # (n,): longest moves of a step
    fixed: int  # number of the first nodes, which stay
    sliding: int  # number b of those that follow, which slide
    weight: float  # of the sum over edges
    momentum: float
    step: float  # length of a step

    def moved_in_numpy(self, x: Floats, tangents: Floats, steps: int) -> Floats:
        """The same as `moved`, in NumPy."""
        x, v, slide = x.copy(), np.zeros_like(x), slice(self.fixed, self.fixed + self.sliding)
        pulling, pulled = ((self.scale[rows] != 0).any(axis=1) for rows in (self.triangles, self.edges))
        corners, counts, ends = self.triangles[pulling].T, self.counts[pulling], self.edges[pulled].T
        contact = (self.d[ends[0]] + self.d[ends[1]]) / 2
        for _ in range(steps):
            lengths = self.weight * spacing_gradient(x, ends, contact)
            downhill = (shape_gradient(x, corners, self.d, counts) + lengths) * self.scale[:, None]
            for vectors in (downhill, v):
                vectors[: self.fixed] = 0
                vectors[slide] = np.einsum("ij,ij->i", vectors[slide], tangents)[:, None] * tangents
            v = self.momentum * v - self.step * downhill
            length = np.sqrt(np.einsum("ij,ij->i", v, v))
            v *= (self.most / np.maximum(length, self.most))[:, None]
            x += v
        return x

    @or_numpy(moved_in_numpy)
    def moved(self, x: Floats, tangents: Floats, steps: int) -> Floats:
        """Places (n, 2) of the nodes after so many steps from rest at x (n, 2), along ``tangents`` (b, 2) that stay."""
        places = np.array(x, order="C")
        call(
            "descend",
            n=len(self.d),
            t=len(self.triangles),
            m=len(self.edges),
            fixed=self.fixed,
            b=self.sliding,
            triangles=np.ascontiguousarray(self.triangles),
            counts=self.counts,
            edges=np.ascontiguousarray(self.edges),
            d=self.d,
            flattest=FLATTEST,
            worst=WORST,
            shortest=SHORTEST,
            scale=self.scale,
            most=self.most,
            weight=self.weight,
            momentum=self.momentum,
            step=self.step,
            tangents=np.ascontiguousarray(tangents),
            steps=steps,
            x=places,
        )
        return places


def eta_in_numpy(x: Floats, triangles: Integers) -> Floats:
    """The same as `eta`, in NumPy."""
    a, b, c = np.moveaxis(gathered(x, triangles), 1, 0)
    u, w, z = b - a, c - a, c - b
    area = (u[:, 0] * w[:, 1] - u[:, 1] * w[:, 0]) / 2
    squares = (u * u + w * w + z * z).sum(axis=1)
    return np.divide(squares, 4 * np.sqrt(3) * area, out=np.full(len(area), np.inf), where=area > 0)


@or_numpy(eta_in_numpy)
def eta(x: Floats, triangles: Integers) -> Floats:
    """Shape measure (t,) of triangles (t, 3) with their nodes at x (n, 2); infinite for a flat or inverted one.

    It is (a^2 + b^2 + c^2) / (4 sqrt(3) A) for sides a, b, c and the area A: 1 for an equilateral triangle.
    """
    result = np.empty(len(triangles))
    call(
        "shape_measures",
        t=len(triangles),
        x=np.ascontiguousarray(x, np.float64),
        triangles=np.ascontiguousarray(triangles, np.int64),
        eta=result,
    )
    return result


def shape_gradient(x: Floats, corners: Integers, d: Floats, counts: Floats) -> Floats:
    """Gradient (n, 2) of the sum of counts (t,) times eta^8 / 2 over triangles with corners (3, t) at x (n, 2)."""
    px, py = (column.take(corners) for column in np.ascontiguousarray(x.T))
    ux, uy = px[1] - px[0], py[1] - py[0]
    wx, wy = px[2] - px[0], py[2] - py[0]
    zx, zy = wx - ux, wy - uy
    area = np.maximum((ux * wy - uy * wx) / 2, FLATTEST * d.take(corners[0]) ** 2)
    squares = ux * ux + uy * uy + wx * wx + wy * wy + zx * zx + zy * zy
    to_eta = 1 / (4 * np.sqrt(3) * area)
    eta = squares * to_eta
    bounded = np.minimum(eta, WORST)
    cube = bounded * bounded * bounded
    steep = 4 * counts * (cube * cube * bounded)
    by_squares, by_area = 2 * steep * to_eta, steep * eta / (2 * area)
    # The sum of squares pulls each corner to the others, the area pushes it off the side across.
    pull = ((-ux - wx, -uy - wy), (ux - zx, uy - zy), (wx + zx, wy + zy))
    push = ((-zy, zx), (wy, -wx), (-uy, ux))
    parts = [
        [by_squares * toward[axis] - by_area * off[axis] for toward, off in zip(pull, push, strict=True)]
        for axis in range(2)
    ]
    return np.column_stack([_summed(corners, np.stack(along), len(x)) for along in parts])


def spacing_gradient(x: Floats, ends: Integers, contact: Floats) -> Floats:
    """Gradient (n, 2) of the sum of (l / l0 - 1)^2 over edges ``ends`` (2, m), with l0 = ``contact`` (m,)."""
    i, j = ends
    delta = [column.take(i) - column.take(j) for column in np.ascontiguousarray(x.T)]
    length = np.maximum(np.sqrt(delta[0] * delta[0] + delta[1] * delta[1]), SHORTEST * contact)
    weight = 2 * (length / contact - 1) / (contact * length)
    pulls = [weight * part for part in delta]
    return np.column_stack([_summed(ends, np.stack([pull, -pull]), len(x)) for pull in pulls])


def _summed(nodes: Integers, parts: Floats, n: int) -> Floats:
    """Sums (n,) of the parts (k, m) at k nodes (k, m) of each triangle or edge, one of these after the other."""
    return np.asarray(np.bincount(nodes.T.ravel(), parts.T.ravel(), minlength=n), float)
