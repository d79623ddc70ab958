"""Constrained Delaunay triangulation, by pythoncdt (exact predicates)."""

import re

import numpy as np
import pythoncdt as cdt

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import GeometryError
from bubblemesh.wording import place

__all__ = ["circumcircles", "linked", "sorted_triangles", "triangulated"]


def triangulated(points: Floats, constraints: Integers) -> Integers:
    """Sorted triangles (t, 3) of the constrained Delaunay triangulation; see ``linked``."""
    return sorted_triangles(linked(points, constraints)[0])


def linked(points: Floats, constraints: Integers) -> tuple[Integers, Integers]:
    """Constrained Delaunay triangulation of the region that the constraints enclose.

    Parameters
    ----------
    points : (n, 2)
        Finite and all different.
    constraints : (e, 2)
        Edges that form closed rings without crossings; the region is what an odd number of rings encloses.

    Returns
    -------
    triangles : (t, 3)
        Counter-clockwise, in the library's order; each constraint is an edge of exactly one of them.
    edges : (m, 2)
        Every edge of the triangles once.

    Raises
    ------
    GeometryError
        If points coincide or constraints cross, with the coordinates.
    """
    if not np.isfinite(points).all():  # the library would run out of memory
        raise ValueError("points must be finite")
    mesh = cdt.Triangulation(cdt.VertexInsertionOrder.AUTO, cdt.IntersectingConstraintEdges.NOT_ALLOWED, 0.0)
    try:
        mesh.insert_vertices(np.ascontiguousarray(points))  # type: ignore[call-overload]
        mesh.insert_edges(np.ascontiguousarray(constraints, dtype=np.uint32))  # type: ignore[call-overload]
    except RuntimeError as error:
        raise GeometryError(_explained(str(error), points)) from error
    mesh.erase_outer_triangles_and_holes()
    found = mesh.triangles_array()
    triangles = found["vertices"].astype(np.int64)
    # Neighbour k lies across the edge from node k to the next; where there is none its number is the largest.
    once = found["neighbors"] > np.arange(len(triangles), dtype=np.uint32)[:, None]
    edges = np.column_stack([triangles[once], triangles[:, [1, 2, 0]][once]])
    return triangles, edges


def sorted_triangles(triangles: Integers) -> Integers:
    """The same triangles (t, 3), turned to begin with their lowest node and sorted: an order that makes files equal."""
    first = triangles.argmin(axis=1)
    turned = np.take_along_axis(triangles, (first[:, None] + np.arange(3)) % 3, axis=1)
    return turned[np.lexsort(turned.T[::-1])]


def _explained(fault: str, points: Floats) -> str:
    """The library's message with the coordinates of the first node it numbers, without its source lines."""
    what, _, which = fault.partition(":")
    number = re.search(r"\d+", which)
    where = "" if number is None else f" at {place(points[int(number[0])])}"
    return f"the nodes cannot be connected{where}: {what.lower()}"


def circumcircles(points: Floats, triangles: Integers) -> tuple[Floats, Floats]:
    """Centres (t, 2) and radii (t,) of the triangles' circumscribed circles; infinite for a degenerate triangle."""
    a = points[triangles[:, 0]]
    (bx, by), (cx, cy) = (points[triangles[:, 1]] - a).T, (points[triangles[:, 2]] - a).T
    b2, c2 = bx * bx + by * by, cx * cx + cy * cy
    with np.errstate(divide="ignore", invalid="ignore"):
        half = 0.5 / (bx * cy - by * cx)
        offset = np.column_stack([(cy * b2 - by * c2) * half, (bx * c2 - cx * b2) * half])
    radius = np.hypot(*offset.T)
    return a + offset, np.where(np.isfinite(radius), radius, np.inf)
