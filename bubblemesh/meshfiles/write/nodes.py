"""The nodes alone, for codes that need no triangles: places, boundary flags, labels and outward normals."""

from itertools import chain
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bubblemesh.arrays import Booleans, Floats
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles.groups import NODE_OWNER, Fields
from bubblemesh.meshfiles.text import csv_text, lines, write_text

OPPOSITE = 1e-9  # two normals whose sum is shorter point apart, as at the contact of two rings: there is no normal


class Nodes(NamedTuple):
    """Places, flags, labels and normals of the nodes, an array (n,) for each column of a table."""

    x: Floats
    y: Floats
    boundary: Booleans  # which are on the boundary of the domain
    label: NDArray[np.str_]  # the node's own, else that of the facet which starts there, else the empty text
    nx: Floats  # unit normal out of the domain; 0 inside, and where two rings touch with normals that point apart
    ny: Floats


def nodes_of(mesh: Mesh) -> Nodes:
    """Nodes of a mesh; the normal of a corner is the mean of those of its two edges, of unit length."""
    boundary = np.zeros(len(mesh.points), bool)
    boundary[mesh.facets[mesh.outer].ravel()] = True
    label = np.full(len(mesh.points), "", dtype=object)
    names, point_names = np.array(mesh.labels, object), np.array(mesh.point_labels, object)
    # The last one stands: that of the boundary before that of inner lines, the start's before the end's.
    for facets in (~mesh.outer, mesh.outer):
        for ends in mesh.facets[facets].T[::-1]:
            label[ends] = names[mesh.facet_labels[facets]]
    label[mesh.labelled_nodes] = point_names[mesh.node_labels]
    (x, y), (nx, ny) = mesh.points.T, _normals(mesh).T
    return Nodes(x, y, boundary, label.astype(str), nx, ny)


def write_csv(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write a table with one row for each node, whose last column is the ``owner`` if there is a partition."""
    nodes = nodes_of(mesh)
    quoted = {label: csv_text([[label]])[:-1] if label else "" for label in ("", *mesh.labels, *mesh.point_labels)}
    labels = np.array([quoted[label] for label in nodes.label.tolist()], object)
    columns = nodes._replace(boundary=nodes.boundary.astype(int), label=labels)
    head, form, owner = ",".join(Nodes._fields), "%r,%r,%d,%s,%r,%r", []
    if mesh.partition is not None:
        head, form, owner = f"{head},{NODE_OWNER}", f"{form},%d", [mesh.partition.node_owner]
    write_text(path, chain([head + "\n"], lines(form, *columns, *owner)))


def write_npz(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write one NumPy array for each column, and the pairs (k, 2) of nodes that match, if there are periodic sides.

    With a partition there is the part (n,) of each node, ``owner``.
    """
    arrays = nodes_of(mesh)._asdict()
    if mesh.periodic_sides:
        arrays["periodic"] = np.concatenate([sides.nodes for sides in mesh.periodic_sides])
    if mesh.partition is not None:
        arrays[NODE_OWNER] = mesh.partition.node_owner
    with path.open("wb") as file:
        np.savez_compressed(file, **arrays)


def _normals(mesh: Mesh) -> Floats:
    """Outward normals (n, 2), from the tangents at the ends of the circular arc that each boundary facet follows."""
    facets, middle = mesh.facets[mesh.outer], mesh.facet_middles[mesh.outer]
    chord = _unit(mesh.points[facets[:, 1]] - mesh.points[facets[:, 0]])
    total = np.zeros_like(mesh.points)
    for end, sign in ((0, 1), (1, -1)):
        # The way to the middle of an arc halves the angle between its chord and its tangent.
        half = _unit(sign * (middle - mesh.points[facets[:, end]]))
        tangent = 2 * np.einsum("ij,ij->i", chord, half)[:, None] * half - chord
        np.add.at(total, facets[:, end], np.column_stack([tangent[:, 1], -tangent[:, 0]]))
    length = np.hypot(*total.T)
    return np.where(length > OPPOSITE, 1 / np.maximum(length, OPPOSITE), 0.0)[:, None] * total


def _unit(vectors: Floats) -> Floats:
    return vectors / np.hypot(*vectors.T)[:, None]
