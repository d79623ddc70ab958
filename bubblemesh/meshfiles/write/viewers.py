"""Formats of programs that show meshes, triangles only: VTK's grids, XML (vtu) and legacy (vtk), and Tecplot's text."""

from pathlib import Path
from typing import Any

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles.groups import Fields, cell_kinds, region_ids


def write_vtu(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write the triangles, their region ids as ``material`` and the fields, compressed."""
    _vtk_grid(mesh, fields).write(path, file_format="vtu", binary=True, compression="zlib")


def write_vtk(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write the data of `write_vtu` in the legacy format, version 4.2, which every reader of VTK knows."""
    _vtk_grid(mesh, fields).write(path, file_format="vtk42", binary=True)


def write_tecplot(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write the triangles as one zone, their region ids as ``material`` and the fields."""
    _grid(mesh, fields, mesh.points, float).write(path, file_format="tecplot")


def _vtk_grid(mesh: Mesh, fields: Fields) -> Any:
    # int64 on purpose: VTK 9 loses int32 cell data of legacy files.
    return _grid(mesh, fields, np.pad(mesh.points, ((0, 0), (0, 1))), np.int64)


def _grid(mesh: Mesh, fields: Fields, points: Floats, tag: type) -> Any:
    """A `meshio.Mesh` of the triangles at points (n, 2) or (n, 3), with ``material`` of the type ``tag``."""
    import meshio

    data = {"material": [region_ids(mesh).astype(tag)]} | {
        name: [np.asarray(values, float)] for name, values in fields.items()
    }
    return meshio.Mesh(points, [(cell_kinds(mesh)[1], mesh.triangles)], cell_data=data)
