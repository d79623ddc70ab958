"""Gmsh's mesh format 2.2, binary: the one that solvers read most widely, with named groups."""

from pathlib import Path

import numpy as np

from bubblemesh.mesh import Mesh
from bubblemesh.output.cells import Fields, facet_ids, group_names, region_ids

__all__ = ["write_msh"]


def write_msh(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write boundary edges and triangles with their physical groups; the format has no place for the fields."""
    import meshio

    groups = group_names(mesh)
    # One elementary entity for each physical group: readers want both tags, and none of them 0.
    ids = [facet_ids(mesh).astype(np.int32), region_ids(mesh).astype(np.int32)]
    meshio.Mesh(
        np.pad(mesh.points, ((0, 0), (0, 1))),
        [("line", mesh.facets), ("triangle", mesh.triangles)],
        cell_data={"gmsh:physical": ids, "gmsh:geometrical": ids},
        field_data={name: np.array(group) for name, group in groups.items()},
    ).write(path, file_format="gmsh22", binary=True)
