"""VTK's unstructured grids: XML (vtu) and legacy (vtk), triangles only."""

from pathlib import Path
from typing import Any

import numpy as np

from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles.groups import Fields, cell_kinds, region_ids


def write_vtu(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write the triangles, their region ids as ``material`` and the fields, compressed."""
    _grid(mesh, fields).write(path, file_format="vtu", binary=True, compression="zlib")


def write_vtk(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write the data of `write_vtu` in the legacy format, version 4.2, which every reader of VTK knows."""
    _grid(mesh, fields).write(path, file_format="vtk42", binary=True)


def _grid(mesh: Mesh, fields: Fields) -> Any:
    import meshio

    # int64 on purpose: VTK 9 loses int32 cell data of legacy files.
    data = {"material": [region_ids(mesh)], **{name: [np.asarray(values, float)] for name, values in fields.items()}}
    return meshio.Mesh(np.pad(mesh.points, ((0, 0), (0, 1))), [(cell_kinds(mesh)[1], mesh.triangles)], cell_data=data)
