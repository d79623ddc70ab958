"""The nodes alone, for codes that need no triangles: places, boundary flags, labels and outward normals."""

from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np
from numpy.lib.format import dtype_to_descr, write_array_header_1_0
from numpy.typing import NDArray

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.slices import SlicedMesh
from bubblemesh.meshfiles.groups import NODE_OWNER, Fields, names_of_points
from bubblemesh.meshfiles.text import csv_text, lines, write_text

OPPOSITE = 1e-9  # length of the sum of two normals that are opposite, as where rings touch: there is no normal


class Nodes(NamedTuple):
    """Places, flags, labels and normals of the nodes, an array (n,) for each column of a table."""

    x: Floats
    y: Floats
    boundary: Booleans  # which are on the boundary of the domain
    label: NDArray[np.str_]  # the node's own, else that of the facet which starts there, else the empty text
    nx: Floats  # unit normal out of the domain; 0 inside, and where two rings touch with opposite normals
    ny: Floats


def nodes_of(mesh: Mesh, outer: Booleans) -> Nodes:
    """Nodes of a mesh whose facets that are boundary edges have the mask ``outer`` (f,).

    The normal of a corner is the mean of those of its two edges, of unit length.
    """
    boundary = np.zeros(len(mesh.points), bool)
    boundary[mesh.facets[outer].ravel()] = True
    label = np.full(len(mesh.points), "", dtype=object)
    names, point_names = np.array(mesh.labels, object), np.array(names_of_points(mesh), object)
    # Later values replace earlier ones: labels of the boundary those of inner lines, those at starts those at ends.
    for facets in (~outer, outer):
        for ends in mesh.facets[facets].T[::-1]:
            label[ends] = names[mesh.facet_labels[facets]]
    label[mesh.labelled_nodes] = point_names[mesh.node_labels]
    (x, y), (nx, ny) = mesh.points.T, _normals(mesh, outer).T
    return Nodes(x, y, boundary, label.astype(str), nx, ny)


def write_csv(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write a table with one row for each node, whose last column is the ``owner`` if there is a partition."""
    owner = {} if mesh.partition is None else {NODE_OWNER: mesh.partition.node_owner}
    head = ",".join([*Nodes._fields, *owner])
    write_text(path, chain([head + "\n"], _rows(mesh, nodes_of(mesh, mesh.outer), *owner.values())))


def write_sliced_csv(mesh: SlicedMesh, path: Path) -> None:
    """Write the table of `write_csv` slice by slice."""
    tables = chain([nodes_of(mesh.frame, mesh.outer)], (_inner(part.points) for part in mesh.slices()))
    rows = chain.from_iterable(_rows(mesh.frame, nodes) for nodes in tables)
    write_text(path, chain([",".join(Nodes._fields) + "\n"], rows))


def _rows(mesh: Mesh, nodes: Nodes, *more: Integers) -> Iterator[str]:
    """Lines for nodes with the labels of a mesh, and for more numbers (n,) of each."""
    quoted = {label: csv_text([[label]])[:-1] if label else "" for label in ("", *mesh.labels, *names_of_points(mesh))}
    labels = np.array([quoted[label] for label in nodes.label.tolist()], object)
    columns = nodes._replace(boundary=nodes.boundary.astype(int), label=labels)
    return lines(",".join(["%r,%r,%d,%s,%r,%r", *("%d" for _ in more)]), *columns, *more)


def write_npz(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write one NumPy array for each column, and the pairs (k, 2) of nodes that match, if there are periodic sides.

    With a partition there is the part (n,) of each node, ``owner``.
    """
    arrays = nodes_of(mesh, mesh.outer)._asdict() | _periodic(mesh)
    if mesh.partition is not None:
        arrays[NODE_OWNER] = mesh.partition.node_owner
    with path.open("wb") as file:
        np.savez_compressed(file, **arrays)


def write_sliced_npz(mesh: SlicedMesh, path: Path) -> None:
    """Write the arrays of `write_npz` slice by slice."""
    with ZipFile(path, "w", ZIP_DEFLATED) as file:
        for k, (name, column) in enumerate(nodes_of(mesh.frame, mesh.outer)._asdict().items()):
            # Inner nodes have places only: the other columns are zeros, also empty texts, without reading slices.
            places = (part.points[:, k] for part in mesh.slices())
            zeros = (np.zeros(count, column.dtype) for count in mesh.sizes[:, 0])
            _write_array(file, name, (mesh.nodes,), chain([column], places if name in ("x", "y") else zeros))
        for name, pairs in _periodic(mesh.frame).items():
            _write_array(file, name, pairs.shape, iter([pairs]))


def _write_array(file: ZipFile, name: str, shape: tuple[int, ...], blocks: Iterator[NDArray[Any]]) -> None:
    """Write an array of a shape to an npz file, by blocks of its rows, which have one type."""
    first = next(blocks)
    header = {"descr": dtype_to_descr(first.dtype), "fortran_order": False, "shape": shape}
    with file.open(f"{name}.npy", "w", force_zip64=True) as stream:
        write_array_header_1_0(stream, header)
        for block in chain([first], blocks):
            stream.write(block.tobytes())


def _inner(points: Floats) -> Nodes:
    """Nodes without a label at points (n, 2) inside the domain."""
    (x, y), zero = points.T, np.zeros(len(points))
    return Nodes(x, y, zero.astype(bool), np.full(len(points), ""), zero, zero)


def _periodic(mesh: Mesh) -> dict[str, Integers]:
    """The pairs (k, 2) of nodes that match, if there are periodic sides."""
    sides = mesh.periodic_sides
    return {"periodic": np.concatenate([each.nodes for each in sides])} if sides else {}


def _normals(mesh: Mesh, outer: Booleans) -> Floats:
    """Outward normals (n, 2), from the tangents at the ends of the circular arc that each boundary facet follows."""
    facets, middle = mesh.facets[outer], mesh.facet_middles[outer]
    chord = _unit(mesh.points[facets[:, 1]] - mesh.points[facets[:, 0]])
    total = np.zeros_like(mesh.points)
    for end, sign in ((0, 1), (1, -1)):
        # The direction to the middle of an arc halves the angle between its chord and its tangent.
        half = _unit(sign * (middle - mesh.points[facets[:, end]]))
        tangent = 2 * np.einsum("ij,ij->i", chord, half)[:, None] * half - chord
        np.add.at(total, facets[:, end], np.column_stack([tangent[:, 1], -tangent[:, 0]]))
    length = np.hypot(*total.T)
    return np.where(length > OPPOSITE, 1 / np.maximum(length, OPPOSITE), 0.0)[:, None] * total


def _unit(vectors: Floats) -> Floats:
    return vectors / np.hypot(*vectors.T)[:, None]
