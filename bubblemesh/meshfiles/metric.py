"""Metrics in mesh files: tensors at their nodes, or of their triangles as runs write them."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import CaseError, prefixed
from bubblemesh.meshes.metric import ENTRIES, at_centroids, node_tensors, tensors_in
from bubblemesh.meshes.tensors import area_sizes, require_positive_definite
from bubblemesh.meshfiles.fields import NodalField, linear_triangles, nodal_field, own_names
from bubblemesh.meshfiles.read import MeshWithData, cell_data_of
from bubblemesh.meshfiles.sources.table import source_format
from bubblemesh.messages import counted, place

COLUMNS = {3: [0, 1, 2], 4: [0, 1, 3], 9: [0, 1, 4]}  # of m11, m12 and m22, by the number of components
SEPARATE = "m11", "m12", "m22"  # names of data with one entry each
SAME_AS_M12 = {3: 1, 4: 2, 9: 3}  # column of m21, by the same
UNEQUAL = 1e-6  # relative difference of m12 and m21 that is more than rounding of short numbers


def read_metric(path: Path, name: str | None, chosen_by: str) -> NodalField:
    """Read a metric in a mesh file of triangles, with positive tensors (n, 3) as its values.

    It is the data ``name`` at the nodes, the only data there with as many numbers as a tensor, or m11, m12 and m22 as
    data of their own. If no data at the nodes has as many, nodes get the mean of the tensors of the triangles around.
    The same errors as `linear_triangles` and `nodal_field`; CaseError if the data is not a metric.
    """
    file = linear_triangles(path)
    names = _names(file.source.point_data)
    name = names[0] if name is None and len(names) == 1 else name
    named = name is not None or names
    of_triangles = None if named else tensors_in(cell_data_of(file))
    if of_triangles is not None:
        tensors = node_tensors(file.triangles, of_triangles, len(file.points))
        return NodalField("metric", file.points, file.triangles, tensors, file.source.notes)
    separate = not named and all(entry in file.source.point_data for entry in SEPARATE)
    parts = [nodal_field(file, one, chosen_by) for one in (SEPARATE if separate else [name])]
    read = parts[0]._replace(name=", ".join(part.name for part in parts), values=np.hstack([p.values for p in parts]))
    with prefixed(f"{path}: {read.name}"):
        return read._replace(values=_tensors(read.points, read.values))


def with_metric(read: MeshWithData, name: str | None = None) -> MeshWithData:
    """The mesh with a metric among the data of its triangles; if it is missing there, made from that at the nodes.

    With a ``name`` it is always made from that data at the nodes. The mesh has it at its nodes, too, if it was made
    from them. CaseError if the nodes have no metric, or several.
    """
    if name is None and tensors_in(read.cell_data) is not None:
        return read
    names = _names(read.point_data)
    if name is not None and name not in read.point_data:
        raise CaseError(f"has no data {name!r} at its nodes: it has {', '.join(own_names(read.point_data)) or 'none'}")
    if name is None and len(names) > 1:
        raise CaseError(f"has several that may be one at its nodes ({', '.join(names)}): choose one by --field")
    if name is None and not names:
        raise CaseError(
            f"holds no metric: its triangles need the data {', '.join(ENTRIES)}, or its nodes m11, m12 and m22 as one "
            "data, those of a .mesh in the .sol beside it"
        )
    at_nodes = _at_nodes(read, name or names[0])
    entries = at_centroids(read.mesh.triangles[:, :3], at_nodes).T
    mesh = replace(read.mesh, metric=at_nodes)
    return read._replace(mesh=mesh, cell_data={**read.cell_data, **dict(zip(ENTRIES, entries, strict=True))})


def metric_of(read: MeshWithData, path: Path) -> tuple[Floats, Floats] | None:
    """The metric of a mesh from a file, for triangles (t, 3) and nodes (n, 3); None if the data is not surely a metric.

    If the file has only one of both, the other is made by the mean of logarithms. Data at the nodes is used only in
    formats that distinguish tensors from other data with as many numbers.
    """
    triangles, of_triangles = read.mesh.triangles, tensors_in(read.cell_data)
    if of_triangles is not None:
        return of_triangles, node_tensors(triangles, of_triangles, len(read.mesh.points))
    names = _names(read.point_data) if source_format(path).has_tensors else []
    if len(names) != 1:
        return None
    try:
        at_nodes = _at_nodes(read, names[0])
    except CaseError:  # a tensor of another kind, such as a stress
        return None
    return at_centroids(triangles[:, :3], at_nodes), at_nodes


def _at_nodes(read: MeshWithData, name: str) -> Floats:
    """Positive tensors (n, 3) from the data of a name at the nodes; CaseError if it is not a metric."""
    values = read.point_data[name]
    with prefixed(name):
        return _tensors(read.mesh.points, values.reshape(len(values), -1))


def _names(data: Mapping[str, Any]) -> list[str]:
    """Names of the data at nodes with as many numbers at each as a tensor has."""
    return [name for name in own_names(data) if np.size(data[name]) in [k * len(data[name]) for k in COLUMNS]]


def _tensors(points: Floats, values: Floats) -> Floats:
    """Positive tensors (n, 3) from values (n, k) at points (n, 2); CaseError if they are not positive tensors."""
    columns = COLUMNS.get(values.shape[1])
    if columns is None:
        found = counted(values.shape[1], "component")
        size = "; a size in all directions is a spacing, by its key field" if values.shape[1] == 1 else ""
        raise CaseError(f"has {found}: a metric has three, m11, m12 and m22, or all of a matrix{size}")
    tensors, other = values[:, columns], values[:, SAME_AS_M12[values.shape[1]]]
    bad = np.flatnonzero(np.abs(other - tensors[:, 1]) > UNEQUAL * np.abs(tensors).max(axis=1))
    if len(bad):
        raise CaseError(f"is not symmetric at {place(points[bad[0]])}: m12 and m21 have to be the same")
    require_positive_definite(area_sizes(tensors), lambda k: points[k])
    return tensors
