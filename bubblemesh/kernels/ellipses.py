"""Packing in a metric: flips of edges, motion and smoothing that invert no triangle, compiled or in NumPy alike.

Tensors are rows (m11, m12, m22).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.kernels.library import library

MOST_PASSES = 60
SURE = 1e-9  # of the terms of the circle test: what is nearer to 0 is rounding
FLATTEST = 1e-3  # area of a triangle that a flip makes, in terms of both
HALVINGS, MOST_TRIES = 4, 40  # of steps that would invert triangles, as in the C file
KEEP = 0.1  # of its area that each triangle keeps in a step
SHORTEST = 1e-9  # edge
MOST_MOVE = 0.5  # in a step
CUTOFF = 1.5  # length from which on edges do not pull
FOUR_ROOTS = 6.9282032302755088  # 4 sqrt(3)
TRUST = 0.2  # from its place to a centroid: farther away its metric is not known
DELTA = 0.01  # steps of differences
MOST_SMOOTHED, TRIES = 0.3, 4  # length of a step of the smoothing, and how often it is halved


def flipped(triangles: Integers, x: Floats, m: Floats, facets: Integers) -> tuple[Integers, Integers]:
    """Triangles (t, 3) between nodes x (n, 2) after flips that make them Delaunay in a metric, and their edges (e, 2).

    The metric of an edge between two triangles is the mean of the tensors m (n, 3) at their four nodes: the edge is
    flipped if the circle in it around one triangle holds the other's node. The facets (f, 2) stay. Flips come in passes
    in which no triangle changes twice; where the metric changes from edge to edge they need not end by themselves.
    """
    compiled = library()
    if compiled is None:
        return flipped_in_numpy(triangles, x, m, facets)
    result, edges, count = np.array(triangles, order="C"), np.empty((3 * len(triangles), 2), np.int64), np.zeros(1, int)
    given = np.ascontiguousarray(x), np.ascontiguousarray(m), len(facets), np.ascontiguousarray(facets)
    compiled.call("metric_flips", len(x), len(result), result, *given, MOST_PASSES, SURE, FLATTEST, edges, count)
    return result, edges[: count[0]].copy()


def flipped_in_numpy(triangles: Integers, x: Floats, m: Floats, facets: Integers) -> tuple[Integers, Integers]:
    """Triangles and edges as of `flipped`, made in NumPy."""
    triangles, n, t = triangles.copy(), len(x), len(triangles)
    ends = np.concatenate([facets, facets[:, ::-1]])
    held = np.sort(ends[:, 0] * n + ends[:, 1])
    for left in range(MOST_PASSES, -1, -1):
        sides = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        keys = sides[:, 0] * n + sides[:, 1]
        order = np.argsort(keys)
        place = np.minimum(np.searchsorted(keys[order], keys % n * n + keys // n), 3 * t - 1)
        other = order[place]
        other[keys[other] != keys % n * n + keys // n] = -1
        inner = np.flatnonzero((other > np.arange(3 * t)) & ~np.isin(keys, held))
        (row, k), (row2, k2) = np.divmod(inner, 3), np.divmod(other[inner], 3)
        a, b = sides[inner].T
        c, e = triangles[row, (k + 2) % 3], triangles[row2, (k2 + 2) % 3]
        wrong: list[int] = np.flatnonzero(_wrong(x, m, a, b, c, e)).tolist() if left else []
        changed, chosen = np.zeros(t, bool), list[int]()
        for number in wrong:
            if not (changed[row[number]] or changed[row2[number]]):
                changed[row[number]] = changed[row2[number]] = True
                chosen.append(number)
        if not chosen:
            break
        triangles[row[chosen]] = np.column_stack([a, e, c])[chosen]
        triangles[row2[chosen]] = np.column_stack([e, b, c])[chosen]
    return triangles, sides[(other < 0) | (other > np.arange(3 * t))]


def _wrong(x: Floats, m: Floats, a: Integers, b: Integers, c: Integers, e: Integers) -> Booleans:
    """Edges (k,) from a to b, between triangles (a, b, c) and (b, a, e), that have to be flipped."""
    m11, m12, m22 = (m[a] + m[b] + m[c] + m[e]).T
    r11 = np.sqrt(m11)
    r12 = m12 / r11
    r22 = np.sqrt(np.maximum(m22 - r12 * r12, np.finfo(float).tiny))

    def scaled(nodes: Integers) -> tuple[Floats, Floats]:
        dx, dy = (x[nodes] - x[e]).T
        return r11 * dx + r12 * dy, r22 * dy

    (ax, ay), (bx, by), (cx, cy) = scaled(a), scaled(b), scaled(c)
    bc, ca, ab = bx * cy - by * cx, cx * ay - cy * ax, ax * by - ay * bx
    aa, bb, cc = ax * ax + ay * ay, bx * bx + by * by, cx * cx + cy * cy
    value, whole = aa * bc + bb * ca + cc * ab, np.abs(ca) + np.abs(bc)
    scale = aa * np.abs(bc) + bb * np.abs(ca) + cc * np.abs(ab)
    return (value > SURE * scale) & (ca > FLATTEST * whole) & (bc > FLATTEST * whole)


def moved(x: Floats, move: Floats, triangles: Integers) -> tuple[Floats, Floats]:
    """Nodes (n, 2) after moves (n, 2) from x (n, 2) that invert no triangle (t, 3), and the shares (n,) of them made.

    A triangle keeps a tenth of its area: if it would not, its nodes go half as far, and stay where that is in vain.
    """
    compiled = library()
    if compiled is None:
        return moved_in_numpy(x, move, triangles)
    places, share = np.array(x, order="C"), np.empty(len(x))
    rows = len(x), len(triangles), np.ascontiguousarray(triangles)
    compiled.call("guarded_move", *rows, places, np.ascontiguousarray(move), KEEP, share)
    return places, share


def moved_in_numpy(x: Floats, move: Floats, triangles: Integers) -> tuple[Floats, Floats]:
    """Nodes and shares as of `moved`, made in NumPy."""
    share, least = np.ones(len(x)), KEEP * _doubled_areas(x, triangles)
    for tries in range(MOST_TRIES):
        places = x + share[:, None] * move
        bad = _doubled_areas(places, triangles) < least
        if not bad.any():
            return places, share
        nodes = triangles[bad]
        share[nodes] = share[nodes] / 2 if tries < HALVINGS else 0.0
    return x, np.zeros(len(x))


def _doubled_areas(x: Floats, triangles: Integers) -> Floats:
    a, b, c = (x[triangles[:, k]] for k in range(3))
    return np.asarray((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0]))


def relaxed(
    x: Floats, m: Floats, triangles: Integers, edges: Integers, fixed: int, steps: int, dt: float, c: float
) -> tuple[Floats, Floats]:
    """Nodes (n, 2) after steps of motion from rest at x (n, 2), and their mean speeds (steps,) in the metric.

    The force of equation (2.1) acts along the edges (e, 2) at their lengths in the tensors m (n, 3), damped by c; the
    first ``fixed`` nodes stay, and moves invert no triangle (t, 3).
    """
    compiled = library()
    if compiled is None:
        return relaxed_in_numpy(x, m, triangles, edges, fixed, steps, dt, c)
    places, speeds = np.array(x, order="C"), np.empty(steps)
    rows = len(x), len(triangles), np.ascontiguousarray(triangles), len(edges), np.ascontiguousarray(edges)
    bounds = CUTOFF, MOST_MOVE, KEEP, SHORTEST
    compiled.call("metric_relax", *rows, places, np.ascontiguousarray(m), fixed, steps, dt, c, *bounds, speeds)
    return places, speeds


def relaxed_in_numpy(
    x: Floats, m: Floats, triangles: Integers, edges: Integers, fixed: int, steps: int, dt: float, c: float
) -> tuple[Floats, Floats]:
    """Nodes and speeds as of `relaxed`, made in NumPy."""
    x, v, speeds, n, (i, j) = x.copy(), np.zeros_like(x), np.empty(steps), len(x), edges.T
    for step in range(steps):
        along = x[j] - x[i]
        first, last = (np.maximum(_lengths(m[k], along), SHORTEST) for k in (i, j))
        length = _mean_lengths(first, last)
        force = np.where(length < CUTOFF, ((1.25 * length - 2.375) * length) * length + 1.125, 0.0)
        force = force / length
        pulls = [np.bincount(j, force * part, n) - np.bincount(i, force * part, n) for part in along.T]
        v = (v + dt * np.column_stack(pulls)) / (1 + c * dt)
        v[:fixed] = 0
        v = (MOST_MOVE / np.maximum(_lengths(m, dt * v), MOST_MOVE))[:, None] * v
        x, share = moved_in_numpy(x, dt * v, triangles)
        v = v * share[:, None]
        speeds[step] = np.cumsum(_lengths(m, v))[-1] / n
    return x, speeds


def _lengths(m: Floats, vectors: Floats) -> Floats:
    (m11, m12, m22), (vx, vy) = m.T, vectors.T
    return np.asarray(np.sqrt(np.maximum(m11 * vx * vx + 2 * (m12 * vx * vy) + m22 * vy * vy, 0.0)))


class Metrics(NamedTuple):
    """Metrics around places: roots, as of `roots`, that are linear from there."""

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


def smoothed(
    x: Floats,
    triangles: Integers,
    inside: Metrics,
    own: Metrics,
    axes: Floats,
    groups: Sequence[Integers],
    sweeps: int,
    weight: float,
) -> Floats:
    """Nodes (n, 2) after sweeps over groups of them (k,), no two of a group in a triangle (t, 3), that lessen a sum.

    It is that of eta^4 over triangles, for the shape measure eta in the metric at the centroid, known around t places
    ``inside``, and of weight * (l^2 + 1 / l^2 - 2) over their sides, for the mean l of the lengths in the metrics of
    both ends, known around the ``own`` places of the nodes. Each node goes by Newton's method along its two ``axes``
    (n, 4), steps of length 1 as rows (ux, uy, vx, vy), as far as what is around it gets better: no triangle is
    inverted. With a second axis of 0 it goes along the first one only.
    """
    compiled = library()
    if compiled is None:
        return smoothed_in_numpy(x, triangles, inside, own, axes, groups, sweeps, weight)
    places, order = np.array(x, order="C"), np.concatenate([np.zeros(0, np.int64), *groups])
    rows = len(x), len(triangles), np.ascontiguousarray(triangles), places
    known = (np.ascontiguousarray(part) for part in (*inside, *own, axes))
    bounds = TRUST, DELTA, MOST_SMOOTHED, TRIES
    compiled.call("metric_smooth", *rows, *known, len(order), order, sweeps, float(weight), *bounds)
    return places


def smoothed_in_numpy(
    x: Floats,
    triangles: Integers,
    inside: Metrics,
    own: Metrics,
    axes: Floats,
    groups: Sequence[Integers],
    sweeps: int,
    weight: float,
) -> Floats:
    """Nodes as of `smoothed`, made in NumPy."""
    x = x.copy()
    touched = [np.flatnonzero(np.isin(triangles, group).any(axis=1)) for group in groups]
    around = [(group, triangles[rows], inside.select(rows)) for group, rows in zip(groups, touched, strict=True)]
    for _ in range(sweeps):
        for group, rows, known in around:
            _improve(x, group, rows, known, own, axes[group], weight)
    return x


def _improve(
    x: Floats, group: Integers, triangles: Integers, inside: Metrics, own: Metrics, axes: Floats, weight: float
) -> None:
    """Move the nodes of a group (k,) with triangles (t, 3) around, by steps of Newton's method along axes (k, 4)."""
    places, u, v = x[group].copy(), axes[:, :2], axes[:, 2:]

    def cost(at: Floats) -> Floats:
        x[group] = at
        each = costs_in(x, triangles, inside, own, weight)
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


