"""Meshes for other Python libraries, with their forms of labels and regions; libraries are imported when used."""

from importlib import import_module
from inspect import signature
from typing import Any, Literal

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import CaseError, FileError
from bubblemesh.meshes.edges import edge_keys, find_keys
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.metric import measures_of
from bubblemesh.meshfiles.groups import (
    cell_values,
    facet_ids,
    facet_numbers,
    group_names,
    region_ids,
    region_numbers,
)

# Command that installs each library, by the name of its package.
COMMANDS = {
    "pyvista": "pip install pyvista",
    "skfem": "pip install scikit-fem",
    "dolfinx": "conda install -c conda-forge fenics-dolfinx (it is in no package index for pip)",
}
# VTK's numbers of facets and cells, by the number of their nodes.
VTK_FACETS = {2: 3, 3: 21}
VTK_CELLS = {3: 5, 6: 22, 4: 9, 9: 28}
# Basix counts the edges of a triangle by the corner across.
BASIX_NODES = {1: [0, 1, 2], 2: [0, 1, 2, 4, 5, 3]}


def library(name: str) -> Any:
    """A library by the name of its package; FileError, with the command that installs it, if it is missing."""
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        if error.name != name:
            raise
        raise FileError(f"{name} is needed and not installed: {COMMANDS[name]}") from None


def in_space(points: Floats) -> Floats:
    """Points (n, 3) with a height of 0."""
    return np.pad(points, ((0, 0), (0, 1)))


def to_meshio(mesh: Mesh, columns: Literal[2, 3]) -> Any:
    """A `meshio.Mesh` of the cells, with labels, regions and labelled points as cell sets, and with Gmsh's ids.

    Points have two or three ``columns``, the last of which is 0; another number is a CaseError.
    """
    # Imported here, as for all libraries: it loads meshio.
    from bubblemesh.meshfiles.write.gmsh import as_meshio

    if columns not in (2, 3):
        raise CaseError(f"columns: must be 2 or 3 (found {columns!r})")
    result = as_meshio(mesh)
    result.points = mesh.points if columns == 2 else in_space(mesh.points)
    blocks = list(zip(result.cells, result.cell_data["gmsh:physical"], strict=True))
    for name, (tag, dimension) in result.field_data.items():
        result.cell_sets[name] = [np.flatnonzero((ids == tag) & (block.dim == dimension)) for block, ids in blocks]
    return result


def to_pyvista(mesh: Mesh) -> Any:
    """An unstructured grid of the cells and, after them, of the labelled edges.

    The data of its cells are ``group``, the number, from 1 on, of a region or label in ``field_data["groups"]``, and
    ``quality``: NaN for edges, the mean of their halves for quadrilaterals.
    """
    pyvista = library("pyvista")
    blocks = [*(cells.nodes for cells in mesh.cells), mesh.facets]
    cells = [np.insert(block, 0, block.shape[1], axis=1).ravel() for block in blocks]
    each = [*(VTK_CELLS[block.shape[1]] for block in blocks[:-1]), VTK_FACETS[mesh.facets.shape[1]]]
    kinds = np.repeat(each, [len(block) for block in blocks]).astype(np.uint8)
    grid = pyvista.UnstructuredGrid(np.concatenate(cells), kinds, in_space(mesh.points))
    regions = [region_numbers(mesh)[each.triangles[:, 0]] for each in mesh.cells]
    grid.cell_data["group"] = np.concatenate([*regions, facet_numbers(mesh)])
    ratios = measures_of(mesh.points, mesh.triangles[:, :3], mesh.fields).radius_ratios
    of_cells = [cell_values(ratios, each) for each in mesh.cells]
    grid.cell_data["quality"] = np.concatenate([*of_cells, np.full(len(mesh.facets), np.nan)])
    grid.field_data["groups"] = list(group_names(mesh))
    return grid


