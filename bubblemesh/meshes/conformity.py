"""The check that a mesh fills the polygon of its boundary nodes exactly."""

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, contained, extent
from bubblemesh.errors import BubblemeshError
from bubblemesh.meshes.edges import edge_keys, find_keys
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.periodic import MATCH
from bubblemesh.meshes.quality import Measures
from bubblemesh.messages import place

AREA_TOLERANCE = 1e-12
AREA_ROUNDING = 1e-15  # of the squared extent, which may be far more than the area of a thin domain


def area_error(mesh: Mesh, measures: Measures | None = None) -> float:
    """Relative difference between the triangles' area and that of the polygon of the boundary edges.

    The measures are those of the mesh's triangles, made here if they are not given.
    """
    areas = (measures or Measures(mesh.points, mesh.triangles)).signed_areas
    return float(areas.sum()) / enclosed_area(mesh.points, mesh.facets[mesh.outer]) - 1


def enclosed_area(points: Floats, edges: Integers) -> float:
    """Area on the left of closed chains of edges (e, 2) between points (n, 2)."""
    (ax, ay), (bx, by) = (points[edges[:, k]].T - points[0][:, None] for k in range(2))
    return float(np.sum(ax * by - bx * ay)) / 2


def require_conforming(mesh: Mesh, measures: Measures | None = None) -> None:
    """Check what must be true of every mesh; a BubblemeshError, an error of the program, names the first place.

    - No triangle is flat or clockwise.
    - Each node is used.
    - Each boundary edge is a facet, each facet is an edge, and none is there twice.
    - The area is right.
    - The nodes of periodic sides match.

    The measures are those of the mesh's triangles, made here if they are not given.
    """
    measures = measures or Measures(mesh.points, mesh.triangles)
    areas = measures.signed_areas
    if areas.min() <= 0:
        raise _fault("a triangle is flat or inverted", mesh.points[mesh.triangles[areas.argmin()]].mean(axis=0))
    unused = np.bincount(mesh.triangles.ravel(), minlength=len(mesh.points)) == 0
    if unused.any():
        raise _fault("a node belongs to no triangle", mesh.points[unused][0])
    _require_labelled_edges(mesh, *measures.edges)
    require_matching_nodes(mesh)
    require_area(mesh.points, float(areas.sum()), area_error(mesh, measures))


def require_area(points: Floats, area: float, error: float) -> None:
    """Check that the area of triangles with all these points (n, 2) is off by rounding only."""
    rounding = AREA_ROUNDING * extent(points) ** 2 / area
    if abs(error) > AREA_TOLERANCE + rounding:
        raise _fault(f"the area is off by {error:.1e}", points[0])


def require_piece(measures: Measures, facets: Integers, rim: Integers, own: Booleans) -> None:
    """Check a piece of a mesh, by the measures of its triangles; the same error as `require_conforming`.

    No triangle is flat or clockwise; each of its ``own`` (n,) nodes is used; its edges with one triangle are those of
    the ``rim`` (r, 2), where it meets other pieces, and facets (f, 2).
    """
    points, areas, (edges, count) = measures.points, measures.signed_areas, measures.edges
    if areas.min() <= 0:
        raise _fault("a triangle is flat or inverted", points[measures.triangles[areas.argmin()]].mean(axis=0))
    unused = own & (np.bincount(measures.triangles.ravel(), minlength=len(points)) == 0)
    if unused.any():
        raise _fault("a node belongs to no triangle", points[unused][0])
    at_one, n = edges[count == 1], len(points)
    open_, of_facets, to_meet = (edge_keys(pairs, n) for pairs in (at_one, np.sort(facets), np.sort(rim)))
    known = np.sort(np.append(of_facets, to_meet))
    stray, missing = at_one[~contained(open_, known)], rim[~contained(to_meet, open_)]
    for pair in (*stray[:1], *missing[:1], *edges[count > 2][:1]):
        raise _fault("pieces do not meet", points[pair].mean(axis=0))


def _require_labelled_edges(mesh: Mesh, edges: Integers, count: Integers) -> None:
    """Check that each facet is one of the edges (e, 2), and each edge with one triangle, by its count, is one facet."""
    n = len(mesh.points)
    found = find_keys(edge_keys(edges, n), edge_keys(np.sort(mesh.facets, axis=1), n))
    labelled = np.bincount(found[found >= 0], minlength=len(edges))
    stray = mesh.facets[found < 0]
    bare = edges[(count == 1) & (labelled == 0)]
    for pair in (*stray[:1], *bare[:1]):
        raise _fault("the boundary is not met", mesh.points[pair].mean(axis=0))
    for pair in edges[labelled > 1][:1]:
        raise _fault("an edge is labelled twice", mesh.points[pair].mean(axis=0))


def require_matching_nodes(mesh: Mesh) -> None:
    """Check that periodic sides are the same but for a shift or a turn."""
    tolerance = MATCH * extent(mesh.points)
    for sides in mesh.periodic_sides:
        here, there = mesh.points[sides.nodes.T]
        away = np.abs(sides.moved(here) - there).max(axis=1)
        if away.max() > tolerance:
            raise _fault("a node of a periodic side has no counterpart", here[away.argmax()])


def _fault(what: str, where: Floats) -> BubblemeshError:
    return BubblemeshError(f"internal error: {what} at {place(where)}; please report this case")
