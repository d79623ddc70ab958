"""Whether the mesh of a solution is one of the domain."""

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.errors import CaseError
from bubblemesh.geometry.domain import Domain
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.messages import place

ASIDE = 0.1  # edge lengths that a node may be off the domain or its boundary
MISMATCH = 0.15  # area beside a boundary edge in terms of its length's square: more than under an arc of 90 degrees


def require_coverage(domain: Domain, points: Floats, triangles: Integers) -> None:
    """Check that the triangles (t, 3) with corners at points (n, 2) cover the domain and nothing else.

    Raises
    ------
    CaseError
        With the place where they do not.
    """
    pairs, count = unique_edges(triangles)
    if count.max() > 2:
        k = int(count.argmax())
        raise CaseError(
            f"the mesh of the solution is no plane mesh: {count[k]} triangles meet at the edge from "
            f"{place(points[pairs[k, 0]])} to {place(points[pairs[k, 1]])}"
        )
    lengths = np.hypot(*(points[pairs[:, 1]] - points[pairs[:, 0]]).T)
    shortest = np.full(len(points), np.inf)
    np.minimum.at(shortest, pairs, lengths[:, None])
    rim = np.unique(pairs[count == 1])
    distance = domain.signed_distance(points)
    _require_inside(points, distance, ASIDE * shortest)
    _require_rim(domain, points[rim], distance[rim], ASIDE * shortest[rim])
    covered, whole = float(np.abs(signed_areas(points, triangles)).sum()), domain.polygon.area
    if abs(covered - whole) > MISMATCH * (lengths[count == 1] ** 2).sum():
        raise CaseError(
            f"the mesh of the solution has an area of {covered:.6g}, the domain one of {whole:.6g}: it has to be a "
            "mesh of the same domain"
        )


def _require_inside(points: Floats, distance: Floats, allowed: Floats) -> None:
    outside = np.flatnonzero(distance < -allowed)
    if len(outside):
        k = outside[distance[outside].argmin()]
        more = f", and {len(outside) - 1} more nodes are outside" if len(outside) > 1 else ""
        raise CaseError(
            f"the mesh of the solution leaves the domain: its node at {place(points[k])} is {-distance[k]:.3g} "
            f"outside{more}: it has to be a mesh of the same domain"
        )


def _require_rim(domain: Domain, points: Floats, distance: Floats, allowed: Floats) -> None:
    """Check that the boundary nodes of the mesh are on that of the domain, or on a line inside it."""
    inner = np.flatnonzero(distance > allowed)
    inner = inner[~_on_lines(domain, points[inner], allowed[inner])]
    if len(inner):
        k = inner[distance[inner].argmax()]
        raise CaseError(
            f"the mesh of the solution does not cover the domain: it ends at {place(points[k])}, {distance[k]:.3g} "
            "inside: it has to be a mesh of the same domain"
        )


def _on_lines(domain: Domain, points: Floats, allowed: Floats) -> Booleans:
    """Mask (m,) of the points (m, 2) that are as near as allowed (m,) to an embedded line or an interface."""
    boundary = domain.boundary
    piece, s, step = boundary.stations()
    mine = boundary.inner[piece]
    ends = [boundary.points(piece[mine], at) for at in (s[mine], s[mine] + step[mine])]
    near = np.zeros(len(points), bool)
    tree = shapely.STRtree(shapely.linestrings(np.stack(ends, axis=1)))
    near[tree.query(shapely.points(points), predicate="dwithin", distance=allowed)[0]] = True
    return near