def to_skfem(mesh: Mesh) -> Any:
    """A mesh of scikit-fem, a `MeshTri` or `MeshTri2`, with labels as boundaries and regions as subdomains."""
    skfem, mesh = library("skfem"), mesh.in_triangles()
    kind = skfem.MeshTri if mesh.order == 1 else skfem.MeshTri2
    found = kind(mesh.points.T.copy(), mesh.triangles.T.copy())
    numbers = _rows_of(mesh.facets[:, :2], found.facets.T, len(mesh.points))
    boundaries = {name: numbers[mesh.facet_labels == k] for k, name in enumerate(mesh.labels)}
    subdomains = {name: np.flatnonzero(mesh.triangle_regions == k) for k, name in enumerate(mesh.regions)}
    return found.with_boundaries(boundaries).with_subdomains(subdomains)


def to_dolfinx(mesh: Mesh, comm: Any = None) -> tuple[Any, Any, Any]:
    """A mesh of dolfinx, the tags of its cells, and those of its facets; the tags are the ids of regions and labels.

    The mesh is distributed over the processes of an MPI communicator, by default all processes.
    """
    mesh = mesh.in_triangles()
    dolfinx, mpi = library("dolfinx"), import_module("mpi4py.MPI")
    comm = comm or mpi.COMM_WORLD
    mine = slice(None) if comm.rank == 0 else slice(0)
    cells = mesh.triangles[mine][:, BASIX_NODES[mesh.order]].astype(np.int64)
    found = _created(dolfinx, comm, cells, mesh.points[mine].copy(), mesh.order)
    found.topology.create_connectivity(1, 0)
    found.topology.create_connectivity(2, 0)
    tags = dolfinx.mesh.meshtags
    original = np.asarray(found.topology.original_cell_index)
    cell_tags = tags(found, 2, np.arange(len(original), dtype=np.int32), region_ids(mesh)[original].astype(np.int32))
    row = _rows_of(_facet_nodes(found), mesh.facets[:, :2], len(mesh.points))
    labelled = np.flatnonzero(row >= 0)
    facet_tags = tags(found, 1, labelled.astype(np.int32), facet_ids(mesh)[row[labelled]].astype(np.int32))
    return found, cell_tags, facet_tags


def _created(dolfinx: Any, comm: Any, cells: Integers, points: Floats, order: int) -> Any:
    """A mesh by `create_mesh`, whose arguments have changed their order and names."""
    create = import_module("dolfinx.mesh").create_mesh
    if "e" in signature(create).parameters:
        element = import_module("basix.ufl").element("Lagrange", "triangle", order, shape=(2,))
        return create(comm, cells=cells, x=points, e=element)
    ufl = import_module("ufl")  # up to 0.7
    element = ufl.VectorElement("Lagrange", ufl.Cell("triangle", geometric_dimension=2), order)
    return create(comm, cells, points, ufl.Mesh(element))


def _facet_nodes(found: Any) -> Integers:
    """Nodes (f, 2) of each facet of a mesh of dolfinx, by their original numbers."""
    vertices = found.topology.connectivity(2, 0).array.reshape(-1, 3)
    dofmap = found.geometry.dofmap
    nodes = np.asarray(getattr(dofmap, "array", dofmap)).reshape(len(vertices), -1)[:, :3]
    node = np.zeros(int(vertices.max(initial=-1)) + 1, np.int64)
    node[vertices] = np.asarray(found.geometry.input_global_indices)[nodes]
    return node[found.topology.connectivity(1, 0).array.reshape(-1, 2)]


def _rows_of(sought: Integers, pairs: Integers, n: int) -> Integers:
    """Row (m,) of each sought pair (m, 2) of nodes among the pairs (k, 2), in either direction; -1 for others."""
    keys = edge_keys(np.sort(pairs, axis=1), n)
    order = np.argsort(keys)
    place = find_keys(keys[order], edge_keys(np.sort(sought, axis=1), n))
    return np.where(place < 0, -1, order[place])
