"""What every mesh must hold, by a check that shares no code with the program."""

from typing import Any

import numpy as np
import shapely

AREA = 1e-12  # relative, of the triangles against the domain's
ROUNDING = 4e-16  # of the squared size of the coordinates


def faults(points: Any, triangles: Any, facets: Any, area: float | None) -> list[str]:
    """What is wrong with a mesh; ``area`` is that of a domain with straight sides."""
    found = []
    a, b, c = (points[triangles[:, k]] for k in range(3))
    doubled = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    if not np.isfinite(points).all():
        found.append("a coordinate is not finite")
    if (doubled <= 0).any():
        found.append(f"{(doubled <= 0).sum()} triangles are flat or clockwise")
    if len(np.unique(triangles)) != len(points):
        found.append("a node is unused")
    if len(np.unique(points, axis=0)) != len(points):
        found.append("two nodes are at one place")
    sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    if len(np.unique(sides, axis=0)) != len(sides):
        found.append("two triangles are on one side of an edge")
    n = len(points)
    single = np.setdiff1d(sides @ [n, 1], sides[:, ::-1] @ [n, 1])
    if not np.array_equal(np.sort(facets @ [n, 1]), single):
        found.append("the boundary edges are not the free edges of the triangles")
    total = doubled.sum() / 2
    rounding = ROUNDING * np.abs(points).max() ** 2 * np.sqrt(n)
    rim = points[facets]
    polygon = np.sum(rim[:, 0, 0] * rim[:, 1, 1] - rim[:, 0, 1] * rim[:, 1, 0]) / 2
    for what, expected in (("polygon of the boundary nodes", polygon), ("domain", area)):
        if expected is not None and abs(total - expected) > AREA * abs(expected) + rounding:
            found.append(f"the area differs from that of the {what} by {total / expected - 1:.1e}")
    if shapely.STRtree(shapely.linestrings(rim)).query(shapely.linestrings(rim), predicate="crosses").size:
        found.append("boundary edges cross")
    return found
