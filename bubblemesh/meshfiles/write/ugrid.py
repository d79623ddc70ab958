"""UGRID: a NetCDF file of a mesh with the height of its bed, for Delft3D FM and programs that show such files.

References
----------
B. Jagers and others, "UGRID Conventions (v1.0)".
"""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bubblemesh.meshes.edges import edge_keys, find_keys, numbered_edges
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles.groups import Fields, cell_ids, cell_values, facet_ids, group_names, plain_words

# Attributes of the coordinates of nodes.
PROJECTED = {axis: {"standard_name": f"projection_{axis}_coordinate"} for axis in "xy"}
DEGREES = {
    "x": {"standard_name": "longitude", "units": "degrees_east"},
    "y": {"standard_name": "latitude", "units": "degrees_north"},
}
MESH, NONE = "mesh2d", -999
NODE, EDGE, FACE, CORNERS, ENDS = (f"n{MESH}_{word}" for word in ("node", "edge", "face", "corners", "ends"))


def write_ugrid(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write nodes, edges and cells; regions and fields of cells, labels of edges, and the height of the bed at nodes.

    Labelled points are not written.
    """
    from scipy.io import netcdf_file  # here, so that cases without such files do not wait for it

    edges = _edges(mesh)
    with netcdf_file(path, "w", version=2) as file:
        _attributes(file, {"Conventions": "CF-1.8 UGRID-1.0"})
        width = max(cells.nodes.shape[1] for cells in mesh.cells)
        counts = {NODE: len(mesh.points), EDGE: len(edges), FACE: sum(len(cells.nodes) for cells in mesh.cells)}
        for name, count in (counts | {CORNERS: width, ENDS: 2}).items():
            file.createDimension(name, count)
        _topology(file)
        about = DEGREES if mesh.geographic else PROJECTED
        for axis, values in zip("xy", mesh.points.T, strict=True):
            _variable(file, f"node_{axis}", values, (NODE,), **about[axis], long_name=f"{axis} of nodes")
        faces = np.concatenate([_padded(cells.nodes + 1, width) for cells in mesh.cells])
        start = {"start_index": np.int32(1)}
        none = {"_FillValue": np.int32(NONE)}
        _variable(file, "face_nodes", faces, (FACE, CORNERS), cf_role="face_node_connectivity", **start, **none)
        _variable(file, "edge_nodes", edges + 1, (EDGE, ENDS), cf_role="edge_node_connectivity", **start)
        regions = np.concatenate([cell_ids(mesh, cells) for cells in mesh.cells])
        _data(file, "face_region", regions, FACE, **_flags(mesh, 2))
        _data(file, "edge_label", _labels_of_edges(mesh, edges), EDGE, **_flags(mesh, 1))
        for name, of_triangles in fields.items():
            values = np.concatenate([cell_values(of_triangles, cells) for cells in mesh.cells])
            _data(file, f"face_{name}", values, FACE)
        if len(mesh.depth):
            _data(file, "node_z", 0 - mesh.depth, NODE, standard_name="altitude", units="m", positive="up")


def words(mesh: Mesh) -> dict[str, str]:
    """For the name of each label and region, the word that stands for it."""
    return plain_words(mesh, dimensions=(1, 2))


def _topology(file: Any) -> None:
    """Add the variable that describes the others."""
    about: dict[str, Any] = {
        "cf_role": "mesh_topology",
        "long_name": "mesh by bubblemesh",
        "topology_dimension": np.int32(2),
        "node_coordinates": f"{MESH}_node_x {MESH}_node_y",
        "node_dimension": NODE,
        "edge_node_connectivity": f"{MESH}_edge_nodes",
        "edge_dimension": EDGE,
        "face_node_connectivity": f"{MESH}_face_nodes",
        "face_dimension": FACE,
        "max_face_nodes_dimension": CORNERS,
    }
    _attributes(file.createVariable(MESH, "i4", ()), about)


def _variable(file: Any, name: str, values: NDArray[Any], dimensions: tuple[str, ...], **about: Any) -> None:
    kind = "f8" if values.dtype.kind == "f" else "i4"
    variable = file.createVariable(f"{MESH}_{name}", kind, dimensions)
    variable[:] = values
    _attributes(variable, about)


def _data(file: Any, name: str, values: NDArray[Any], dimension: str, **about: Any) -> None:
    """Values in each node, edge or face."""
    location = dimension.rpartition("_")[2]
    _variable(file, name, values, (dimension,), mesh=MESH, location=location, **about)


def _attributes(part: Any, about: dict[str, Any]) -> None:
    for name, value in about.items():
        setattr(part, name, value)


def _flags(mesh: Mesh, dimension: int) -> dict[str, Any]:
    """Attributes with the names of the groups by their numbers."""
    groups = {name: group.id for name, group in group_names(mesh).items() if group.dimension == dimension}
    spelled = words(mesh)
    meanings = " ".join(spelled[name] for name in groups)
    return {"flag_values": np.array([*groups.values()], np.int32), "flag_meanings": meanings}


def _padded(nodes: NDArray[np.int64], width: int) -> NDArray[np.int64]:
    return np.pad(nodes, ((0, 0), (0, width - nodes.shape[1])), constant_values=NONE)


def _edges(mesh: Mesh) -> NDArray[np.int64]:
    """Edges (e, 2) of all cells, without diagonals of quadrilaterals."""
    edges, of_triangle = numbered_edges(mesh.triangles)
    if len(mesh.quads) == 0:
        return edges
    first, second = of_triangle[mesh.quads[:, 0]], of_triangle[mesh.quads[:, 1]]
    diagonal = first[(first[:, :, None] == second[:, None, :]).any(axis=2)]
    return np.delete(edges, diagonal, axis=0)


def _labels_of_edges(mesh: Mesh, edges: NDArray[np.int64]) -> NDArray[np.int64]:
    """Ids (e,) of the labels of edges, 0 for others."""
    n = len(mesh.points)
    place = find_keys(edge_keys(edges, n), edge_keys(np.sort(mesh.facets[:, :2], axis=1), n))
    labels = np.zeros(len(edges), np.int64)
    labels[place[place >= 0]] = facet_ids(mesh)[place >= 0]
    return labels
