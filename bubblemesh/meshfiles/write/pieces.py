"""A grid of VTK in pieces, one for each part of a partition with its halo, and the list of them (pvtu)."""

from pathlib import Path
from xml.etree import ElementTree as ET

import meshio
import numpy as np

from bubblemesh.arrays import Integers
from bubblemesh.meshes.division import GEOMETRY
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.partition import Partition
from bubblemesh.meshfiles.formats import PIECE
from bubblemesh.meshfiles.groups import GLOBAL_CELL, GLOBAL_NODE, Fields
from bubblemesh.meshfiles.write.viewers import vtk_grid, write_compressed

GHOSTS = "vtkGhostType"  # 1 for cells and nodes that are those of another piece
TYPES = {"f": "Float64", "i": "Int64", "u": "UInt8"}


def write_pvtu(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write NAME.pvtu and a NAME_K.vtu for each part K, or for the whole mesh if it has no partition.

    A piece has the triangles of its part, then those of its halo, and their nodes; numbers of both in the whole mesh
    are ``GlobalNodeId`` and ``GlobalElementId``.
    """
    grid, whole = vtk_grid(mesh, fields), np.zeros(len(mesh.triangles), np.int64)
    partition = mesh.partition or Partition(mesh.triangles, whole, 1, GEOMETRY)
    grid.point_data[GLOBAL_NODE] = np.arange(len(mesh.points))
    grid.cell_data[GLOBAL_CELL] = [np.arange(len(mesh.triangles))]
    grid.cell_data[GHOSTS] = [whole.astype(np.uint8)]
    names = [path.stem + PIECE.format(part) for part in range(partition.count)]
    own = np.split(np.argsort(partition.owner, kind="stable"), np.cumsum(partition.sizes)[:-1])
    for part, (name, cells) in enumerate(zip(names, own, strict=True)):
        piece = _piece(grid, cells, partition, part)
        write_compressed(piece, path.with_name(name))
    path.write_bytes(_list_of(names, piece))


def _piece(grid: meshio.Mesh, own: Integers, partition: Partition, part: int) -> meshio.Mesh:
    """The cells ``own`` (m,) of a part of a grid and those of its halo, with a mark on what is another part's."""
    cells = np.concatenate([own, partition.halo(part)])
    nodes, corners = np.unique(grid.cells[0].data[cells], return_inverse=True)
    data = {name: [values[cells]] for name, (values,) in grid.cell_data.items()}
    data[GHOSTS][0][len(own) :] = 1
    nodal = {name: values[nodes] for name, values in grid.point_data.items()}
    nodal[GHOSTS] = (partition.node_owner[nodes] != part).astype(np.uint8)
    return meshio.Mesh(grid.points[nodes], [(grid.cells[0].type, corners.reshape(len(cells), -1))], nodal, data)


def _list_of(names: list[str], piece: meshio.Mesh) -> bytes:
    """Text of the list of pieces that have the data of this one."""
    root = ET.Element("VTKFile", type="PUnstructuredGrid", version="0.1", byte_order="LittleEndian")
    grid = ET.SubElement(root, "PUnstructuredGrid", GhostLevel="1")
    nodal, cells = ET.SubElement(grid, "PPointData"), ET.SubElement(grid, "PCellData")
    for name, values in piece.point_data.items():
        ET.SubElement(nodal, "PDataArray", type=TYPES[values.dtype.kind], Name=name)
    for name, (values,) in piece.cell_data.items():
        ET.SubElement(cells, "PDataArray", type=TYPES[values.dtype.kind], Name=name)
    ET.SubElement(ET.SubElement(grid, "PPoints"), "PDataArray", type="Float64", NumberOfComponents="3")
    for name in names:
        ET.SubElement(grid, "Piece", Source=name)
    ET.indent(root)
    return ET.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n"
