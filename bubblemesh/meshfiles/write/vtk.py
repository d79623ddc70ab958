"""Grids of VTK, cells only: the data of a mesh as VTK's formats hold them, and their XML files (vtu)."""

import zlib
from base64 import b64encode
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from bubblemesh.arrays import Floats, Integers
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles.groups import NODE_OWNER, PARTITION, Fields, cell_ids, cell_values
from bubblemesh.records import record

Data = Mapping[str, NDArray[Any]]
KINDS = {3: 5, 6: 22, 4: 9, 9: 28}  # VTK's numbers of the kinds of cells, by the number of their nodes
TYPES = {"f": "Float64", "i": "Int64", "u": "UInt8"}
BLOCK = 32768  # bytes that are compressed at a time


@record(eq=False)
class Grid:
    """Points and cells with their data.

    Attributes
    ----------
    points : (n, 3)
    cells : tuple of (m, k)
        Nodes of the cells of each kind; k tells which.
    point_data : dict of str to (n,)
    cell_data : dict of str to (c,)
        Of the cells of all kinds, one kind after the other.
    """

    points: Floats
    cells: tuple[Integers, ...]
    point_data: Data
    cell_data: Data

    @classmethod
    def of(cls, mesh: Mesh, fields: Fields) -> Self:
        """The cells of a mesh with their region ids as ``material`` and the fields, of two halves their mean.

        With a partition there are the part of each cell, ``partition``, and that of each node, ``owner``.
        """
        data: dict[str, NDArray[Any]] = {
            "material": np.concatenate([cell_ids(mesh, cells) for cells in mesh.cells])
        } | {
            name: np.concatenate([cell_values(values, cells) for cells in mesh.cells])
            for name, values in fields.items()
        }
        nodal: dict[str, NDArray[Any]] = {}
        if mesh.partition is not None:
            owner = mesh.partition.owner.astype(np.int64)
            data[PARTITION] = np.concatenate([owner[cells.triangles[:, 0]] for cells in mesh.cells])
            nodal[NODE_OWNER] = mesh.partition.node_owner.astype(np.int64)
        points = np.pad(mesh.points, ((0, 0), (0, 1)))
        return cls(points, tuple(cells.nodes for cells in mesh.cells), nodal, data)


def write_grid(grid: Grid, path: Path) -> None:
    """Write an XML file of VTK with compressed data."""
    with path.open("wb") as file:
        file.writelines(line.encode() + b"\n" for line in _lines(grid))


def _lines(grid: Grid) -> Iterator[str]:
    """Text of the file."""
    sizes = np.concatenate([np.full(len(cells), cells.shape[1]) for cells in grid.cells])
    topology = {
        "connectivity": np.concatenate([cells.ravel() for cells in grid.cells]),
        "offsets": np.cumsum(sizes),
        "types": np.concatenate([np.full(len(cells), KINDS[cells.shape[1]]) for cells in grid.cells]),
    }
    yield '<?xml version="1.0"?>'
    kind, compressor = 'type="UnstructuredGrid" version="0.1"', 'compressor="vtkZLibDataCompressor"'
    yield f'<VTKFile {kind} byte_order="LittleEndian" {compressor}>'
    yield "<UnstructuredGrid>"
    yield f'<Piece NumberOfPoints="{len(grid.points)}" NumberOfCells="{len(sizes)}">'
    yield from _section("Points", {"Points": grid.points})
    yield from _section("Cells", topology)
    yield from _section("PointData", grid.point_data)
    yield from _section("CellData", grid.cell_data)
    yield "</Piece>"
    yield "</UnstructuredGrid>"
    yield "</VTKFile>"


def _section(name: str, data: Data) -> Iterator[str]:
    """Text of arrays (n,) or (n, k)."""
    yield f"<{name}>"
    for key, values in data.items():
        columns = f' NumberOfComponents="{values.shape[1]}"' if values.ndim == 2 else ""
        yield f'<DataArray type="{TYPES[values.dtype.kind]}" Name="{key}"{columns} format="binary">'
        yield _compressed(values)
        yield "</DataArray>"
    yield f"</{name}>"


def _compressed(values: NDArray[Any]) -> str:
    """An array in blocks: how many there are, their size, that of the last one, their compressed sizes, and they."""
    text = values.astype(values.dtype.newbyteorder("<"), copy=False).tobytes()
    blocks = [zlib.compress(text[begin : begin + BLOCK]) for begin in range(0, len(text), BLOCK)]
    last = len(text) - (len(blocks) - 1) * BLOCK
    header = np.array([len(blocks), BLOCK, last, *map(len, blocks)], "<u4")
    return (b64encode(header.tobytes()) + b64encode(b"".join(blocks))).decode()
