"""MED, the format of Salome and Code_Aster: groups with names, in HDF5."""

from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles.groups import Fields, cell_kinds, facet_ids, group_names, node_ids, region_ids
from bubblemesh.meshfiles.names import plain_words


def write_med(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write edges and triangles with one group for each label and region, and the groups of the labelled points."""
    import meshio

    line, triangle = cell_kinds(mesh)
    # MED numbers the families of cells downwards from -1 and those of nodes upwards from 1; 0 is none.
    data: dict[str, Any] = {"cell_tags": [-facet_ids(mesh), -region_ids(mesh)]}
    points = np.zeros(len(mesh.points), np.int64)
    points[mesh.labelled_nodes] = node_ids(mesh)
    result = meshio.Mesh(
        mesh.points, [(line, mesh.facets), (triangle, mesh.triangles)], {"point_tags": points}, cell_data=data
    )
    words = plain_words(mesh)
    families = [(words[name], group) for name, group in group_names(mesh).items()]
    result.cell_tags = {-group.id: [word] for word, group in families if group.dimension > 0}
    result.point_tags = {group.id: [word] for word, group in families if group.dimension == 0}
    # Built in memory, since HDF5 does not survive a full disk.
    file = BytesIO()
    result.write(file, file_format="med")
    path.write_bytes(file.getvalue())
