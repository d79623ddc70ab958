"""Formats of programs that show meshes, cells only: VTK's grids, XML (vtu) and legacy (vtk), and Tecplot's text."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bubblemesh.arrays import Floats
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles.groups import CELL_KINDS, NODE_OWNER, PARTITION, Fields, cell_ids, cell_values


def write_vtu(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write the cells, their region ids as ``material`` and the fields, compressed.

    Fields of a quadrilateral are the means of its halves. With a partition, ``partition`` is the part of each cell and
    ``owner`` that of each node.
    """
    write_compressed(vtk_grid(mesh, fields), path)


def write_vtk(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write the data of `write_vtu` in the legacy format, version 4.2, which every reader of VTK knows."""
    vtk_grid(mesh, fields).write(path, file_format="vtk42", binary=True)


def write_tecplot(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write the data of `write_vtu` as one zone."""
    _grid(mesh, fields, mesh.points, float).write(path, file_format="tecplot")


def vtk_grid(mesh: Mesh, fields: Fields) -> Any:
    """A `meshio.Mesh` with the data of VTK's formats."""
    # int64 on purpose: VTK 9 loses int32 cell data in legacy files.
    return _grid(mesh, fields, np.pad(mesh.points, ((0, 0), (0, 1))), np.int64)


def write_compressed(grid: Any, path: Path) -> None:
    """Write a `meshio.Mesh` as an XML file of VTK."""
    grid.write(path, file_format="vtu", binary=True, compression="zlib")


def _grid(mesh: Mesh, fields: Fields, points: Floats, tag: type) -> Any:
    """A `meshio.Mesh` of the cells at points (n, 2) or (n, 3), with ``material`` and parts of the type ``tag``."""
    import meshio

    data: dict[str, list[NDArray[Any]]] = {"material": [cell_ids(mesh, cells).astype(tag) for cells in mesh.cells]} | {
        name: [cell_values(values, cells) for cells in mesh.cells] for name, values in fields.items()
    }
    nodal: dict[str, NDArray[Any]] = {}
    if mesh.partition is not None:
        owner: NDArray[Any] = mesh.partition.owner.astype(tag)
        data[PARTITION] = [owner[cells.triangles[:, 0]] for cells in mesh.cells]
        nodal[NODE_OWNER] = mesh.partition.node_owner.astype(tag)
    blocks = [(CELL_KINDS[cells.nodes.shape[1]], cells.nodes) for cells in mesh.cells]
    return meshio.Mesh(points, blocks, nodal, data)
