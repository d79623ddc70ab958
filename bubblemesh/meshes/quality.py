"""Measures of a triangle mesh: shape of the triangles, valence of the nodes, spacing of the edges."""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.meshes.edges import numbered_edges, unique_edges

_DEGENERATE = 1e-14
_REGULAR_VALENCE = 6
_BINS = 10
TARGET_SPACING = "target_spacing"  # name of the wanted spacing of triangles in mesh files
_WORST = 5  # triangles that a report names


@dataclass(frozen=True)
class Shape:
    """Shape of the triangles of a mesh.

    Attributes
    ----------
    mean, min, p01 : float
        Mean, minimum and first percentile of the radius ratios.
    histogram : tuple of int
        Number of triangles in ten equal bins of radius ratio, from 0 to 1.
    irregular_fraction : float or None
        Share of the inner nodes whose valence is not six; None in a mesh without inner nodes.
    angle_min, angle_max : float
        Extreme angles in degrees.
    """

    mean: float
    min: float
    p01: float
    histogram: tuple[int, ...]
    irregular_fraction: float | None
    angle_min: float
    angle_max: float


@dataclass(frozen=True)
class SpacingFit:
    """Mean, standard deviation and outer percentiles of edge length over wanted spacing."""

    mean: float
    std: float
    p01: float
    p99: float


def radius_ratios(points: Floats, triangles: Integers) -> Floats:
    """Return twice the ratio of the inscribed to the circumscribed circle's radius of each triangle.

    Parameters
    ----------
    points : (n, 2)
    triangles : (t, 3)
        Node indices, in either orientation.

    Returns
    -------
    (t,)
        ``(b + c - a)(c + a - b)(a + b - c) / abc`` for sides a, b, c: 1 for an equilateral triangle and 0 for one
        whose area vanishes beside the square of its perimeter.

    References
    ----------
    D. A. Field, "Qualitative measures for initial meshes", Int. J. Numer. Meth. Eng. 47 (2000).
    """
    a, b, c = _sides(points, triangles)
    degenerate = np.abs(signed_areas(points, triangles)) <= _least_areas(points, triangles)
    product = np.where(degenerate, 1.0, a * b * c)
    return np.where(degenerate, 0.0, (b + c - a) * (c + a - b) * (a + b - c) / product)


def angles(points: Floats, triangles: Integers) -> Floats:
    """Return the (t, 3) angles in degrees at the nodes of each triangle; NaN beside a side of length zero."""
    a, b, c = _sides(points, triangles)
    with np.errstate(invalid="ignore", divide="ignore"):
        cosines = [(v * v + w * w - u * u) / (2 * v * w) for u, v, w in ((a, b, c), (b, c, a), (c, a, b))]
    return np.degrees(np.arccos(np.clip(np.stack(cosines, axis=1), -1, 1)))


def signed_areas(points: Floats, triangles: Integers) -> Floats:
    """Return the (t,) areas of the triangles, positive where the nodes turn counter-clockwise."""
    first, second, third = np.moveaxis(points[triangles], 1, 0)
    (ux, uy), (vx, vy) = (second - first).T, (third - first).T
    return np.asarray(0.5 * (ux * vy - uy * vx))


def inverted(points: Floats, triangles: Integers) -> Integers:
    """Return the indices (k,) of the triangles that turn the other way than most do, ascending.

    None is where all turn clockwise, which is merely another convention; flat triangles turn neither way.
    """
    areas, least = signed_areas(points, triangles), _least_areas(points, triangles)
    clockwise, others = areas < -least, areas > least
    return np.flatnonzero(clockwise if clockwise.sum() <= others.sum() else others)


def edge_means(triangles: Integers, values: Floats) -> Floats:
    """Mean (e,) of what the triangles at each edge have, for values (t,); the edges are those of `unique_edges`."""
    number = numbered_edges(triangles)[1].T.ravel()
    return np.bincount(number, np.tile(values, 3)) / np.bincount(number)


