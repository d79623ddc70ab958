"""The check that a mesh fills the polygon of its boundary nodes exactly."""

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import BubblemeshError
from bubblemesh.meshes import Mesh
from bubblemesh.quality import edges, signed_areas
from bubblemesh.wording import place

__all__ = ["area_error", "require_conforming"]

AREA_TOLERANCE = 1e-12
ROUNDING = 1e-15  # of the squared extent, which a thin domain's area may be far below


def area_error(mesh: Mesh) -> float:
    """Relative difference between the triangles' area and that of the polygon of the boundary edges."""
    origin = mesh.points[0]
    ends = mesh.facets[mesh.outer]
    (ax, ay), (bx, by) = (mesh.points[ends[:, k]].T - origin[:, None] for k in range(2))
    polygon = float(np.sum(ax * by - bx * ay)) / 2
    return float(signed_areas(mesh.points, mesh.triangles).sum()) / polygon - 1


def require_conforming(mesh: Mesh) -> None:
    """Check what every mesh has to hold, whatever the input was.

    Raises
    ------
    BubblemeshError
        If a triangle is not counter-clockwise, a node unused, a boundary edge missing, an edge labelled that is none
        or labelled twice, or the area wrong; the text names the first place. It is an error of the program, not of
        the case.
    """
    areas = signed_areas(mesh.points, mesh.triangles)
    if areas.min() <= 0:
        raise _fault("a triangle is flat or inverted", mesh.points[mesh.triangles[areas.argmin()]].mean(axis=0))
    unused = np.bincount(mesh.triangles.ravel(), minlength=len(mesh.points)) == 0
    if unused.any():
        raise _fault("a node belongs to no triangle", mesh.points[unused][0])
    sides, count = edges(mesh.triangles)
    free, wanted = _as_set(sides[count == 1]), _as_set(np.sort(mesh.facets, axis=1))
    inner = wanted & _as_set(sides[count == 2])
    if odd := free ^ (wanted - inner):
        raise _fault("the boundary is not met", mesh.points[list(odd.pop())].mean(axis=0))
    if len(wanted) < len(mesh.facets):
        raise _fault("an edge is labelled twice", mesh.points[0])
    rounding = ROUNDING * float(np.ptp(mesh.points, axis=0).max()) ** 2 / float(areas.sum())
    if abs(area_error(mesh)) > AREA_TOLERANCE + rounding:
        raise _fault(f"the area is off by {area_error(mesh):.1e}", mesh.points[0])


def _as_set(pairs: Integers) -> set[tuple[int, int]]:
    return {(int(a), int(b)) for a, b in pairs}


def _fault(what: str, where: Floats) -> BubblemeshError:
    return BubblemeshError(f"internal error: {what} at {place(where)}; please report this case")
