"""Means of a function over the cells of a mesh's nodes; the cell of a node has a third of each triangle around.

The sum of means times areas is the integral over the mesh, so that the sea of the mesh holds the right amount of water.
"""

from collections.abc import Callable

import numpy as np

from bubblemesh.arrays import GAUSS, Floats, Integers, cross, members

MOST = 64  # parts along each side of a triangle's third
PLACES_AT_A_TIME = 1 << 20  # places

Function = Callable[[Floats, Floats], Floats]  # values (m,) at x (m,) and y (m,)


def cell_means(points: Floats, triangles: Integers, function: Function, across: float) -> Floats:
    """Means (n,) of a function over the cells of the nodes at points (n, 2) of triangles (t, 3).

    The third of a triangle is a quadrilateral, which is divided into parts no longer than ``across``, the length over
    which the function is nearly linear. Each part has two by two Gauss points: means of linear functions are exact.
    """
    corners = points[triangles]
    middles = (corners + np.roll(corners, -1, axis=1)) / 2
    centre = np.broadcast_to(corners.mean(axis=1, keepdims=True), corners.shape)
    thirds = np.stack([corners, middles, centre, np.roll(middles, 1, axis=1)], axis=2).reshape(-1, 4, 2)
    node = triangles.ravel()
    longest = np.hypot(*np.moveaxis(thirds - np.roll(thirds, -1, axis=1), 2, 0)).max(axis=1)
    parts = np.clip(np.ceil(longest / across), 1, MOST).astype(np.int64)
    total, area = np.zeros(len(points)), np.zeros(len(points))
    for count in np.unique(parts).tolist():
        mine = np.flatnonzero(parts == count)
        for some in np.array_split(mine, -(-len(mine) * 4 * count**2 // PLACES_AT_A_TIME)):
            places, weights = _quadrature(thirds[some], count)
            x, y = np.moveaxis(places, 2, 0)
            values = np.broadcast_to(np.asarray(function(x.ravel(), y.ravel()), float), x.size).reshape(x.shape)
            total += np.bincount(node[some], (weights * values).sum(axis=1), len(points))
            area += np.bincount(node[some], weights.sum(axis=1), len(points))
    return total / np.where(area > 0, area, 1)


def _quadrature(quads: Floats, count: int) -> tuple[Floats, Floats]:
    """Places (k, m, 2) and weights (k, m) in quadrilaterals (k, 4, 2), for so many parts along each of their sides."""
    part, rank = members(np.full(count, 2))
    at = (part + GAUSS[rank]) / count
    s, t = (each.ravel() for each in np.meshgrid(at, at))
    shares = np.stack([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t], axis=1)
    a, b, c, d = np.moveaxis(quads[:, :, None], 1, 0)
    along = (1 - t)[:, None] * (b - a) + t[:, None] * (c - d)
    up = (1 - s)[:, None] * (d - a) + s[:, None] * (c - b)
    weights = np.abs(cross(along, up)) / len(s)
    return np.einsum("mj,kjc->kmc", shares, quads), weights