def shape_quality(points: Floats, triangles: Integers) -> Shape:
    """Summarize the shape of the triangles of a mesh.

    Parameters
    ----------
    points : (n, 2)
    triangles : (t, 3)
        At least one triangle.
    """
    ratios = radius_ratios(points, triangles)
    corner_angles = angles(points, triangles)
    # An equilateral triangle's ratio may exceed 1 by rounding, and still belongs to the last bin.
    histogram, _ = np.histogram(np.clip(ratios, 0, 1), bins=_BINS, range=(0, 1))
    return Shape(
        mean=float(ratios.mean()),
        min=float(ratios.min()),
        p01=float(np.quantile(ratios, 0.01)),
        histogram=tuple(int(count) for count in histogram),
        irregular_fraction=_irregular_fraction(len(points), triangles),
        angle_min=float(corner_angles.min()),
        angle_max=float(corner_angles.max()),
    )


def spacing_fit(points: Floats, edges: Integers, wanted: Floats) -> SpacingFit:
    """Compare the lengths of edges with the wanted spacing.

    Parameters
    ----------
    points : (n, 2)
    edges : (e, 2)
    wanted : (e,)
        Wanted spacing at the middle of each edge, same length unit as the points.
    """
    ratios = edge_ratios(points, edges, wanted)
    p01, p99 = np.quantile(ratios, [0.01, 0.99])
    return SpacingFit(mean=float(ratios.mean()), std=float(ratios.std()), p01=float(p01), p99=float(p99))


def edge_ratios(points: Floats, edges: Integers, wanted: Floats) -> Floats:
    """Return the length of each edge (e, 2) over the spacing (e,) wanted there."""
    return _lengths(points[edges[:, 1]] - points[edges[:, 0]]) / wanted


def spacing_ratios(points: Floats, triangles: Integers, wanted: Floats) -> Floats:
    """Return the mean edge length (t,) of each triangle over the spacing (t,) wanted there."""
    return sum(_sides(points, triangles), np.zeros(len(triangles))) / (3 * wanted)


def mesh_figures(
    points: Floats, triangles: Integers, spacing_between: Callable[[Floats], Floats] | None
) -> dict[str, Any]:
    """Figures of a mesh of any orientation, as a report holds them.

    Parameters
    ----------
    points : (n, 2)
    triangles : (t, 3)
    spacing_between : callable or None
        Wanted spacing (e,) of edges by their ends (e, 2, 2), to tell how well they keep it.
    """
    edges, count = unique_edges(triangles)
    figures = {
        "nodes": len(points),
        "triangles": len(triangles),
        "boundary_nodes": len(np.unique(edges[count == 1])),
        "quality": {
            **asdict(shape_quality(points, triangles)),
            "worst": [{"quality": q, "at": at} for q, at in worst_triangles(points, triangles, _WORST)],
        },
        "area": float(np.abs(signed_areas(points, triangles)).sum()),
    }
    if spacing_between is not None:
        figures["spacing"] = asdict(spacing_fit(points, edges, spacing_between(points[edges])))
    return figures


def worst_triangles(points: Floats, triangles: Integers, count: int) -> list[tuple[float, tuple[float, float]]]:
    """Return radius ratio and centroid (x, y) of the worst triangles, at most ``count``, the worst first."""
    ratios = radius_ratios(points, triangles)
    worst = np.argsort(ratios, kind="stable")[:count]
    centroids = points[triangles[worst]].mean(axis=1)
    return [(float(q), (float(x), float(y))) for q, (x, y) in zip(ratios[worst], centroids, strict=True)]


def _least_areas(points: Floats, triangles: Integers) -> Floats:
    """Areas (t,) up to which the triangles are flat."""
    return np.asarray(_DEGENERATE * sum(_sides(points, triangles)) ** 2)


def _sides(points: Floats, triangles: Integers) -> tuple[Floats, Floats, Floats]:
    first, second, third = np.moveaxis(points[triangles], 1, 0)
    return _lengths(third - second), _lengths(first - third), _lengths(second - first)


def _lengths(vectors: Floats) -> Floats:
    return np.hypot(vectors[:, 0], vectors[:, 1])


def _irregular_fraction(nodes: int, triangles: Integers) -> float | None:
    pairs, counts = unique_edges(triangles)
    valence = np.bincount(pairs.ravel(), minlength=nodes)
    inner = valence > 0
    inner[pairs[counts == 1].ravel()] = False
    return float(np.mean(valence[inner] != _REGULAR_VALENCE)) if inner.any() else None
