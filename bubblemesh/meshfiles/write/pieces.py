"""A grid of VTK in pieces, one for each part of a partition with its halo, and the list of them (pvtu)."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import meshio
import numpy as np
from numpy.typing import NDArray

from bubblemesh.arrays import Integers, each_once
from bubblemesh.meshes.division import GEOMETRY
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.partition import Partition
from bubblemesh.meshes.slices import Border, Slice, SlicedMesh
from bubblemesh.meshfiles.formats import PIECE
from bubblemesh.meshfiles.groups import GLOBAL_CELL, GLOBAL_NODE, Fields
from bubblemesh.meshfiles.write.viewers import vtk_grid, write_compressed

GHOSTS = "vtkGhostType"  # 1 for cells and nodes of another piece
TYPES = {"f": "Float64", "i": "Int64", "u": "UInt8"}


def write_pvtu(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write NAME.pvtu and a NAME_K.vtu for each part K, or for the whole mesh if it has no partition.

    A piece has the cells of its part, then those of its halo, and their nodes; ``GlobalNodeId`` and ``GlobalElementId``
    are numbers of nodes and cells in the whole mesh.
    """
    partition = mesh.partition or Partition(mesh.triangles, np.zeros(len(mesh.triangles), np.int64), 1, GEOMETRY)
    cells = sum(len(each.nodes) for each in mesh.cells)
    grid = _numbered(vtk_grid(mesh, fields), np.arange(len(mesh.points)), np.arange(cells))
    triangle_of = np.concatenate([each.triangles[:, 0] for each in mesh.cells])
    owner = partition.owner[triangle_of]
    own = np.split(np.argsort(owner, kind="stable"), np.cumsum(np.bincount(owner, minlength=partition.count))[:-1])
    halos = (each_once(mesh.cell_numbers[partition.halo(part)]) for part in range(partition.count))
    pieces = zip(own, halos, strict=True)
    _write_pieces((_piece(grid, *cells, partition, part) for part, cells in enumerate(pieces)), path)


def write_sliced_pvtu(mesh: SlicedMesh, path: Path) -> None:
    """Write the files of `write_pvtu`, whose parts are the slices."""
    border = mesh.border()
    _write_pieces((_slice_piece(mesh, border, number, part) for number, part in enumerate(mesh.slices())), path)


def _slice_piece(mesh: SlicedMesh, border: Border, number: int, part: Slice) -> meshio.Mesh:
    """The piece of a slice: its triangles, and those around it."""
    around, own = _around(border, number), np.arange(len(part.triangles))
    outer = border.mesh.triangles[around]
    mine, theirs = np.unique(part.triangles), np.unique(outer)
    nodes, first = np.unique(np.concatenate([mine, border.nodes[theirs]]), return_index=True)
    points = np.concatenate([mesh.points(mine, number, part), border.mesh.points[theirs]])[first]
    triangles = np.searchsorted(nodes, np.concatenate([part.triangles, border.nodes[outer]]))
    owner = np.concatenate([np.full(len(own), number), border.partition.owner[around]])
    partition = Partition(triangles, owner, len(mesh.sizes), GEOMETRY)
    cells = np.concatenate([mesh.first_triangles[number] + own, border.cells[around]])
    fields = {name: np.concatenate([part.fields[name], border.fields[name][around]]) for name in mesh.fields}
    local = Mesh(
        points,
        triangles,
        mesh.frame.facets[:0],
        mesh.frame.facet_labels[:0],
        mesh.frame.labels,
        mesh.frame.regions,
        np.concatenate([part.regions, border.mesh.triangle_regions[around]]),
        partition=partition,
        ids=mesh.frame.ids,
    )
    return _piece(_numbered(vtk_grid(local, fields), nodes, cells), own, partition.halo(number), partition, number)


def _around(border: Border, number: int) -> Integers:
    """Triangles at the border in the halo of a slice, and triangles that touch these, which decide their owners."""
    triangles, owner = border.partition.triangles, border.partition.owner
    at_halo = np.zeros(len(border.nodes), bool)
    at_halo[triangles[border.partition.halo(number)]] = True
    return np.flatnonzero((owner != number) & at_halo[triangles].any(axis=1))


def _write_pieces(pieces: Iterable[meshio.Mesh], path: Path) -> None:
    """Write the pieces and the list of them."""
    names = []
    for part, piece in enumerate(pieces):
        names.append(path.stem + PIECE.format(part))
        write_compressed(piece, path.with_name(names[-1]))
    path.write_bytes(_list_of(names, piece))


def _numbered(grid: meshio.Mesh, nodes: Integers, cells: Integers) -> meshio.Mesh:
    """The grid with numbers of its nodes and cells in the whole mesh, and room for marks on cells."""
    grid.point_data[GLOBAL_NODE] = nodes
    grid.cell_data[GLOBAL_CELL] = np.split(cells, np.cumsum([len(block.data) for block in grid.cells])[:-1])
    grid.cell_data[GHOSTS] = [np.zeros(len(block.data), np.uint8) for block in grid.cells]
    return grid


def _piece(grid: meshio.Mesh, own: Integers, halo: Integers, partition: Partition, part: int) -> meshio.Mesh:
    """The cells ``own`` (m,) of a part of a grid and its ``halo`` (g,), with marks on cells and nodes of other parts.

    Cells are given by their numbers in all blocks of the grid.
    """
    blocks: list[tuple[str, Integers]] = []
    data: dict[str, list[NDArray[Any]]] = {name: [] for name in grid.cell_data}
    before = 0
    for k, block in enumerate(grid.cells):
        mine, ghosts = (cells[(cells >= before) & (cells < before + len(block.data))] - before for cells in (own, halo))
        before += len(block.data)
        cells = np.concatenate([mine, ghosts])
        if len(cells):
            blocks.append((block.type, block.data[cells]))
            for name, values in grid.cell_data.items():
                data[name].append(values[k][cells])
            data[GHOSTS][-1][len(mine) :] = 1
    nodes = each_once(np.concatenate([cells.ravel() for _, cells in blocks]))
    nodal = {name: values[nodes] for name, values in grid.point_data.items()}
    nodal[GHOSTS] = (partition.node_owner[nodes] != part).astype(np.uint8)
    return meshio.Mesh(
        grid.points[nodes], [(kind, np.searchsorted(nodes, cells)) for kind, cells in blocks], nodal, data
    )


def _list_of(names: list[str], piece: meshio.Mesh) -> bytes:
    """Text of the list of pieces that have the data of this one."""
    root = ET.Element("VTKFile", type="PUnstructuredGrid", version="0.1", byte_order="LittleEndian")
    grid = ET.SubElement(root, "PUnstructuredGrid", GhostLevel="1")
    nodal, cells = ET.SubElement(grid, "PPointData"), ET.SubElement(grid, "PCellData")
    for name, values in piece.point_data.items():
        ET.SubElement(nodal, "PDataArray", type=TYPES[values.dtype.kind], Name=name)
    for name, (values, *_) in piece.cell_data.items():
        ET.SubElement(cells, "PDataArray", type=TYPES[values.dtype.kind], Name=name)
    ET.SubElement(ET.SubElement(grid, "PPoints"), "PDataArray", type="Float64", NumberOfComponents="3")
    for name in names:
        ET.SubElement(grid, "Piece", Source=name)
    ET.indent(root)
    return ET.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n"
