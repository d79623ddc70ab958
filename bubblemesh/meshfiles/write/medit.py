"""Medit's format, which FreeFEM and Mmg read: ids without names."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from bubblemesh.arrays import Integers
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles.groups import Fields, facet_ids, node_ids, region_ids
from bubblemesh.meshfiles.text import lines, write_text


def write_medit(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write nodes, edges and triangles with their ids; the format has no place for names and fields."""
    write_text(path, _parts(mesh))


def _parts(mesh: Mesh) -> Iterator[str]:
    yield f"MeshVersionFormatted 2\nDimension 2\n\nVertices\n{len(mesh.points)}\n"
    yield from lines("%r %r %d", mesh.points, _point_ids(mesh))
    yield f"\nEdges\n{len(mesh.facets)}\n"
    yield from lines("%d %d %d", mesh.facets + 1, facet_ids(mesh))
    yield f"\nTriangles\n{len(mesh.triangles)}\n"
    yield from lines("%d %d %d %d", mesh.triangles + 1, region_ids(mesh))
    if len(mesh.labelled_nodes):
        # Mmg keeps the points that are named here.
        yield f"\nRequiredVertices\n{len(mesh.labelled_nodes)}\n"
        yield from lines("%d", mesh.labelled_nodes + 1)
    yield "\nEnd\n"


def _point_ids(mesh: Mesh) -> Integers:
    """Id (n,) of each node: that of its own label, else of a facet at it, else 0."""
    ids = np.zeros(len(mesh.points), np.int64)
    ids[mesh.facets[:, 1]] = facet_ids(mesh)
    ids[mesh.facets[:, 0]] = facet_ids(mesh)
    ids[mesh.labelled_nodes] = node_ids(mesh)
    return ids
