"""XDMF: cells and facets in two files, as FEniCSx needs them; the numbers are in HDF5 files or inline."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from io import RawIOBase
from math import prod
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import h5py
import numpy as np
from numpy.typing import NDArray

from bubblemesh.arrays import Integers
from bubblemesh.errors import CaseError
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.slices import Slice, SlicedMesh
from bubblemesh.meshfiles.groups import (
    NODE_OWNER,
    PARTITION,
    Fields,
    cell_ids,
    cell_values,
    facet_ids,
    group_names,
    ids_of_groups,
)
from bubblemesh.process.watchdog import settle
from bubblemesh.records import record

_Data = Mapping[str, NDArray[Any]]
_Store = Callable[[NDArray[Any]], tuple[str, str]]
"""Keeps an array and returns the format and the text by which the XML refers to it."""

# Kinds of facets and cells by the number of their nodes; and the number of each kind in mixed lists.
_EDGES = {2: "Polyline", 3: "Edge_3"}
_CELLS = {3: "Triangle", 6: "Triangle_6", 4: "Quadrilateral", 9: "Quadrilateral_9"}
_NUMBERS = {3: 0x4, 6: 0x24, 4: 0x5, 9: 0x23}
_DATA_TYPES = {"f": "Float", "i": "Int"}


@record
class _Topology:
    """Cells (m, k) of one kind, or a list of cells with the number of the kind before each; and their number."""

    kind: str
    cells: Integers
    count: int

    @classmethod
    def of(cls, mesh: Mesh) -> "_Topology":
        """Topology of the cells of a mesh."""
        blocks = [cells.nodes for cells in mesh.cells]
        if len(blocks) == 1:
            return cls(_CELLS[blocks[0].shape[1]], blocks[0], len(blocks[0]))
        mixed = [np.insert(nodes, 0, _NUMBERS[nodes.shape[1]], axis=1).ravel() for nodes in blocks]
        return cls("Mixed", np.concatenate(mixed), sum(map(len, blocks)))

    @classmethod
    def of_facets(cls, facets: Integers) -> "_Topology":
        """Topology of facets (f, 2) or (f, 3)."""
        return cls(_EDGES[facets.shape[1]], facets, len(facets))


def write_xdmf(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write NAME.xdmf with the cells and NAME_facets.xdmf with the boundary edges, each with its .h5 file.

    The tags are ``material`` and ``label``. Fields of a quadrilateral are the means of its halves. Both files hold all
    points, so that the numbers of the nodes agree. With a partition, the first file has ``partition``, the part of each
    cell, and ``owner``, that of each node. CaseError if the file's name has a colon, which separates file and data set
    in XDMF.
    """
    _require_name(path)
    _write_pair(path, mesh, _Topology.of(mesh), _cell_data(mesh, fields), _nodal_data(mesh))
    _write_pair(_beside(path), mesh, _Topology.of_facets(mesh.facets), _facet_data(mesh), {})


def write_sliced_xdmf(mesh: SlicedMesh, path: Path) -> None:
    """Write the files of `write_xdmf`, slice by slice; nothing is compressed, which would take as long again."""
    _require_name(path)
    settle()  # the HDF5 library calls back into Python, and could not handle the exception of a time limit
    frame = replace(mesh.frame, points=_unwritten((mesh.nodes, 2)))
    data = {"material": _unwritten((mesh.triangles,), np.int32)}
    data |= {name: _unwritten((mesh.triangles,)) for name in mesh.fields}
    labels = _facet_data(frame)
    cells = _unwritten((mesh.triangles, 3), np.int64)
    points, triangles, material, *fields = _columns(path, frame, _Topology(_CELLS[3], cells, len(cells)), data)
    same_points, facets, ids = _columns(_beside(path), frame, _Topology.of_facets(frame.facets), labels)
    facets.put(0, frame.facets)
    ids.put(0, labels["label"])
    of_regions = ids_of_groups(frame)[len(frame.labels) :]
    first_nodes, first_triangles = mesh.first_nodes.tolist(), mesh.first_triangles.tolist()

    def put(number: int, part: Slice) -> None:
        node, cell = first_nodes[number], first_triangles[number]
        for column in (points, same_points):
            column.put(node, part.points)
        triangles.put(cell, part.triangles)
        material.put(cell, of_regions[part.regions])
        for name, column in zip(mesh.fields, fields, strict=True):
            column.put(cell, part.fields[name])

    for column in (points, same_points):
        column.put(0, mesh.frame.points)
    mesh.side_by_side(put)


