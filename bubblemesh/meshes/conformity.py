"""The check that a mesh fills the polygon of its boundary nodes exactly."""

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import BubblemeshError
from bubblemesh.meshes.edges import edge_keys, find_keys
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.quality import Measures
from bubblemesh.messages import place

AREA_TOLERANCE = 1e-12
MATCH = 1e-8  # of the domain's size; periodic sides are the same but for a tenth of that
ROUNDING = 1e-15  # of the squared extent, which a thin domain's area may be far below


def area_error(mesh: Mesh, measures: Measures | None = None) -> float:
    """Relative difference between the triangles' area and that of the polygon of the boundary edges.

    The measures are those of the mesh's triangles, made here if they are not given.
    """
    areas = (measures or Measures(mesh.points, mesh.triangles)).signed_areas
    origin = mesh.points[0]
    ends = mesh.facets[mesh.outer]
    (ax, ay), (bx, by) = (mesh.points[ends[:, k]].T - origin[:, None] for k in range(2))
    polygon = float(np.sum(ax * by - bx * ay)) / 2
    return float(areas.sum()) / polygon - 1


def require_conforming(mesh: Mesh, measures: Measures | None = None) -> None:
    """Check what every mesh has to hold, whatever the input was; else a BubblemeshError names the first place.

    No triangle is flat or clockwise, no node unused, no boundary edge missing, no edge labelled that is none or
    labelled twice, the area right, and nodes of periodic sides match. It is an error of the program, not of the case.
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
    _require_matching_nodes(mesh)
    rounding = ROUNDING * float(np.ptp(mesh.points, axis=0).max()) ** 2 / float(areas.sum())
    error = area_error(mesh, measures)
    if abs(error) > AREA_TOLERANCE + rounding:
        raise _fault(f"the area is off by {error:.1e}", mesh.points[0])


def _require_labelled_edges(mesh: Mesh, edges: Integers, count: Integers) -> None:
    """Check that every facet is one of the edges (e, 2), and each one at a single triangle, by its count, one facet."""
    n = len(mesh.points)
    found = find_keys(edge_keys(edges, n), edge_keys(np.sort(mesh.facets, axis=1), n))
    labelled = np.bincount(found[found >= 0], minlength=len(edges))
    stray = mesh.facets[found < 0]
    bare = edges[(count == 1) & (labelled == 0)]
    for pair in (*stray[:1], *bare[:1]):
        raise _fault("the boundary is not met", mesh.points[pair].mean(axis=0))
    for pair in edges[labelled > 1][:1]:
        raise _fault("an edge is labelled twice", mesh.points[pair].mean(axis=0))


def _require_matching_nodes(mesh: Mesh) -> None:
    """Check that periodic sides are the same but for a shift."""
    tolerance = MATCH * float(np.ptp(mesh.points, axis=0).max())
    for sides in mesh.periodic_sides:
        here, there = mesh.points[sides.nodes.T]
        away = np.abs(there - here - sides.shift).max(axis=1)
        if away.max() > tolerance:
            raise _fault("a node of a periodic side has no counterpart", here[away.argmax()])


def _fault(what: str, where: Floats) -> BubblemeshError:
    return BubblemeshError(f"internal error: {what} at {place(where)}; please report this case")
