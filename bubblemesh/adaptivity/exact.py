"""The true error of a solution, where the exact one is known."""

from collections.abc import Callable

import numpy as np

from bubblemesh.adaptivity.recovery import gradients
from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import CaseError
from bubblemesh.quality import signed_areas
from bubblemesh.wording import place

__all__ = ["true_error"]

# Points (barycentric) and weights of a rule that is exact for polynomials of degree 5.
NEAR, FAR = (6 - np.sqrt(15)) / 21, (6 + np.sqrt(15)) / 21
CORNERS = np.array([[1 / 3] * 3, *(np.roll([1 - 2 * a, a, a], k) for a in (NEAR, FAR) for k in range(3))])
WEIGHTS = np.array([9 / 40, *[(155 - np.sqrt(15)) / 1200] * 3, *[(155 + np.sqrt(15)) / 1200] * 3])
STEP = 1e-5  # of a triangle's size, for difference quotients


def true_error(points: Floats, triangles: Integers, values: Floats, exact: Callable[[Floats, Floats], Floats]) -> float:
    """Norm in L2 of the error of the gradient of a linear solution with values (n,).

    Parameters
    ----------
    points : (n, 2)
    triangles : (t, 3)
    values : (n,)
    exact : callable
        The exact solution (m,) at x (m,) and y (m,).

    Raises
    ------
    CaseError
        If it is no number somewhere; with the place.

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
        slope = np.column_stack(
            [
                (exact(x + step, y) - exact(x - step, y)) / (2 * step),
                (exact(x, y + step) - exact(x, y - step)) / (2 * step),
            ]
        )
        bad = np.flatnonzero(~np.isfinite(slope).all(axis=1))
        if len(bad):
            raise CaseError(f"the exact solution has no gradient at {place((x[bad[0]], y[bad[0]]))}")
        total += weight * float(areas @ ((slope - own) ** 2).sum(axis=1))
    return float(np.sqrt(total))