@record
class _Column:
    """A contiguous data set of an HDF5 file, which is filled row by row."""

    path: Path
    offset: int  # bytes before it in the file
    kind: np.dtype[Any]
    width: int  # bytes of a row

    def put(self, row: int, values: NDArray[Any]) -> None:
        """Write rows, beginning with row ``row``; other threads may write other rows at the same time."""
        with self.path.open("r+b") as stream:
            stream.seek(self.offset + row * self.width)
            stream.write(np.ascontiguousarray(values, self.kind).data)


def _columns(path: Path, mesh: Mesh, topology: _Topology, data: _Data) -> list[_Column]:
    """Empty data sets for points, cells and data, with the shapes of these arrays; the XML is written beside them."""
    heavy = path.with_suffix(".h5")
    with heavy.open("w+b", buffering=0) as stream:
        sink = _Sink(stream)
        with h5py.File(sink, "w") as file:

            def store(array: NDArray[Any]) -> tuple[str, str]:
                name, settings = f"data{len(file)}", h5py.h5p.create(h5py.h5p.DATASET_CREATE)
                settings.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
                file.create_dataset(name, array.shape, array.dtype, dcpl=settings, fill_time="never")
                return "HDF", f"{heavy.name}:/{name}"

            tree = _grid(mesh, topology, data, {}, store)
            sets = [file[f"data{k}"] for k in range(len(file))]
            columns = [
                _Column(heavy, each.id.get_offset() or 0, each.dtype, each.dtype.itemsize * prod(each.shape[1:]))
                for each in sets
            ]
        if sink.error is not None:
            raise sink.error
    tree.write(path)
    return columns


