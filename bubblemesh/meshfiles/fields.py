"""Data of mesh files as fields: at nodes or of cells, with the triangles that carry them."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import CaseError, prefixed
from bubblemesh.meshfiles.groups import KEPT
from bubblemesh.meshfiles.merging import joined
from bubblemesh.meshfiles.read import CORNERS, LINEAR, REAL, MeshFile, digits, read_triangles
from bubblemesh.meshfiles.sources.table import source_format

AVERAGE = "write values at the nodes, as the means of the cells around each"
HIGHER_ORDER = "has cells of higher order: they count as linear triangles, with the values at the corners"
# Parts that cover faces of any kind: all data at nodes counts.
PARTS = {
    "triangle": [[0, 1, 2]],
    "triangle6": [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]],
    "quad": [[0, 1, 2], [0, 2, 3]],
    "quad8": [[0, 4, 7], [4, 1, 5], [5, 2, 6], [6, 3, 7], [4, 5, 6], [4, 6, 7]],
    "quad9": [[0, 4, 8], [4, 1, 8], [1, 5, 8], [5, 2, 8], [2, 6, 8], [6, 3, 8], [3, 7, 8], [7, 0, 8]],
}


class FieldData(NamedTuple):
    """Data on triangles (t, 3) with corners at points (n, 2)."""

    name: str
    points: Floats
    triangles: Integers
    values: Floats  # (n,) or (n, k) at the points, or (c,) of the cells
    cells: Integers | None  # (t,) number of the cell that each triangle is a part of; None for data at points

    @property
    def at_points(self) -> bool:
        """Whether the data is at points, not of cells."""
        return self.cells is None


def read_field(path: Path, name: str | None) -> FieldData:
    """Read the data ``name`` of a mesh file, or its only data; data at nodes is preferred to data of cells.

    Faces of higher order and quadrilaterals are cut into triangles. Nodes keep their numbers. The same FileError as
    `read_triangles`, and FileError for cells that are not plane faces; CaseError if a name is needed or unknown, or if
    the data is not one real number in each place.
    """
    file = read_triangles(path, PARTS, "only plane faces have data here", as_they_are=True)
    source, triangles = file.source, file.nodes[file.triangles]
    points = np.zeros((len(source.points), 2))
    points[file.nodes] = file.points
    known = list(dict.fromkeys([*source.point_data, *source.cell_data]))
    if name is not None and name not in known:
        raise CaseError(f"{path}: has no data {name!r}: it has {', '.join(known) or 'none'}")
    data = own_names(known)
    if name is None and not data:
        raise CaseError(f"{path}: has no data: write values at its nodes or of its cells")
    if name is None and len(data) != 1:
        raise CaseError(f"{path}: has data of {len(data)} names ({', '.join(data)}): give the name of one")
    name = name or data[0]
    if name in source.point_data:
        return FieldData(name, points, triangles, _one_number_each(path, name, source.point_data[name]), None)
    values = [_one_number_each(path, name, source.cell_data[name][k]) for k in file.faces]
    parts = np.repeat([len(PARTS[source.cells[k].type]) for k in file.faces], [len(block) for block in values])
    return FieldData(name, points, triangles, np.concatenate(values), np.repeat(np.arange(len(parts)), parts))


class NodalField(NamedTuple):
    """Data (n, k) at the corners (n, 2) of triangles (t, 3)."""

    name: str
    points: Floats
    triangles: Integers
    values: Floats
    notes: tuple[str, ...]  # what was chosen of the file


def read_nodal_field(path: Path, name: str | None, chosen_by: str = "field") -> NodalField:
    """Read the data ``name`` at the nodes of a mesh file of triangles, or its only data.

    Nodes that the file has once for each cell become one if their values agree. Quadrilaterals become two triangles;
    of cells of higher order the corners are used. Messages call the option for the name ``chosen_by``. The same
    FileError as `linear_triangles`; CaseError if a name is needed or unknown, or if the data is not real numbers at the
    nodes or not continuous.
    """
    return nodal_field(linear_triangles(path), name, chosen_by)


def linear_triangles(path: Path) -> MeshFile:
    """Read the triangles of a file, and the halves of its quadrilaterals, by their corners.

    The same FileError as `read_triangles`, and FileError for cells of other kinds.
    """
    refusal = "the estimate is for triangles and quadrilaterals: write the mesh and the solution with these alone"
    return read_triangles(path, CORNERS, refusal, as_they_are=True)


def nodal_field(file: MeshFile, name: str | None, chosen_by: str) -> NodalField:
    """Data at the nodes of triangles that `linear_triangles` has read; the same CaseError as `read_nodal_field`."""
    path, data = file.path, file.source.point_data
    known = own_names(data)
    listed = ", ".join(known) or "none"
    if not known and name is None:
        of_cells = own_names(file.source.cell_data)
        if of_cells:
            raise CaseError(f"{path}: has no data at its nodes, but of its cells ({', '.join(of_cells)}): {AVERAGE}")
        ending = source_format(path).data_ending
        place = f": it has to be in a {ending} file of the same name beside it" if ending else ""
        raise CaseError(f"{path}: has no data at its nodes{place}")
    if name is None and len(known) != 1:
        raise CaseError(f"{path}: has data of {len(known)} names at its nodes ({listed}): choose one by {chosen_by}")
    name = known[0] if name is None else name
    if name in file.source.cell_data:
        raise CaseError(f"{path}: {name} is data of the cells (at the nodes: {listed}): {AVERAGE}")
    if name not in data:
        raise CaseError(f"{path}: has no data {name!r} at its nodes: it has {listed}")
    values = _real(path, name, data[name])
    values = values.reshape(len(values), -1)[file.nodes]
    with prefixed(path):
        points, triangles, values = joined(file.points, file.triangles, values, name, digits(file.source))
    higher = any(file.source.cells[k].type not in LINEAR for k in file.faces)
    notes = (*file.source.notes, *((HIGHER_ORDER,) if higher else ()))
    return NodalField(name, points, triangles, values, notes)


def own_names(data: Iterable[str]) -> list[str]:
    """Names of data, without numbers that formats and writers use themselves, such as gmsh:physical, vtkGhostType."""
    return [name for name in data if name not in KEPT and ":" not in name and not name.startswith("vtk")]


def _real(path: Path, name: str, data: Any) -> Floats:
    """Data as real numbers; CaseError if it is not."""
    values = np.asarray(data)
    if values.dtype.kind not in REAL:
        raise CaseError(f"{path}: {name} does not hold real numbers (found {values.dtype})")
    return values.astype(float)


def _one_number_each(path: Path, name: str, data: Any) -> Floats:
    """Data (n,) of one real number in each place; CaseError if it is not."""
    values = _real(path, name, data)
    components = int(np.prod(values.shape[1:]))
    if components != 1:
        raise CaseError(
            f"{path}: {name} has {components} components: a spacing is one number in each place: write the length, or "
            "one component, as data of its own"
        )
    return values.reshape(-1)