def costs_in(x: Floats, triangles: Integers, inside: Metrics, own: Metrics, weight: float) -> Floats:
    """Terms (t,) of triangles (t, 3) with nodes x (n, 2) in the sum that `smoothed` lessens, in the same metrics."""
    (ax, ay), (bx, by), (ox, oy) = (x[node].T for node in triangles.T)
    root, far = inside.at(np.column_stack([(ax + bx + ox) / 3, (ay + by + oy) / 3]))
    r11, r12, r22 = root.T
    ux, uy = r11 * (bx - ax) + r12 * (by - ay), r22 * (by - ay)
    wx, wy = r11 * (ox - ax) + r12 * (oy - ay), r22 * (oy - ay)
    zx, zy, area = wx - ux, wy - uy, (ux * wy - uy * wx) / 2
    known = (r11 > 0) & (r22 > 0) & (area > 0) & (far <= TRUST * TRUST)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        eta = ((ux * ux + uy * uy) + (wx * wx + wy * wy) + (zx * zx + zy * zy)) / (FOUR_ROOTS * area)
        ab, bo, oa = _squared_sides(x, triangles, own)
        cost = eta * eta * (eta * eta) + weight * ((ab + 1 / ab) + (bo + 1 / bo) + (oa + 1 / oa) - 6)
    return np.where(known, cost, np.inf)


def _squared_sides(x: Floats, triangles: Integers, own: Metrics) -> list[Floats]:
    """Squares (t,) of the lengths of the three sides of triangles (t, 3), by the metrics of both ends."""
    root, _ = own.at(x)
    squares = list[Floats]()
    for i, j in zip(triangles.T, np.roll(triangles, -1, axis=1).T, strict=True):
        dx, dy = (x[j] - x[i]).T
        first, last = (_lengths_by(root[end], dx, dy) for end in (i, j))
        length = _mean_lengths(first, last)
        squares.append(length * length)
    return squares


def _lengths_by(root: Floats, dx: Floats, dy: Floats) -> Floats:
    r11, r12, r22 = root.T
    u, v = r11 * dx + r12 * dy, r22 * dy
    return np.asarray(np.sqrt(u * u + v * v))


def _mean_lengths(first: Floats, last: Floats) -> Floats:
    return np.asarray((2 * np.sqrt(first * last) + (first + last) / 2) / 3)
