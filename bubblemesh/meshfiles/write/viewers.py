"""Formats of programs that show meshes, cells only: VTK's grids, XML (vtu) and legacy (vtk), and Tecplot's text."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles.groups import CELL_KINDS, Fields
from bubblemesh.meshfiles.write.vtk import Grid, write_grid


def write_vtu(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write the cells, their region ids as ``material`` and the fields, compressed.

    Fields of a quadrilateral are the means of its halves. With a partition there are the part of each cell,
    ``partition``, and that of each node, ``owner``.
    """
    write_grid(Grid.of(mesh, fields), path)


def write_vtk(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write the data of `write_vtu` in the legacy format, version 4.2, which every reader of VTK knows."""
    _as_meshio(Grid.of(mesh, fields)).write(path, file_format="vtk42", binary=True)


def write_tecplot(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write the data of `write_vtu` as one zone."""
    grid = Grid.of(mesh, fields)
    nodal, data = (
        {name: values.astype(float) for name, values in of.items()} for of in (grid.point_data, grid.cell_data)
    )
    _as_meshio(replace(grid, points=mesh.points, point_data=nodal, cell_data=data)).write(path, file_format="tecplot")


def _as_meshio(grid: Grid) -> Any:
    """A `meshio.Mesh` of a grid."""
    import meshio

    ends = np.cumsum([len(cells) for cells in grid.cells])[:-1]
    blocks = [(CELL_KINDS[cells.shape[1]], cells) for cells in grid.cells]
    data = {name: np.split(values, ends) for name, values in grid.cell_data.items()}
    return meshio.Mesh(grid.points, blocks, dict(grid.point_data), data)
