"""Newton's method for shapes and lengths in a metric, which inverts no triangle, compiled or in NumPy alike."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.kernels.library import call, or_numpy
from bubblemesh.kernels.tensors import mean_lengths

FOUR_ROOTS = 6.9282032302755088  # 4 sqrt(3)
BEND = 1.25  # eta^4 from which on the term of a shape is linear: that of two triangles that share a right angle
TRUST = 0.2  # farthest distance from a place to a centroid at which the metric of the place still holds
DELTA = 0.01  # steps of differences
MOST_SMOOTHED, TRIES = 0.3, 4  # length of a step, and how often it is halved


class Metrics(NamedTuple):
    """Metrics around places: their roots (`tensors.roots`) change linearly with the distance from there."""

    places: Floats  # (k, 2)
    roots: Floats  # (k, 3)
    slopes: Floats  # (k, 6): changes of the root over a length of 1 in each of the two axes that it maps to x and y

    def at(self, x: Floats) -> tuple[Floats, Floats]:
        """Roots (k, 3) at x (k, 2), and the squares (k,) of the distances to there."""
        (cx, cy), (r11, r12, r22), s = (x - self.places).T, self.roots.T, self.slopes.T
        f, g = r11 * cx + r12 * cy, r22 * cy
        changed = r11 + (s[0] * f + s[3] * g), r12 + (s[1] * f + s[4] * g), r22 + (s[2] * f + s[5] * g)
        return np.column_stack(changed), f * f + g * g

    @property
    def axes(self) -> Floats:
        """Two steps of length 1 from each place, as rows (ux, uy, vx, vy): its root maps them to the axes x and y."""
        r11, r12, r22 = self.roots.T
        return np.column_stack([1 / r11, np.zeros(len(r11)), -r12 / (r11 * r22), 1 / r22])

    def select(self, numbers: Integers) -> "Metrics":
        """Metrics of the given numbers (m,)."""
        return Metrics(*(part[numbers] for part in self))


class SmoothingTerms(NamedTuple):
    """Terms of a sum over triangles.

    - For each triangle the k-th power of eta^4 over k, for the shape measure eta in the metric at the centroid, and
      linear in eta^4 beyond a ``bend``: a bad triangle does not outweigh all others. k is 2, or 8 if the ``worst``
      count most.
    - For each side, weight * (l - 1 / l)^2, for the mean l of its lengths in the metrics of both ends, beyond what that
      is for the length ``free``: from 1 / free to free lengths cost nothing.
    """

    weight: float
    free: float = 1.0
    worst: bool = False
    bend: float = BEND

    def of_shapes(self, power: Floats) -> Floats:
        """Terms (t,) of shapes by eta^4 (t,)."""
        curved = np.minimum(power, self.bend)
        square = curved * curved
        raised = square * square * (square * square) if self.worst else square
        return np.asarray(raised * (0.125 if self.worst else 0.5) + raised / curved * (power - curved))

    def of_sides(self, squared: Floats) -> Floats:
        """Terms (t,) of sides by the squares (t,) of their lengths, without the weight."""
        return np.maximum(squared + 1 / squared - 2 - self.slack, 0.0)

    @property
    def slack(self) -> float:
        """What lengths cost that are as good as any."""
        return (self.free - 1 / self.free) ** 2


class Newton(NamedTuple):
    """Newton's method that moves nodes, one group after the other, so that the sum of `SmoothingTerms` decreases.

    Each node moves along its two axes, and only as far as the terms around it decrease, so that no triangle is
    inverted. An axis of 0 is left out.
    """

    triangles: Integers  # (t, 3)
    inside: Metrics  # around t places inside the triangles
    own: Metrics  # around n places of the nodes
    axes: Floats  # (n, 4): two steps of length 1 of each node, as rows (ux, uy, vx, vy)
    groups: Sequence[Integers]  # nodes (k,) of each, no two of which are in a triangle
    terms: SmoothingTerms

    def moved_in_numpy(self, x: Floats, sweeps: int) -> Floats:
        """The same as `moved`, in NumPy."""
        x = x.copy()
        touched = [np.flatnonzero(np.isin(self.triangles, group).any(axis=1)) for group in self.groups]
        around = [
            (group, self.triangles[rows], self.inside.select(rows))
            for group, rows in zip(self.groups, touched, strict=True)
        ]
        for _ in range(sweeps):
            for group, triangles, inside in around:
                _improve(x, group, triangles, inside, self.own, self.axes[group], self.terms)
        return x

    @or_numpy(moved_in_numpy)
    def moved(self, x: Floats, sweeps: int) -> Floats:
        """Places (n, 2) of the nodes after so many sweeps over all groups from x (n, 2)."""
        places, order = np.array(x, order="C"), np.concatenate([np.zeros(0, np.int64), *self.groups])
        call(
            "metric_smooth",
            n=len(x),
            t=len(self.triangles),
            triangles=np.ascontiguousarray(self.triangles),
            x=places,
            axes=np.ascontiguousarray(self.axes),
            count=len(order),
            order=order,
            sweeps=sweeps,
            **_arguments(self.inside, self.own, self.terms),
            delta=DELTA,
            most=MOST_SMOOTHED,
            tries=TRIES,
        )
        return places


def _improve(
    x: Floats,
    group: Integers,
    triangles: Integers,
    inside: Metrics,
    own: Metrics,
    axes: Floats,
    terms: SmoothingTerms,
) -> None:
    """Move the nodes of a group (k,) with triangles (t, 3) around, by steps of Newton's method along axes (k, 4)."""
    places, u, v = x[group].copy(), axes[:, :2], axes[:, 2:]

    def cost(at: Floats) -> Floats:
        x[group] = at
        each = costs_in_numpy(x, triangles, inside, own, terms)
        return np.asarray(np.bincount(triangles.ravel(), np.repeat(each, 3), len(x))[group], np.float64)

    with np.errstate(invalid="ignore"):
        here = cost(places)
        ahead, behind = cost(places + DELTA * u), cost(places - DELTA * u)
        over, under = cost(places + DELTA * v), cost(places - DELTA * v)
        h1, h2 = (ahead + behind - 2 * here) / (DELTA * DELTA), (over + under - 2 * here) / (DELTA * DELTA)
        a = -(ahead - behind) / (2 * DELTA) / np.where(h1 > 1, h1, 1)
        b = -(over - under) / (2 * DELTA) / np.where(h2 > 1, h2, 1)
    going = np.isfinite(a) & np.isfinite(b)
    a, b = np.where(going, a, 0), np.where(going, b, 0)
    share = MOST_SMOOTHED / np.maximum(np.sqrt(a * a + b * b), MOST_SMOOTHED)
    for _ in range(TRIES):
        (ux, uy), (vx, vy) = u.T, v.T
        trial = np.column_stack([places[:, 0] + share * (a * ux + b * vx), places[:, 1] + share * (a * uy + b * vy)])
        better = going & (cost(np.where(going[:, None], trial, places)) < here)
        places[better], going = trial[better], going & ~better
        share = share / 2
    x[group] = places


