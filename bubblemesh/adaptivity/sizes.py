"""Sizes of triangles that spread the estimated error evenly."""

import numpy as np

from bubblemesh.adaptivity.estimate import Estimate
from bubblemesh.arrays import TINY, Floats, Integers
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.meshes.quality import signed_areas

FINER, COARSER = 1 / 16, 2.0  # of the present size in one go: an estimate says little about sizes far from it
TRIANGLES_PER_NODE = 2
NEGLIGIBLE_ERROR = 1e-12  # relative error, which may be rounding alone
SMOOTHINGS = 5


def equivalent_sizes(points: Floats, triangles: Integers) -> Floats:
    """Sides (t,) of equilateral triangles with the areas of the given ones."""
    return np.sqrt(4 / np.sqrt(3) * np.abs(signed_areas(points, triangles)))


def smooth_sizes(points: Floats, triangles: Integers) -> Floats:
    """Sizes (n,) of the triangles around the points (n, 2), averaged over a few rings of neighbours."""
    corner = triangles.ravel()
    number = np.maximum(np.bincount(corner, minlength=len(points)), 1)
    sizes = np.bincount(corner, np.repeat(np.log(equivalent_sizes(points, triangles)), 3), len(points)) / number
    i, j = unique_edges(triangles)[0].T
    number = 1 + np.bincount(np.append(i, j), minlength=len(points))
    for _ in range(SMOOTHINGS):
        sizes = (sizes + np.bincount(np.append(i, j), np.append(sizes[j], sizes[i]), len(points))) / number
    return np.exp(sizes)


def sizes_for_error(estimate: Estimate, sizes: Floats, error: float) -> Floats:
    """Sizes (t,) with which the fewest triangles lead to a requested error of the whole, from the present sizes (t,).

    With linear elements the error eta of a triangle whose size goes from h to h' becomes that of (h / h')^2 triangles,
    altogether eta h' / h.

    - The squares of these have to add up to that of the error E that is asked for.
    - The number of triangles is the sum of (h / h')^2. It is least where h' = h (t / eta)^(1/2), with t = E^2 / sum of
      eta: each new triangle has the same error t then. (With polynomials of degree p the exponent is 1 / (p + 1).)

    Sizes change by limited factors, so that the error may come out larger or smaller.
    """
    factor = min(error / max(estimate.error, TINY), 1.0)
    return _even(estimate, sizes, error**2 / max(estimate.total, TINY), factor)


def sizes_for_nodes(estimate: Estimate, sizes: Floats, nodes: int) -> Floats:
    """Sizes (t,) as by `sizes_for_error`, but for about N nodes, two triangles to each: t = sum of eta / 2 N."""
    triangles = TRIANGLES_PER_NODE * nodes
    return _even(estimate, sizes, estimate.total / triangles, float(np.sqrt(len(sizes) / triangles)))


def predicted_error(estimate: Estimate, sizes: Floats, target: Floats) -> float:
    """Estimated error in the whole domain once the present sizes (t,) have become the target ones (t,)."""
    return float(np.sqrt(((estimate.indicators * target / sizes) ** 2).sum()))


def _even(estimate: Estimate, sizes: Floats, each: float, factor: float) -> Floats:
    """Sizes (t,) that give each triangle the same error, as far as they may change.

    By how much all change alike is ``factor``; where there is no error they become as large as they may.
    """
    largest = COARSER * max(factor, 1.0)
    if estimate.relative <= NEGLIGIBLE_ERROR:
        return largest * sizes
    with np.errstate(divide="ignore"):
        times = np.sqrt(each / estimate.indicators)
    return sizes * np.clip(times, FINER * min(factor, 1.0), largest)