class _Sink:
    """A file for the HDF5 library that never fails, as that ends the process if it cannot write.

    The first error is kept, and everything written after it is dropped.
    """

    def __init__(self, stream: RawIOBase) -> None:
        self._stream = stream
        self.seek, self.tell, self.read, self.readinto = stream.seek, stream.tell, stream.read, stream.readinto
        self.error: OSError | None = None

    def write(self, data: Any) -> None:
        left = memoryview(data)
        with self._kept():
            while left and self.error is None:
                left = left[self._stream.write(left) :]

    def truncate(self, size: int) -> None:
        with self._kept():
            self._stream.truncate(size)

    def flush(self) -> None:
        """Do nothing: there is no buffer."""

    @contextmanager
    def _kept(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            self.error = self.error or error


def _unwritten(shape: tuple[int, ...], kind: type = np.float64) -> NDArray[Any]:
    """An array of a shape that takes no memory."""
    return np.broadcast_to(np.zeros((), kind), shape)


def write_inline_xdmf(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write one file with the cells and the numbers as text, without the boundary edges."""
    _grid(mesh, _Topology.of(mesh), _cell_data(mesh, fields), _nodal_data(mesh), _inline).write(path)


def _require_name(path: Path) -> None:
    if ":" in path.name:
        raise CaseError(f"{path.name}: the name of an XDMF file cannot hold a colon; choose another name")


def _beside(path: Path) -> Path:
    return path.with_name(f"{path.stem}_facets{path.suffix}")


def _facet_data(mesh: Mesh) -> _Data:
    return {"label": facet_ids(mesh).astype(np.int32)}


def _cell_data(mesh: Mesh, fields: Fields) -> _Data:
    # The tags come first, since dolfinx reads the first attribute by default; it reads them as int32.
    data = {"material": np.concatenate([cell_ids(mesh, cells) for cells in mesh.cells]).astype(np.int32)}
    for name, values in fields.items():
        data[name] = np.concatenate([cell_values(values, cells) for cells in mesh.cells])
    if mesh.partition is not None:
        first = np.concatenate([cells.triangles[:, 0] for cells in mesh.cells])
        data[PARTITION] = mesh.partition.owner[first].astype(np.int32)
    return data


def _nodal_data(mesh: Mesh) -> _Data:
    return {} if mesh.partition is None else {NODE_OWNER: mesh.partition.node_owner.astype(np.int32)}


def _write_pair(path: Path, mesh: Mesh, topology: _Topology, data: _Data, nodal: _Data) -> None:
    heavy = path.with_suffix(".h5")
    # Built in memory, so that a full disk raises a plain OSError, and no lock is needed on a network drive.
    with h5py.File(str(heavy), "w", driver="core", backing_store=False) as file:

        def store(array: NDArray[Any]) -> tuple[str, str]:
            name = f"data{len(file)}"
            # Flushed, as otherwise it is written when its last reference goes, which a profiler may hold for a while.
            file.create_dataset(name, data=array, compression="gzip", compression_opts=4).flush()
            return "HDF", f"{heavy.name}:/{name}"

        tree = _grid(mesh, topology, data, nodal, store)
        file.flush()
        heavy.write_bytes(file.id.get_file_image())
    tree.write(path)


def _inline(array: NDArray[Any]) -> tuple[str, str]:
    rows = array.reshape(len(array), -1).tolist()
    return "XML", "\n" + "\n".join(" ".join(map(repr, row)) for row in rows) + "\n"


def _grid(mesh: Mesh, topology: _Topology, data: _Data, nodal: _Data, store: _Store) -> "ET.ElementTree[ET.Element]":
    root = ET.Element("Xdmf", Version="3.0")
    grid = ET.SubElement(ET.SubElement(root, "Domain"), "Grid", Name="Grid", GridType="Uniform")
    _add_names(grid, mesh)
    geometry = ET.SubElement(grid, "Geometry", GeometryType="XY")
    _add_item(geometry, mesh.points, store)
    shape = {"TopologyType": topology.kind, "NumberOfElements": str(topology.count)}
    if topology.cells.ndim == 2:
        shape["NodesPerElement"] = str(topology.cells.shape[1])
    _add_item(ET.SubElement(grid, "Topology", shape), topology.cells.astype(np.int64, copy=False), store)
    for center, arrays in (("Cell", data), ("Node", nodal)):
        for name, values in arrays.items():
            attribute = ET.SubElement(grid, "Attribute", Name=name, AttributeType="Scalar", Center=center)
            _add_item(attribute, values, store)
    ET.indent(root)
    return ET.ElementTree(root)


def _add_names(grid: ET.Element, mesh: Mesh) -> None:
    # XDMF has no named groups; meshio reads them in this form, and other readers ignore it.
    names = ET.Element("main")
    for name, (tag, dimension) in group_names(mesh).items():
        ET.SubElement(names, "map", key=name, dim=str(dimension)).text = str(tag)
    information = ET.SubElement(grid, "Information", Name="Information", Value=str(len(names)))
    information.text = ET.tostring(names, encoding="unicode")


def _add_item(parent: ET.Element, array: NDArray[Any], store: _Store) -> None:
    form, text = store(array)
    described = {
        "DataType": _DATA_TYPES[array.dtype.kind],
        "Dimensions": " ".join(map(str, array.shape)),
        "Format": form,
        "Precision": str(array.dtype.itemsize),
    }
    ET.SubElement(parent, "DataItem", described).text = text
