"""Meshes of other programs with all that a picture shows: labels, regions and data."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import FileError
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles.groups import grouped
from bubblemesh.meshfiles.read import NO_FACES, TRIANGLES, plane_points, read_mesh

EDGES = ("line", "line3")
NUMBERS = "iufb"  # kinds of NumPy types


class ForeignMesh(NamedTuple):
    """A mesh of a file with its data.

    Attributes
    ----------
    mesh : Mesh
        Corners only, in any orientation; ``labels`` and ``regions`` are empty where the file has none.
    cell_data, point_data : mapping of str to (t,) or (t, k), (n,) or (n, k)
        Data of the triangles and of the nodes.
    left_out : tuple of str
        Kinds of cells that were left out.
    """

    mesh: Mesh
    cell_data: Mapping[str, Floats]
    point_data: Mapping[str, Floats]
    left_out: tuple[str, ...]


def read_foreign(path: Path) -> ForeignMesh:
    """A mesh file's triangles, labelled edges, regions and data.

    Raises
    ------
    FileError
        If the file cannot be read, holds no triangles, is not plane, or has faulty points or cells.
    """
    source = read_mesh(path)
    cells = _cells(source, TRIANGLES, 3)
    if len(cells) == 0:
        raise FileError(f"{path}: holds no triangles")
    used = plane_points(path, source, cells)
    regions, region = grouped(source, TRIANGLES, "region")
    facets, label, labels = _facets(path, source, used)
    mesh = Mesh(
        np.asarray(source.points[used, :2], float),
        np.searchsorted(used, cells),
        facets,
        label,
        labels,
        regions=regions,
        triangle_regions=region,
    )
    left_out = {block.type for block in source.cells} - {*TRIANGLES, *NO_FACES}
    return ForeignMesh(mesh, _cell_data(source), _point_data(source, used), tuple(sorted(left_out)))


def _facets(path: Path, mesh: Any, used: Integers) -> tuple[Integers, Integers, tuple[str, ...]]:
    """Labelled edges (f, 2) in terms of the nodes in use, the index (f,) of each one's label, and the labels."""
    labels, label = grouped(mesh, EDGES, "label")
    edges = _cells(mesh, EDGES, 2) if labels else np.zeros((0, 2), np.int64)
    if edges.min(initial=0) < 0 or edges.max(initial=0) >= len(mesh.points):
        raise FileError(f"{path}: an edge has a node that is not there: the file is damaged")
    kept = np.isin(edges, used).all(axis=1)  # an edge with a node that is in no triangle is no side of one
    numbers, label = np.unique(label[kept], return_inverse=True)
    return np.searchsorted(used, edges[kept]), label, tuple(labels[k] for k in numbers)


def _cells(mesh: Any, kinds: tuple[str, ...], corners: int) -> Integers:
    """Nodes (c, corners) of all cells of some kinds."""
    blocks = [block.data[:, :corners] for block in mesh.cells if block.type in kinds and len(block.data)]
    return np.concatenate(blocks).astype(np.int64) if blocks else np.zeros((0, corners), np.int64)


def _cell_data(mesh: Any) -> dict[str, Floats]:
    mine = [k for k, block in enumerate(mesh.cells) if block.type in TRIANGLES]
    found = {name: np.concatenate([np.asarray(blocks[k]) for k in mine]) for name, blocks in mesh.cell_data.items()}
    return {name: values.astype(float) for name, values in found.items() if values.dtype.kind in NUMBERS}


def _point_data(mesh: Any, used: Integers) -> dict[str, Floats]:
    found = {name: np.asarray(values)[used] for name, values in mesh.point_data.items()}
    return {name: values.astype(float) for name, values in found.items() if values.dtype.kind in NUMBERS}
