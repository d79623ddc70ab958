"""Reads data on the triangles of any plane mesh that meshio reads."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import CaseError, FileError
from bubblemesh.meshfiles.read import NO_FACES, plane_points, read_mesh

# Triangles that cover each kind of face, by its nodes: all data at nodes counts.
PARTS = {
    "triangle": [[0, 1, 2]],
    "triangle6": [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]],
    "quad": [[0, 1, 2], [0, 2, 3]],
    "quad8": [[0, 4, 7], [4, 1, 5], [5, 2, 6], [6, 3, 7], [4, 5, 6], [4, 6, 7]],
    "quad9": [[0, 4, 8], [4, 1, 8], [1, 5, 8], [5, 2, 8], [2, 6, 8], [6, 3, 8], [3, 7, 8], [7, 0, 8]],
}
NUMBERS = "iuf"  # kinds of arrays


class MeshData(NamedTuple):
    """Data with its name.

    Attributes
    ----------
    name : str
    points : (n, 2)
    triangles : (t, 3)
    values : (n,) or (c,)
        At the points, or of the cells.
    cells : (t,) or None
        Number of the cell that each triangle is a part of; None for data at points.
    """

    name: str
    points: Floats
    triangles: Integers
    values: Floats
    cells: Integers | None

    @property
    def at_points(self) -> bool:
        """Whether it is data at points."""
        return self.cells is None


def read_field(path: Path, name: str | None) -> MeshData:
    """The data ``name`` of a mesh file, or the only one of it; data at nodes goes before data of cells.

    Faces of higher order and quadrilaterals are cut in triangles. Nodes keep their numbers.

    Raises
    ------
    FileError
        If the file cannot be read, holds no triangles or other cells as well, is not plane, or has faulty points.
    CaseError
        If the name is needed, unknown, or one of data that is not one real number in each place.
    """
    mesh = read_mesh(path)
    foreign = {block.type for block in mesh.cells if len(block.data)} - {*PARTS, *NO_FACES}
    if foreign:
        raise FileError(
            f"{path}: holds cells of the kind {', '.join(sorted(foreign))}: only plane faces have data here"
        )
    blocks = [k for k, block in enumerate(mesh.cells) if block.type in PARTS and len(block.data)]
    if not blocks:
        raise FileError(f"{path}: holds no triangles")
    triangles = np.concatenate([_parts(mesh.cells[k]) for k in blocks])
    used = plane_points(path, mesh, triangles)
    points = np.zeros((len(mesh.points), 2))
    points[used] = mesh.points[used, :2]
    chosen = _chosen(path, mesh, name)
    if chosen in mesh.point_data:
        return MeshData(chosen, points, triangles, _real(path, chosen, mesh.point_data[chosen]), None)
    data = mesh.cell_data[chosen]
    values = [_real(path, chosen, data[k]) for k in blocks]
    parts = np.repeat([len(PARTS[mesh.cells[k].type]) for k in blocks], [len(block) for block in values])
    return MeshData(chosen, points, triangles, np.concatenate(values), np.repeat(np.arange(len(parts)), parts))


def _parts(block: Any) -> Integers:
    return np.asarray(block.data, np.int64)[:, PARTS[block.type]].reshape(-1, 3)


def _chosen(path: Path, mesh: Any, name: str | None) -> str:
    known = list(dict.fromkeys([*mesh.point_data, *mesh.cell_data]))
    if name is not None and name not in known:
        raise CaseError(f"{path}: has no data {name!r}: it has {', '.join(known) or 'none'}")
    data = [key for key in known if ":" not in key]  # formats keep numbers of their own as gmsh:physical
    if name is None and len(data) != 1:
        listed = f" ({', '.join(data)})" if data else ""
        raise CaseError(f"{path}: has data of {len(data)} names{listed}: give the name of one")
    return data[0] if name is None else name


def _real(path: Path, name: str, data: Any) -> Floats:
    """One real number in each place."""
    values = np.asarray(data)
    if values.dtype.kind not in NUMBERS:
        raise CaseError(f"{path}: {name} does not hold real numbers (found {values.dtype})")
    components = int(np.prod(values.shape[1:]))
    if components != 1:
        raise CaseError(
            f"{path}: {name} has {components} components: a spacing is one number in each place: write the length, or "
            "one component, as data of its own"
        )
    return values.reshape(-1).astype(float)
