"""Figures of layers, and faults of their mesh, from nodes and triangles alone."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from benchmarks.layers.made import Made
from benchmarks.robustness.soundness import faults
from bubblemesh.arrays import Booleans, Floats, Integers

NEARLY = 0.05  # relative difference of a height or a growth from the wanted one
MATCH = 1e-9  # of nodes on periodic sides
FLAT = 0.5  # height over width of triangles that count as layers


@dataclass(frozen=True)
class Figures:
    """What layers of a mesh are like.

    Attributes
    ----------
    nodes : int
    least, mean, largest : float
        First height over the wanted one, of the edges of the walls; the mean is by length.
    kept : float
        Share of the walls' length with the first height within 5 %.
    growth : float
        Median ratio of successive heights.
    steady : float
        Share of these ratios within 5 % of the wanted one.
    upright, least_upright : float
        Mean and least angle in degrees between the first layer's columns and the wall.
    aspect : float
        Largest ratio of an edge of the wall to the height above.
    """

    nodes: int
    least: float
    mean: float
    largest: float
    kept: float
    growth: float
    steady: float
    upright: float
    least_upright: float
    aspect: float


class Sides:
    """Finds the triangle on the left of a directed edge."""

    def __init__(self, triangles: Integers, nodes: int):
        self.triangles, self.nodes = triangles, nodes
        keys = (triangles * nodes + np.roll(triangles, -1, axis=1)).ravel()
        self._order = np.argsort(keys, kind="stable")
        self._keys = keys[self._order]

    def apex(self, edges: Integers) -> Integers:
        """Third nodes (k,) of the triangles on the left of edges (k, 2); -1 where there is none."""
        sought = edges[:, 0] * self.nodes + edges[:, 1]
        at = np.minimum(np.searchsorted(self._keys, sought), len(self._keys) - 1)
        side = self._order[at]
        return np.where(self._keys[at] == sought, self.triangles[side // 3, (side + 2) % 3], -1)


def wrong(made: Made, keys: Mapping[str, Any]) -> list[str]:
    """What is wrong with a mesh of a case."""
    facets = _oriented(made)
    found = faults(made.points, made.triangles, facets, straight_area(keys))
    lost = (Sides(made.triangles, len(made.points)).apex(_both_ways(made.walls)).reshape(2, -1) < 0).all(axis=0)
    if lost.any():
        found.append(f"{lost.sum()} edges of walls are not in the mesh")
    if "periodic" in keys["domain"] and not _matching(made):
        found.append("nodes on periodic sides differ")
    return found


def straight_area(keys: Mapping[str, Any]) -> float | None:
    """Area of the domain of a case, unless it has curves."""
    domain = keys["domain"]
    rings = [domain["outer"], *domain.get("holes", ())]
    if any("polygon" not in ring or "smooth" in ring for ring in rings):
        return None
    outer, *holes = (ring["polygon"] for ring in rings)
    return float(shapely.Polygon(outer, holes).area)


def measured(made: Made, keys: Mapping[str, Any]) -> Figures:
    """Figures of the layers of a mesh of a case."""
    (entry,) = keys["layers"]
    sides = Sides(made.triangles, len(made.points))
    edges = _both_ways(made.walls)
    edges = edges[sides.apex(edges) >= 0]
    apex = sides.apex(edges)
    length, height = _length(made.points, edges), _height(made.points, edges, apex)
    ratio = height / entry["first"]
    angle = _upright(made.points, edges, apex)
    steps = _steps(made.points, sides, edges, entry["count"])
    return Figures(
        nodes=len(made.points),
        least=float(ratio.min()),
        mean=float(np.average(ratio, weights=length)),
        largest=float(ratio.max()),
        kept=float(length[np.abs(ratio - 1) <= NEARLY].sum() / length.sum()),
        growth=float(np.median(steps)),
        steady=float((np.abs(steps / entry["growth"] - 1) <= NEARLY).mean()),
        upright=float(np.average(angle, weights=length)),
        least_upright=float(angle.min()),
        aspect=float((length / height).max()),
    )


def _oriented(made: Made) -> Integers:
    """Boundary edges (b, 2) with the mesh on their left, where it has them."""
    there = Sides(made.triangles, len(made.points)).apex(made.facets) >= 0
    return np.where(there[:, None], made.facets, made.facets[:, ::-1])


def _both_ways(edges: Integers) -> Integers:
    return np.concatenate([edges, edges[:, ::-1]])


def _matching(made: Made) -> bool:
    """Whether the nodes on the left and on the right end of the domain have the same heights."""
    x, y = made.points.T
    left, right = (np.sort(y[np.abs(x - end) < MATCH]) for end in (x.min(), x.max()))
    return len(left) == len(right) and bool((np.abs(left - right) < MATCH).all())


def _length(points: Floats, edges: Integers) -> Floats:
    return np.hypot(*(points[edges[:, 1]] - points[edges[:, 0]]).T)


def _height(points: Floats, edges: Integers, apex: Integers) -> Floats:
    """Heights (k,) of nodes above edges."""
    along, over = points[edges[:, 1]] - points[edges[:, 0]], points[apex] - points[edges[:, 0]]
    return (along[:, 0] * over[:, 1] - along[:, 1] * over[:, 0]) / np.hypot(*along.T)


def _left_shorter(points: Floats, edges: Integers, apex: Integers) -> Booleans:
    """Mask (k,) of the edges at whose start, rather than at whose end, the column stands: that side is shorter."""
    return _length(points, np.column_stack([edges[:, 0], apex])) < _length(points, np.column_stack([edges[:, 1], apex]))


def _upright(points: Floats, edges: Integers, apex: Integers) -> Floats:
    """Angles (k,) in degrees between edges of the wall and the columns on them."""
    foot = np.where(_left_shorter(points, edges, apex), edges[:, 0], edges[:, 1])
    along, up = points[edges[:, 1]] - points[edges[:, 0]], points[apex] - points[foot]
    sine = (along[:, 0] * up[:, 1] - along[:, 1] * up[:, 0]) / np.hypot(*along.T) / np.hypot(*up.T)
    return np.degrees(np.arcsin(np.clip(sine, -1, 1)))


def _steps(points: Floats, sides: Sides, edges: Integers, count: int) -> Floats:
    """Ratios of successive heights, up from edges of the wall: of two triangles each, which share their diagonal."""
    ratios, below = list[Floats](), np.full(len(edges), np.nan)
    for _ in range(count):
        apex = sides.apex(edges)
        height = np.where(apex >= 0, _height(points, edges, apex), np.inf)
        flat = height < FLAT * _length(points, edges)  # what is higher lies beside the layers
        edges, apex, below, height = edges[flat], apex[flat], below[flat], height[flat]
        ratios.append(height / below)
        left = _left_shorter(points, edges, apex)[:, None]
        over = sides.apex(np.where(left, np.column_stack([apex, edges[:, 1]]), np.column_stack([edges[:, 0], apex])))
        top = np.where(left, np.column_stack([apex, over]), np.column_stack([over, apex]))
        edges, below = top[over >= 0], height[over >= 0]
    found = np.concatenate(ratios)
    return found[np.isfinite(found)]
