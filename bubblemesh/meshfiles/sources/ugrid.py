"""UGRID: plane meshes in NetCDF files, with the data at their nodes and of their cells."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from bubblemesh.arrays import Integers, each_once
from bubblemesh.errors import FileError
from bubblemesh.meshfiles.sources.source import Block, Data, Source
from bubblemesh.readers.grids.netcdf import Variable, netcdf

FACES = {3: "triangle", 4: "quad"}
GROUP = "material"
GROUPS = {"face": ("face_region", 2), "edge": ("edge_label", 1)}  # data that are ids of groups, their dimension
SEVERAL = "has data of several times: the last one is taken"

Variables = Mapping[str, Variable]


def read_ugrid(path: Path) -> Source:
    """Cells with their data, of the last time, and the labelled edges; FileError if there is no plane mesh."""
    with netcdf(path) as variables:
        return _Mesh(variables).source()


class _Mesh:
    """The first plane mesh of a file's variables."""

    def __init__(self, variables: Variables) -> None:
        self.variables = variables
        plane = (name for name, each in variables.items() if _is_plane(each))
        self.name = next(plane, "")
        if not self.name:
            raise FileError("holds no plane mesh (cf_role = mesh_topology): it is no UGRID file")
        self.topology = variables[self.name]

    def source(self) -> Source:
        """The mesh, with its data and its labelled edges."""
        points, faces, edges = self._points(), self._connectivity("face"), self._connectivity("edge")
        widths = (faces >= 0).sum(axis=1)
        rows = {int(width): np.flatnonzero(widths == width) for width in each_once(widths)}
        blocks = [Block(FACES.get(k, f"polygon{k}"), faces[mine][:, :k]) for k, mine in rows.items()]
        region, names = self._groups("face", len(faces))
        label, more = self._groups("edge", len(edges))
        labelled = np.flatnonzero(label)
        blocks.append(Block("line", edges[labelled, :2]))
        values, later = self._data("face", len(faces))
        cell_data = {
            key: [*(of_faces[mine] for mine in rows.values()), np.full(len(labelled), np.nan)]
            for key, of_faces in values.items()
        }
        if names or more:
            cell_data[GROUP] = [*(region[mine] for mine in rows.values()), label[labelled]]
        at_nodes, last = self._data("node", len(points))
        notes, first = (SEVERAL,) if last or later else (), self._variable(self._coordinates[0])
        is_longitude = first.text("standard_name") == "longitude"
        return Source(points, blocks, at_nodes, cell_data, names | more, geographic=is_longitude, notes=notes)

    @property
    def _coordinates(self) -> list[str]:
        """Names of the first two coordinates of the nodes."""
        return self.topology.text("node_coordinates").split()[:2]

    def _points(self) -> Data:
        coordinates = [self._variable(word)().astype(float) for word in self._coordinates]
        if len(coordinates) < 2 or coordinates[0].shape != coordinates[1].shape or coordinates[0].ndim != 1:
            raise FileError("has no two coordinates of its nodes")
        return np.column_stack(coordinates)

    def _variable(self, name: str) -> Variable:
        if name not in self.variables:
            raise FileError(f"names a variable {name!r} that is not there")
        return self.variables[name]

    def _connectivity(self, what: str) -> Integers:
        """Nodes (m, k) of faces or edges, from 0 on, with -1 in unused columns; no rows if the file has no edges."""
        name = self.topology.text(f"{what}_node_connectivity")
        if not name and what == "edge":
            return np.zeros((0, 2), np.int64)
        variable = self._variable(name)
        values = variable()
        if values.ndim != 2 or values.dtype.kind not in "iuf" or (what == "edge" and 2 not in values.shape):
            raise FileError(f"{name} is no table of nodes")
        first = self.topology.text(f"{what}_dimension")
        if first and variable.dimensions[1] == first:
            values = values.T
        start = int(variable.attributes.get("start_index", 0))
        nodes = np.where(np.isfinite(values), values, -1).astype(np.int64)
        none = nodes == int(variable.attributes.get("_FillValue", -1))
        return np.where(none | (nodes < start), -1, nodes - start)

    def _groups(self, what: str, count: int) -> tuple[Integers, dict[str, tuple[int, int]]]:
        """Id (m,) of the group of each face or edge, 0 for none, and the groups by their names."""
        suffix, dimension = GROUPS[what]
        variable = self.variables.get(f"{self.name}_{suffix}")
        if variable is None or variable.shape != (count,):
            return np.zeros(count, np.int64), {}
        words = variable.text("flag_meanings").split()
        ids = np.atleast_1d(variable.attributes.get("flag_values", ())).tolist()
        return variable().astype(np.int64), {word: (int(k), dimension) for word, k in zip(words, ids, strict=False)}

    def _data(self, location: str, count: int) -> tuple[dict[str, Data], bool]:
        """Data at nodes or of faces, by name, without those of the mesh itself; and whether any has several times."""
        found, several = {}, False
        for name, variable in self.variables.items():
            own = name.removeprefix(f"{self.name}_{location}_")
            if variable.text("mesh") != self.name or variable.text("location") != location:
                continue
            timed = len(variable.shape) == 2 and variable.shape[1] == count
            if variable.kind not in "iuf" or not (timed or variable.shape == (count,)):
                continue
            if GROUPS.get(location, ("",))[0] != f"{location}_{own}":
                values = variable.numbers(slice(-1, None)) if timed else variable.numbers()
                found[own] = values.reshape(-1)[:count] if values.size else np.full(count, np.nan)
                several = several or (timed and variable.shape[0] > 1)
        return found, several


def _is_plane(variable: Variable) -> bool:
    return variable.text("cf_role") == "mesh_topology" and variable.attributes.get("topology_dimension") == 2