def costs_in_numpy(x: Floats, triangles: Integers, inside: Metrics, own: Metrics, terms: SmoothingTerms) -> Floats:
    """The same as `costs_in`, in NumPy."""
    (ax, ay), (bx, by), (ox, oy) = (x[node].T for node in triangles.T)
    root, far = inside.at(np.column_stack([(ax + bx + ox) / 3, (ay + by + oy) / 3]))
    r11, r12, r22 = root.T
    ux, uy = r11 * (bx - ax) + r12 * (by - ay), r22 * (by - ay)
    wx, wy = r11 * (ox - ax) + r12 * (oy - ay), r22 * (oy - ay)
    zx, zy, area = wx - ux, wy - uy, (ux * wy - uy * wx) / 2
    known = (r11 > 0) & (r22 > 0) & (area > 0) & (far <= TRUST * TRUST)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        eta = ((ux * ux + uy * uy) + (wx * wx + wy * wy) + (zx * zx + zy * zy)) / (FOUR_ROOTS * area)
        ab, bo, oa = (terms.of_sides(side) for side in _squared_sides(x, triangles, own))
        cost = terms.of_shapes(eta * eta * (eta * eta)) + terms.weight * (ab + bo + oa)
    return np.where(known, cost, np.inf)


@or_numpy(costs_in_numpy)
def costs_in(x: Floats, triangles: Integers, inside: Metrics, own: Metrics, terms: SmoothingTerms) -> Floats:
    """Terms (t,) of triangles (t, 3) with nodes x (n, 2), those of sides among them, in metrics as of `Newton`."""
    result = np.empty(len(triangles))
    call(
        "metric_costs",
        n=len(x),
        t=len(triangles),
        triangles=np.ascontiguousarray(triangles),
        x=np.ascontiguousarray(x),
        **_arguments(inside, own, terms),
        costs=result,
    )
    return result


def _arguments(inside: Metrics, own: Metrics, terms: SmoothingTerms) -> dict[str, Floats | float]:
    """What compiled kernels take of metrics and terms."""
    return {
        "inside": np.ascontiguousarray(inside.places),
        "inside_roots": np.ascontiguousarray(inside.roots),
        "inside_slopes": np.ascontiguousarray(inside.slopes),
        "own": np.ascontiguousarray(own.places),
        "own_roots": np.ascontiguousarray(own.roots),
        "own_slopes": np.ascontiguousarray(own.slopes),
        "weight": float(terms.weight),
        "slack": terms.slack,
        "bend": terms.bend,
        "trust": TRUST,
        "worst": int(terms.worst),
    }


def _squared_sides(x: Floats, triangles: Integers, own: Metrics) -> list[Floats]:
    """Squares (t,) of the lengths of the three sides of triangles (t, 3), by the metrics of both ends."""
    root, _ = own.at(x)
    squares = list[Floats]()
    for i, j in zip(triangles.T, np.roll(triangles, -1, axis=1).T, strict=True):
        dx, dy = (x[j] - x[i]).T
        first, last = (_lengths_by(root[end], dx, dy) for end in (i, j))
        length = mean_lengths(first, last)
        squares.append(length * length)
    return squares


def _lengths_by(root: Floats, dx: Floats, dy: Floats) -> Floats:
    r11, r12, r22 = root.T
    u, v = r11 * dx + r12 * dy, r22 * dy
    return np.asarray(np.sqrt(u * u + v * v))
