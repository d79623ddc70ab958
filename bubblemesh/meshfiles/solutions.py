"""Reads a solution on plane triangles: values at the nodes."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import CaseError, FileError
from bubblemesh.meshfiles.read import NO_FACES, plane_points, read_mesh

NUMBERS = "iuf"  # kinds of arrays


class NodalField(NamedTuple):
    """Points (n, 2), triangles (t, 3), and values (n, k) at the points with their name."""

    name: str
    points: Floats
    triangles: Integers
    values: Floats


def read_nodal_field(path: Path, name: str | None) -> NodalField:
    """The data ``name`` at the nodes of a mesh file, or the only data that is there.

    Raises
    ------
    FileError
        If the file cannot be read, holds other faces than triangles of first order, is not plane, or has faulty points.
    CaseError
        If the name is needed, unknown, or one of data that is not given by real numbers at the nodes.
    """
    mesh = read_mesh(path)
    kinds = sorted({block.type for block in mesh.cells if len(block.data)} - {"triangle", *NO_FACES})
    if kinds:
        raise FileError(
            f"{path}: holds cells of the kind {', '.join(kinds)}: the estimate is for linear triangles: write the mesh "
            "and the solution with these alone"
        )
    blocks = [np.asarray(block.data, np.int64) for block in mesh.cells if block.type == "triangle" and len(block.data)]
    if not blocks:
        raise FileError(f"{path}: holds no triangles")
    triangles = np.concatenate(blocks)
    used = plane_points(path, mesh, triangles)
    chosen = _chosen(path, mesh, name)
    values = np.asarray(mesh.point_data[chosen])
    if values.dtype.kind not in NUMBERS:
        raise CaseError(f"{path}: {chosen} does not hold real numbers (found {values.dtype})")
    values = values.reshape(len(values), -1).astype(float)
    return NodalField(chosen, mesh.points[used, :2].astype(float), np.searchsorted(used, triangles), values[used])


def _chosen(path: Path, mesh: Any, name: str | None) -> str:
    known = [key for key in mesh.point_data if ":" not in key]  # formats keep numbers of their own as gmsh:dim_tags
    listed = ", ".join(known) or "none"
    if name is None:
        if len(known) == 1:
            return known[0]
        raise CaseError(f"{path}: has data of {len(known)} names at its nodes ({listed}): choose one by --field")
    if name in mesh.cell_data:
        raise CaseError(
            f"{path}: {name} is data of the cells: the estimate needs values at the nodes (there: {listed})"
        )
    if name not in mesh.point_data:
        raise CaseError(f"{path}: has no data {name!r} at its nodes: it has {listed}")
    return name
