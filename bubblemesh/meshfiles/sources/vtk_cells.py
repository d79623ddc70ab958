"""Cells by VTK's numbers of their kinds, common to its XML files and its legacy files."""

from collections.abc import Mapping

import numpy as np

from bubblemesh.arrays import Integers
from bubblemesh.errors import FileError
from bubblemesh.meshfiles.sources.source import Block, Data, Source

# VTK's numbers of the kinds of cells, by meshio's names.
KINDS = {
    1: "vertex",
    3: "line",
    5: "triangle",
    9: "quad",
    10: "tetra",
    12: "hexahedron",
    13: "wedge",
    14: "pyramid",
    21: "line3",
    22: "triangle6",
    23: "quad8",
    24: "tetra10",
    25: "hexahedron20",
    26: "wedge15",
    28: "quad9",
    34: "triangle7",
}
# Kinds that depend on the number of nodes: lines of segments, polygons, and Lagrange's and Bezier's cells.
BY_SIZE = {2: "vertex", 4: "line", 6: "triangle strip", 7: "polygon", **dict.fromkeys((68, 75), "line")}
BY_SIZE |= dict.fromkeys((69, 76), "triangle") | dict.fromkeys((70, 77), "quad")
FIRST = {("line", 2), ("polygon", 3), ("polygon", 4), ("triangle", 3), ("quad", 4), ("vertex", 1)}
POLYGONS = {3: "triangle", 4: "quad"}
PIXEL, ROUND = 8, [0, 1, 3, 2]  # a rectangle whose nodes go row by row
GHOSTS = ("vtkGhostType", "vtkGhostLevels")  # not 0 for copies of cells of another process


def vtk_source(
    points: Data,
    nodes: Integers,
    ends: Integers,
    types: Integers,
    point_data: Mapping[str, Data],
    cell_data: Mapping[str, Data],
) -> Source:
    """Source of c cells of VTK's ``types`` (c,), whose ``nodes`` are in one list, up to their ``ends`` (c,).

    Cells that are copies of those of another process are left out. FileError if the arrays do not fit together.
    """
    sizes = np.diff(ends, prepend=0)
    if len(ends) != len(types) or (len(ends) and (sizes.min() < 0 or ends[-1] > len(nodes))):
        raise FileError("its lists of cells do not fit together: the file is damaged")
    own = np.ones(len(types), bool)
    for name in GHOSTS:
        if name in cell_data and len(cell_data[name]) == len(own):
            own &= cell_data[name] == 0
    wrong = next((name for name, values in cell_data.items() if len(values) != len(types)), None) or next(
        (name for name, values in point_data.items() if len(values) != len(points)), None
    )
    if wrong is not None:
        raise FileError(f"its data {wrong} has another length than the nodes or cells that it is of")
    present = np.flatnonzero(own & (sizes > 0))
    groups, group = np.unique(np.column_stack([types, sizes])[present], axis=0, return_inverse=True)
    group = group.ravel()
    begun = np.argsort(np.unique(group, return_index=True)[1])  # kinds in the order of the file
    groups, group = groups[begun], np.argsort(begun)[group]
    order = np.argsort(group, kind="stable")
    parts = np.split(present[order], np.cumsum(np.bincount(group, minlength=len(groups)))[:-1])
    blocks = []
    for (number, size), cells in zip(groups.tolist(), parts, strict=False):
        mine = nodes[ends[cells][:, None] - size + np.arange(size)]
        blocks.append(Block(_kind(number, size), mine[:, ROUND] if number == PIXEL else mine))
    named = {name: [values[cells] for cells in parts] for name, values in cell_data.items() if name not in GHOSTS}
    return Source(points, blocks, point_data, named)


def _kind(number: int, size: int) -> str:
    """meshio's name of a kind of cells, those of higher order with the number of their nodes: triangle10."""
    if number == PIXEL:
        return "quad"
    if number in BY_SIZE:
        kind = BY_SIZE[number]
        return POLYGONS.get(size, kind) if kind == "polygon" else kind if (kind, size) in FIRST else f"{kind}{size}"
    return KINDS.get(number, f"VTK {number}")
