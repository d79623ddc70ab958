"""A posteriori error estimate by the recovered gradient (Zienkiewicz and Zhu), and the true error where it is known."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bubblemesh.adaptivity.recovery import gradients, recovered_gradients, split_nodes
from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import CaseError
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.messages import place


@dataclass(frozen=True)
class Estimate:
    """Estimated error of a finite element solution.

    Attributes
    ----------
    indicators : (t,)
        Estimated error of the gradient in each triangle, in the norm of L2.
    norm : float
        The same norm of the solution's own gradient.
    """

    indicators: Floats
    norm: float

    @property
    def error(self) -> float:
        """Estimated error in the whole domain."""
        return float(np.sqrt((self.indicators**2).sum()))

    @property
    def solution(self) -> float:
        """Estimated norm of the true gradient."""
        return float(np.hypot(self.norm, self.error))

    @property
    def relative(self) -> float:
        """The error in terms of that; 0 for a constant field."""
        return self.error / self.solution if self.solution > 0 else 0.0


def estimated(points: Floats, triangles: Integers, values: Floats, part: Integers | None = None) -> Estimate:
    """Estimate the error of the gradient of a piecewise linear solution.

    It is the distance of the solution's gradient from the recovered one. For a vector field the squares of all
    components are added up.

    Parameters
    ----------
    points : (n, 2)
    triangles : (t, 3)
        Each has an area.
    values : (n, k)
        The k components of the solution at the points.
    part : (t,), optional
        Number of the material of each triangle: recovered gradients jump where it changes.

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
