"""Recovered gradient of a piecewise linear field: a continuous one, nearer to the truth than the field's own."""

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.meshes.quality import signed_areas

SINGULAR = 1e-6  # least determinant of a patch whose linear fit is trusted, in terms of a regular hexagon's


def gradients(points: Floats, triangles: Integers, values: Floats) -> Floats:
    """Gradients (t, k, 2) in the triangles (t, 3) of k fields with values (n, k) at the points (n, 2)."""
    x, u = points[triangles], values[triangles]
    # The gradient of a corner's hat function is the side across, turned by a right angle, over twice the area.
    across = np.roll(x, 1, axis=1) - np.roll(x, -1, axis=1)
    hats = np.stack([-across[..., 1], across[..., 0]], axis=-1) / (2 * signed_areas(points, triangles))[:, None, None]
    return np.einsum("tik,tid->tkd", u, hats)


def recovered_gradients(points: Floats, triangles: Integers, own: Floats) -> Floats:
    """Gradients (n, k, 2) at the points by superconvergent patch recovery.

    In the patch of triangles around an inner point a linear polynomial is fitted to the gradients ``own`` (t, k, 2) at
    the centroids. A point on the boundary has the mean of what the polynomials of the inner points next to it give
    there; one without such a neighbour has the mean of its triangles, by area.

    References
    ----------
    O. C. Zienkiewicz, J. Z. Zhu, "The superconvergent patch recovery and a posteriori error estimates. Part 1: The
    recovery technique", Int. J. Numer. Meth. Eng. 33 (1992).
    """
    n, flat = len(points), own.reshape(len(own), -1)
    pairs, count = unique_edges(triangles)
    fits, scale, sound = _patch_fits(points, triangles, flat)
    sound[pairs[count == 1]] = False
    result = _averaged(points, triangles, flat)
    result[sound] = fits[sound, 0]
    first, second = np.concatenate([pairs, pairs[:, ::-1]]).T
    there = sound[second] & ~sound[first]
    first, second = first[there], second[there]
    way = (points[first] - points[second]) / scale[second, None]
    extended = fits[second, 0] + way[:, :1] * fits[second, 1] + way[:, 1:] * fits[second, 2]
    number = np.bincount(first, minlength=n)
    reached = number > 0
    result[reached] = _summed(first, extended, n)[reached] / number[reached, None]
    return result.reshape(n, *own.shape[1:])


def split_nodes(points: Floats, triangles: Integers, part: Integers) -> tuple[Floats, Integers]:
    """Points (m, 2) and triangles (t, 3) of the same mesh in which triangles of different parts (t,) share no point.

    Gradients jump where the material changes: they have to be recovered on each side alone.
    """
    key = triangles * (part.max(initial=0) + 1) + part[:, None]
    keys, split = np.unique(key, return_inverse=True)
    return points[keys // (part.max(initial=0) + 1)], split.reshape(-1, 3)


def _patch_fits(points: Floats, triangles: Integers, flat: Floats) -> tuple[Floats, Floats, Booleans]:
    """Coefficients (n, 3, m) of a + b (x - xi) / h + c (y - yi) / h around each point, h (n,), and which are sound."""
    n, corner = len(points), triangles.ravel()
    triangle = np.repeat(np.arange(len(triangles)), 3)
    way = points[triangles].mean(axis=1)[triangle] - points[corner]
    scale = np.zeros(n)
    np.maximum.at(scale, corner, np.hypot(*way.T))
    way = way / scale[corner, None]
    basis = np.column_stack([np.ones(len(way)), way])
    normal = _summed(corner, (basis[:, :, None] * basis[:, None, :]).reshape(-1, 9), n).reshape(n, 3, 3)
    right = _summed(corner, (basis[:, :, None] * flat[triangle][:, None, :]).reshape(len(basis), -1), n)
    sound: Booleans = np.asarray(np.linalg.det(normal) > SINGULAR * 6 * 3 * 3)
    normal[~sound] = np.eye(3)
    return np.asarray(np.linalg.solve(normal, right.reshape(n, 3, -1)), float), scale, sound


def _averaged(points: Floats, triangles: Integers, flat: Floats) -> Floats:
    """Means (n, m) of the gradients around each point, weighted by area; zero at points of no triangle."""
    area = np.repeat(np.abs(signed_areas(points, triangles)), 3)
    corner = triangles.ravel()
    total = np.bincount(corner, area, len(points))
    return (
        _summed(corner, area[:, None] * np.repeat(flat, 3, axis=0), len(points))
        / np.maximum(total, np.finfo(float).tiny)[:, None]
    )


def _summed(rows: Integers, values: Floats, n: int) -> Floats:
    """Sums (n, m) of values (k, m) by row."""
    return np.stack([np.bincount(rows, column, n) for column in values.T], axis=1)
