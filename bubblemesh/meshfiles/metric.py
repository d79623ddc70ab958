"""Metrics in mesh files: tensors at their nodes, or of their triangles as runs write them."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import CaseError, prefixed
from bubblemesh.meshes.metric import ENTRIES, nodes_of_triangles, tensors_in, triangles_of_nodes
from bubblemesh.meshes.tensors import area_sizes, require_positive_definite
from bubblemesh.meshfiles.read import (
    MeshWithData,
    NodalField,
    cell_data_of,
    linear_triangles,
    nodal_field,
    own_names,
)
from bubblemesh.messages import counted, place

COLUMNS = {3: [0, 1, 2], 4: [0, 1, 3], 9: [0, 1, 4]}  # of m11, m12 and m22, by the number of components
SAME_AS_M12 = {3: 1, 4: 2, 9: 3}  # column of m21, by the same
UNEQUAL = 1e-6  # relative difference of the two that is more than rounding of short numbers


def read_metric(path: Path, name: str | None, chosen_by: str = "--field") -> NodalField:
    """Read a metric in a mesh file of triangles, with positive tensors (n, 3) as its values.

    It is the data ``name`` at the nodes, or the only data there. If none there has as many numbers as a tensor, nodes
    get the mean of the tensors of the triangles around. FileError as of `linear_triangles`, and CaseError as of
    `nodal_field`; CaseError if the data is no metric.
    """
    file = linear_triangles(path)
    named = name is not None or _names(file.source.point_data)
    of_triangles = None if named else tensors_in(cell_data_of(file))
    if of_triangles is not None:
        tensors = nodes_of_triangles(file.triangles, of_triangles, len(file.points))
        return NodalField("metric", file.points, file.triangles, tensors, file.source.notes)
    read = nodal_field(file, name, chosen_by)
    with prefixed(f"{path}: {read.name}"):
        return read._replace(values=_tensors(read.points, read.values))


def with_metric(read: MeshWithData) -> MeshWithData:
    """The mesh with a metric among the data of its triangles: by that at its nodes if they have none.

    CaseError if there is none at the nodes either, or more than one.
    """
    if tensors_in(read.cell_data) is not None:
        return read
    names = _names(read.point_data)
    if len(names) != 1:
        found = f"has several that may be one at its nodes ({', '.join(names)})" if names else "holds no metric"
        raise CaseError(
            f"{found}: its triangles need the data {', '.join(ENTRIES)}, or its nodes m11, m12 and m22 as one data, "
            "those of a .mesh in the .sol beside it"
        )
    with prefixed(names[0]):
        values = read.point_data[names[0]]
        tensors = _tensors(read.mesh.points, values.reshape(len(values), -1))
    entries = triangles_of_nodes(read.mesh.triangles, tensors).T
    return read._replace(cell_data={**read.cell_data, **dict(zip(ENTRIES, entries, strict=True))})


def _names(data: Mapping[str, Any]) -> list[str]:
    """Names of the data at nodes with as many numbers at each as a tensor has."""
    return [name for name in own_names(data) if np.size(data[name]) in [k * len(data[name]) for k in COLUMNS]]


def _tensors(points: Floats, values: Floats) -> Floats:
    """Positive tensors (n, 3) of values (n, k) at points (n, 2); CaseError if they are none."""
    columns = COLUMNS.get(values.shape[1])
    if columns is None:
        raise CaseError(
            f"has {counted(values.shape[1], 'component')}: a metric has three, m11, m12 and m22, or all of a matrix"
        )
    tensors, other = values[:, columns], values[:, SAME_AS_M12[values.shape[1]]]
    bad = np.flatnonzero(np.abs(other - tensors[:, 1]) > UNEQUAL * np.abs(tensors).max(axis=1))
    if len(bad):
        raise CaseError(f"is not symmetric at {place(points[bad[0]])}: m12 and m21 have to be the same")
    require_positive_definite(area_sizes(tensors), lambda k: points[k])
    return tensors
