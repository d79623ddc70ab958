"""A posteriori error estimate by the recovered gradient (Zienkiewicz and Zhu), and the true error where it is known.

The recovered gradient of a piecewise linear field is a continuous one, nearer to the truth than the field's own.
"""

from collections.abc import Callable

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.errors import CaseError
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.messages import place
from bubblemesh.records import record

SINGULAR = 1e-6  # least determinant of a patch whose linear fit is trusted, in terms of a regular hexagon's


@record
class Estimate:
    """Estimated error of a finite element solution, and the norm of its own gradient, both in L2."""

    indicators: Floats  # (t,) estimated error of the gradient in each triangle
    norm: float

    @property
    def error(self) -> float:
        """Estimated error in the whole domain."""
        return float(np.sqrt((self.indicators**2).sum()))

    @property
    def total(self) -> float:
        """Sum of the errors of the triangles."""
        return float(self.indicators.sum())

    @property
    def solution(self) -> float:
        """Estimated norm of the true gradient."""
        return float(np.hypot(self.norm, self.error))

    @property
    def relative(self) -> float:
        """Estimated error in terms of the true gradient's norm; 0 for a constant field."""
        return self.error / self.solution if self.solution > 0 else 0.0


def estimated(points: Floats, triangles: Integers, values: Floats, part: Integers | None = None) -> Estimate:
    """Estimate the error of the gradient of a piecewise linear solution with k components (n, k) at the points (n, 2).

    It is the distance of the solution's gradient from the recovered one. For a vector field the squares of all
    components are added up. Recovered gradients jump where the material ``part`` (t,) of the triangles changes.

    References
    ----------
    O. C. Zienkiewicz, J. Z. Zhu, "A simple error estimator and adaptive procedure for practical engineering analysis",
    Int. J. Numer. Meth. Eng. 24 (1987).
    """
    own = gradients(points, triangles, values - values[0])  # of what is the same everywhere no rounding shall be left
    split = (points, triangles) if part is None else split_nodes(points, triangles, part)
    recovered = recovered_gradients(*split, own)
    error = (recovered[split[1]] - own[:, None]).reshape(len(triangles), 3, -1)
    areas = np.abs(signed_areas(points, triangles))
    # Exact for the square of a linear function with these values at the corners.
    squares = areas / 12 * ((error**2).sum(axis=(1, 2)) + (error.sum(axis=1) ** 2).sum(axis=1))
    return Estimate(np.sqrt(squares), float(np.sqrt((areas * (own**2).sum(axis=(1, 2))).sum())))


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
    corner, n = triangles.ravel(), len(points)
    total = np.maximum(np.bincount(corner, area, n), np.finfo(float).tiny)
    return _summed(corner, area[:, None] * np.repeat(flat, 3, axis=0), n) / total[:, None]


def _summed(rows: Integers, values: Floats, n: int) -> Floats:
    """Sums (n, m) of values (k, m) by row."""
    return np.stack([np.bincount(rows, column, n) for column in values.T], axis=1)


# Points (barycentric) and weights of a rule that is exact for polynomials of degree 5.
NEAR, FAR = (6 - np.sqrt(15)) / 21, (6 + np.sqrt(15)) / 21
CORNERS = np.array([[1 / 3] * 3, *(np.roll([1 - 2 * a, a, a], k) for a in (NEAR, FAR) for k in range(3))])
WEIGHTS = np.array([9 / 40, *[(155 - np.sqrt(15)) / 1200] * 3, *[(155 + np.sqrt(15)) / 1200] * 3])
STEP = 1e-5  # of a triangle's size, for difference quotients


def true_error(points: Floats, triangles: Integers, values: Floats, exact: Callable[[Floats, Floats], Floats]) -> float:
    """Norm in L2 of the error of the gradient of a linear solution with values (n,), for the exact one at x and y (m,).

    CaseError, with the place, where the exact solution is no number.

    References
    ----------
    J. Radon, "Zur mechanischen Kubatur", Monatsh. Math. 52 (1948), for the quadrature.
    """
    own = gradients(points, triangles, values[:, None])[:, 0]
    areas = np.abs(signed_areas(points, triangles))
    step = STEP * np.sqrt(areas)
    total = 0.0
    for corners, weight in zip(CORNERS, WEIGHTS, strict=True):
        x, y = np.einsum("k,tkd->dt", corners, points[triangles])
        with np.errstate(over="ignore", invalid="ignore"):  # what is no number is refused below
            changes = exact(x + step, y) - exact(x - step, y), exact(x, y + step) - exact(x, y - step)
        slope = np.stack(changes, axis=1) / (2 * step)[:, None]
        bad = np.flatnonzero(~np.isfinite(slope).all(axis=1))
        if len(bad):
            raise CaseError(f"the exact solution has no gradient at {place((x[bad[0]], y[bad[0]]))}")
        total += weight * float(areas @ ((slope - own) ** 2).sum(axis=1))
    return float(np.sqrt(total))
