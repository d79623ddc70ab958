"""Meshes whose points are mapped by a function."""

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from bubblemesh.arrays import Floats, unmasked
from bubblemesh.errors import CaseError
from bubblemesh.meshes.quality import signed_areas

if TYPE_CHECKING:
    from bubblemesh.meshes.mesh import Mesh

M = TypeVar("M", bound="Mesh")


def mapped(mesh: M, function: Callable[[Floats], Floats]) -> M:
    """The mesh with all of its points (n, 2) mapped by a function; see `Mesh.mapped`."""
    result = replace(
        mesh,
        points=_places(mesh.points, function),
        facet_middles=_places(mesh.facet_middles, function),
        curved_middles=_places(mesh.curved_middles, function) if len(mesh.curved_middles) else mesh.curved_middles,
        metric=mesh.metric[:0],
        fields={},
    )
    turned = signed_areas(result.points, result.triangles) < 0
    if turned.any() and not turned.all():
        raise CaseError(f"function: turns {turned.sum()} of {len(turned)} triangles over: move all of them alike")
    return _reversed(result) if turned.any() else result


def _reversed(mesh: M) -> M:
    """The mesh with triangles and facets reversed."""
    order = mesh.triangles.shape[1] // 3
    triangles = mesh.triangles[:, [0, 2, 1, 5, 4, 3][: 3 * order]]
    partition = None if mesh.partition is None else mesh.partition.with_nodes(triangles)
    return replace(mesh, triangles=triangles, facets=mesh.facets[:, [1, 0, 2][: 1 + order]], partition=partition)


def _places(points: Floats, function: Callable[[Floats], Floats]) -> Floats:
    """Points (n, 2) mapped by a function; CaseError if it does not return such an array of finite numbers."""
    given = np.asarray(unmasked(function(points)))
    if given.dtype.kind not in "iuf" or given.shape != points.shape:
        found = f"an array of {given.dtype}, of the shape {given.shape}"
        raise CaseError(f"function: must give a place (n, 2) for each point, here {points.shape} (found {found})")
    bad = np.flatnonzero(~np.isfinite(given).all(axis=1))
    if len(bad):
        raise CaseError(f"function: gives no finite place for the point {points[bad[0]].tolist()}")
    return given.astype(float)
