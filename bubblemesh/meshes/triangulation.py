"""Constrained Delaunay triangulation, by pythoncdt (exact predicates)."""

import re

import numpy as np
import pythoncdt as cdt

from bubblemesh.arrays import Booleans, Floats, Integers, each_once
from bubblemesh.errors import GeometryError
from bubblemesh.kernels.enclosing import enclosed
from bubblemesh.kernels.linking import without_ties
from bubblemesh.meshes.edges import SideTable
from bubblemesh.messages import place


def triangulated(points: Floats, constraints: Integers) -> Integers:
    """Sorted triangles (t, 3) of the constrained Delaunay triangulation; see ``linked``."""
    return sorted_triangles(linked(points, constraints)[0])


def linked(points: Floats, constraints: Integers, two_sided: Booleans | None = None) -> tuple[Integers, Integers]:
    """Triangles (t, 3) and their edges (m, 2), each once, of the constrained Delaunay triangulation of a region.

    Triangles are counter-clockwise, in the order of `in_order`; where nodes lie on a circle, `without_ties` chooses.

    Parameters
    ----------
    points
        Nodes (n, 2).
    constraints
        Edges (e, 2) that form closed rings without crossings. The region is what an odd number of rings encloses.
    two_sided
        Mask (e,) of constraints that lie inside of the region and bound nothing.

    Raises
    ------
    GeometryError
        If points coincide or constraints cross; the message has the coordinates.
    """
    if not np.isfinite(points).all():  # the library would run out of memory
        raise ValueError("points must be finite")
    return without_ties(_within(points, constraints, two_sided), points, constraints)


def _within(points: Floats, constraints: Integers, two_sided: Booleans | None) -> Integers:
    """Triangles (t, 3) of `linked`, in no order; the library's own mesh, which is large, is freed at the end."""
    mesh = cdt.Triangulation(cdt.VertexInsertionOrder.AUTO, cdt.IntersectingConstraintEdges.NOT_ALLOWED, 0.0)
    try:
        mesh.insert_vertices(np.ascontiguousarray(points))  # type: ignore[call-overload]
        # The library counts crossed edges: one that is there twice can be crossed without leaving the region.
        twice = constraints[:0] if two_sided is None else constraints[two_sided]
        mesh.insert_edges(np.concatenate([constraints, twice]).astype(np.uint32))  # type: ignore[call-overload]
    except RuntimeError as error:
        raise GeometryError(_explained(str(error), points)) from error
    cells = mesh.triangles_array().view(np.uint32).reshape(-1, 6)
    found = enclosed(cells, constraints if two_sided is None else constraints[~two_sided], len(points))
    if found is None:
        mesh.erase_outer_triangles_and_holes()
        found = mesh.triangles_array()["vertices"].astype(np.int64)
    return found


def sorted_triangles(triangles: Integers) -> Integers:
    """Triangles (t, 3) turned to begin with their lowest node, and sorted, so that equal meshes give equal files.

    The same array is returned if it is already in this order.
    """
    a, b, c = triangles.T
    later = (a[1:] > a[:-1]) | ((a[1:] == a[:-1]) & (b[1:] > b[:-1]))
    if later.all() and (a < b).all() and (a < c).all():
        return triangles
    first = triangles.argmin(axis=1)
    turned = np.take_along_axis(triangles, (first[:, None] + np.arange(3)) % 3, axis=1)
    return turned[np.lexsort(turned.T[::-1])]


def regions(triangles: Integers, facets: Integers, left: Integers, right: Integers) -> Integers:
    """Region (t,) of each counter-clockwise triangle; regions change only across facets.

    The facets (e, 2) are edges of triangles, with the regions ``left`` and ``right`` (e,) on either side, -1 outside.
    """
    inside = each_once(np.concatenate([left, right]))
    inside = inside[inside >= 0]
    if len(inside) == 1:
        return np.full(len(triangles), inside[0])
    if len(triangles) == 0:
        return np.zeros(0, np.int64)
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    t, table = len(triangles), SideTable.of(triangles, int(triangles.max()) + 1)
    walls = [table.find(pairs) for pairs in (facets, facets[:, ::-1])]
    other = table.opposite()
    for rows in walls:
        other[rows[rows >= 0]] = -1
    passed = np.flatnonzero(other >= 0)
    links = coo_array((np.ones(len(passed)), (table.owner(passed)[0], table.owner(other[passed])[0])), shape=(t, t))
    count, part = connected_components(links, directed=False)
    region = np.zeros(count, np.int64)
    for rows, side in zip(walls, (left, right), strict=True):
        region[part[table.owner(rows[rows >= 0])[0]]] = side[rows >= 0]
    return region[part]


def _explained(fault: str, points: Floats) -> str:
    """The library's message without its source lines, with the coordinates of the first node that it names."""
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
