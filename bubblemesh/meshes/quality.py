"""Measures of a triangle mesh: shape of the triangles, valence of the nodes, spacing of the edges."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict
from functools import cached_property
from typing import Any

import numpy as np

from bubblemesh.arrays import Floats, Integers, each_once, gathered, quantile, taken
from bubblemesh.meshes.edges import numbered_edges, unique_edges
from bubblemesh.records import record

_DEGENERATE = 1e-14
REGULAR_VALENCE = 6
SHOWN_BINS = 10  # of the histogram of a report
TARGET_SPACING = "target_spacing"  # name of the target spacing of triangles in mesh files
LAYER = "layer"  # name of the field with the number of the boundary layer of each triangle, 0 outside of layers
WORST = 5  # triangles that a report names
RIGHT = 90 + 1e-9  # degrees, above which an angle is obtuse, and not a right one but for rounding
TRIANGLES_AT_A_TIME = 1 << 16  # triangles in a block, as arrays for all of them would take much memory

SpacingBetween = Callable[[Floats, Integers], Floats]  # of points (n, 2): the spacing (m,) at centroids of rows (m, k)


@record
class Shape:
    """Shape of the triangles of a mesh: mean, minimum and first percentile of the radius ratios, and what follows."""

    mean: float
    min: float
    p01: float
    histogram: tuple[int, ...]  # number of triangles in ten equal bins of radius ratio, from 0 to 1
    irregular_fraction: float | None  # of the inner nodes, whose valence is not six; None if there are no inner nodes
    valence_max: int  # most edges at a node
    angle_min: float  # in degrees
    angle_max: float


@record
class SpacingFit:
    """Mean, standard deviation and outer percentiles of edge length over target spacing."""

    mean: float
    std: float
    p01: float
    p99: float


@record(eq=False)
class Measures:
    """Measures of triangles of either orientation; each is computed when it is first used, and kept."""

    points: Floats  # (n, 2)
    triangles: Integers  # (t, 3)

    @cached_property
    def edges(self) -> tuple[Integers, Integers]:
        """Edges (e, 2) and the number (e,) of triangles at each, by `unique_edges`."""
        return unique_edges(self.triangles)

    @cached_property
    def sides(self) -> tuple[Floats, Floats, Floats]:
        """Lengths (t,) of the sides across from the first, second and third node."""
        first, second, third = np.moveaxis(gathered(self.points, self.triangles), 1, 0)
        return _lengths(third - second), _lengths(first - third), _lengths(second - first)

    @cached_property
    def signed_areas(self) -> Floats:
        """Areas (t,) of the triangles, positive where the nodes turn counter-clockwise."""
        return np.asarray(0.5 * doubled_areas(gathered(self.points, self.triangles)))

    @cached_property
    def least_areas(self) -> Floats:
        """Areas (t,) up to which the triangles are flat."""
        return np.asarray(_DEGENERATE * sum(self.sides) ** 2)

    @cached_property
    def radius_ratios(self) -> Floats:
        """Twice the ratio (t,) of the inscribed to the circumscribed circle's radius.

        It is ``(b + c - a)(c + a - b)(a + b - c) / abc`` for sides a, b, c: 1 for an equilateral triangle, and 0 for
        one whose area is within rounding of 0.

        References
        ----------
        D. A. Field, "Qualitative measures for initial meshes", Int. J. Numer. Meth. Eng. 47 (2000).
        """
        a, b, c = self.sides
        degenerate = np.abs(self.signed_areas) <= self.least_areas
        product = np.where(degenerate, 1.0, a * b * c)
        return np.where(degenerate, 0.0, (b + c - a) * (c + a - b) * (a + b - c) / product)

    @property
    def angles(self) -> Floats:
        """Angles (t, 3) in degrees at the nodes of each triangle; NaN beside a side of length zero."""
        return _angles(*self.sides)

    @cached_property
    def angle_range(self) -> tuple[float, float]:
        """Least and largest angle of all triangles, at least one; 0 and 180 if one has a side of length zero."""
        least, largest = zip(*((some.min(), some.max()) for some in self._angles_in_blocks()), strict=True)
        low, high = float(np.min(least)), float(np.max(largest))
        return (0.0, 180.0) if np.isnan(low) else (low, high)

    @property
    def obtuse_fraction(self) -> float:
        """Share of the triangles, at least one, with an angle above 90 degrees."""
        return sum(int((some > RIGHT).any(axis=1).sum()) for some in self._angles_in_blocks()) / len(self.triangles)

    def _angles_in_blocks(self) -> Iterator[Floats]:
        """Angles (b, 3) in degrees of blocks of triangles, in order."""
        parts = (slice(k, k + TRIANGLES_AT_A_TIME) for k in range(0, len(self.triangles), TRIANGLES_AT_A_TIME))
        return (_angles(*(side[part] for side in self.sides)) for part in parts)


def radius_ratios(points: Floats, triangles: Integers) -> Floats:
    """Radius ratios (t,) of triangles (t, 3) between points (n, 2), by `Measures`."""
    return Measures(points, triangles).radius_ratios


def angles(points: Floats, triangles: Integers) -> Floats:
    """Angles (t, 3) in degrees of triangles (t, 3) between points (n, 2), by `Measures`."""
    return Measures(points, triangles).angles


def signed_areas(points: Floats, triangles: Integers) -> Floats:
    """Signed areas (t,) of triangles (t, 3) between points (n, 2), by `Measures`."""
    return Measures(points, triangles).signed_areas


def doubled_areas(corners: Floats) -> Floats:
    """Twice the areas (t,) between the first three nodes (t, 3 or more, 2) of triangles, negative if clockwise."""
    (ax, ay), (bx, by), (cx, cy) = np.moveaxis(corners[:, :3], 0, -1)  # columns, for loops over all triangles
    return np.asarray((bx - ax) * (cy - ay) - (by - ay) * (cx - ax))


def inverted(points: Floats, triangles: Integers) -> Integers:
    """Indices (k,) of the triangles that turn the other way than most, ascending.

    If all turn clockwise, which is merely another convention, the result is empty. Flat triangles turn neither way.
    """
    measures = Measures(points, triangles)
    areas, least = measures.signed_areas, measures.least_areas
    clockwise, others = areas < -least, areas > least
    return np.flatnonzero(clockwise if clockwise.sum() <= others.sum() else others)


def edge_means(triangles: Integers, values: Floats) -> Floats:
    """Mean (e,) over the triangles at each edge, for values (t,) of triangles; edges are those of `unique_edges`."""
    number = numbered_edges(triangles)[1].T.ravel()
    return np.bincount(number, np.tile(values, 3)) / np.bincount(number)


def shape_quality(measures: Measures) -> Shape:
    """Shape of the triangles, at least one, of a mesh."""
    ratios, (least, largest) = measures.radius_ratios, measures.angle_range
    # The ratio of an equilateral triangle may exceed 1 by rounding; it belongs to the last bin.
    edges, triangles_at = measures.edges
    valence = np.bincount(edges.ravel(), minlength=len(measures.points))
    histogram, _ = np.histogram(np.clip(ratios, 0, 1), bins=SHOWN_BINS, range=(0, 1))
    return Shape(
        mean=float(ratios.mean()),
        min=float(ratios.min()),
        p01=quantile(ratios, 0.01),
        histogram=tuple(int(count) for count in histogram),
        irregular_fraction=_irregular_fraction(valence, taken(edges, triangles_at == 1)),
        valence_max=int(valence.max()),
        angle_min=least,
        angle_max=largest,
    )


def spacing_fit(points: Floats, edges: Integers, target: Floats) -> SpacingFit:
    """Comparison of the lengths of edges (e, 2) with the target spacing (e,) at their middles."""
    ratios = edge_ratios(points, edges, target)
    p01, p99 = quantile(ratios, 0.01), quantile(ratios, 0.99)
    return SpacingFit(mean=float(ratios.mean()), std=float(ratios.std()), p01=p01, p99=p99)


def edge_ratios(points: Floats, edges: Integers, target: Floats) -> Floats:
    """Length of each edge (e, 2) over the target spacing (e,) there."""
    lengths = np.empty(len(edges))
    for begin in range(0, len(edges), TRIANGLES_AT_A_TIME):
        part = slice(begin, begin + TRIANGLES_AT_A_TIME)
        ends = taken(points, edges[part])
        lengths[part] = _lengths(ends[:, 1] - ends[:, 0])
    return lengths / target


def spacing_ratios(points: Floats, triangles: Integers, target: Floats) -> Floats:
    """Mean edge length (t,) of each triangle over the target spacing (t,) there."""
    return sum(Measures(points, triangles).sides, np.zeros(len(triangles))) / (3 * target)


def mesh_figures(measures: Measures, spacing_between: SpacingBetween | None) -> dict[str, Any]:
    """Figures of a mesh of any orientation, as a report holds them.

    They include how well edges fit the spacing, if that is known: a function (e,) of points (n, 2) and edges (e, 2).
    """
    points, (edges, count) = measures.points, measures.edges
    return figures(
        nodes=len(points),
        triangles=len(measures.triangles),
        boundary_nodes=len(each_once(edges[count == 1].ravel())),
        bounds=(points.min(axis=0), points.max(axis=0)),
        shape=shape_quality(measures),
        worst=worst_triangles(measures, WORST),
        area=float(np.abs(measures.signed_areas).sum()),
        fit=None if spacing_between is None else spacing_fit(points, edges, spacing_between(points, edges)),
    )


def figures(
    *,
    nodes: int,
    triangles: int,
    boundary_nodes: int,
    bounds: tuple[Floats, Floats],
    shape: Shape,
    worst: Iterable[tuple[float, tuple[float, float]]],
    area: float,
    fit: SpacingFit | None,
) -> dict[str, Any]:
    """Figures of a mesh as a report holds them; the bounds are corners (2,), and the fit is that of a known spacing."""
    told = {
        "nodes": nodes,
        "triangles": triangles,
        "boundary_nodes": boundary_nodes,
        "bounds": (*bounds[0].tolist(), *bounds[1].tolist()),
        "quality": {**asdict(shape), "worst": [{"quality": q, "at": at} for q, at in worst]},
        "area": area,
    }
    return told if fit is None else told | {"spacing": asdict(fit)}


def worst_triangles(measures: Measures, count: int) -> list[tuple[float, tuple[float, float]]]:
    """Radius ratio and centroid (x, y) of the worst triangles, at most ``count``, the worst first."""
    ratios = measures.radius_ratios
    count = min(count, len(ratios))
    # Only triangles that are not better than the last of these are sorted.
    bad = np.flatnonzero(~(ratios > np.partition(ratios, count - 1)[count - 1]))
    worst = bad[np.argsort(ratios[bad], kind="stable")][:count]
    centroids = measures.points[measures.triangles[worst]].mean(axis=1)
    return [(float(q), (float(x), float(y))) for q, (x, y) in zip(ratios[worst], centroids, strict=True)]


def _angles(a: Floats, b: Floats, c: Floats) -> Floats:
    """Angles (t, 3) in degrees across from sides (t,) of triangles."""
    with np.errstate(invalid="ignore", divide="ignore"):
        cosines = [(v * v + w * w - u * u) / (2 * v * w) for u, v, w in ((a, b, c), (b, c, a), (c, a, b))]
    return np.degrees(np.arccos(np.clip(np.stack(cosines, axis=1), -1, 1)))


def _lengths(vectors: Floats) -> Floats:
    x, y = vectors.T
    return np.asarray(np.sqrt(x * x + y * y))  # several times as fast as hypot; the squares do not overflow


def _irregular_fraction(valence: Integers, rim: Integers) -> float | None:
    """Share of the inner nodes whose valence (n,) is not six, for edges (e, 2) at the rim; None without inner nodes."""
    inner = valence > 0
    inner[rim.ravel()] = False
    return float(np.mean(valence[inner] != REGULAR_VALENCE)) if inner.any() else None
