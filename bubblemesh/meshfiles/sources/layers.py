"""The plane mesh below a layer of solid cells, which OpenFOAM needs and CalculiX makes of plane elements."""

from dataclasses import replace

import numpy as np

from bubblemesh.meshfiles.sources.source import Block, Data, Source

# Corners of one side of the layer, by kinds of cells.
SIDES = {**dict.fromkeys(("wedge", "wedge15", "wedge18"), 3), **dict.fromkeys(("hexahedron", "hexahedron20"), 4)}
SIDES["hexahedron27"] = 4
FACES = {3: "triangle", 4: "quad"}
GROUP = "gmsh:physical"  # data of cells: the number of the group
OTHERS = ("tetra", "tetra10", "pyramid", "pyramid13")
ROUNDING = 1e-6  # of the layer's height


def flattened(source: Source) -> Source:
    """The lower side of a layer of cells between two planes z = constant; other sources as they are.

    Prisms become triangles, hexahedra quadrilaterals, upright rectangles edges, and their groups are one dimension
    lower. Cells of other kinds are left out, and so are groups that have only such cells.
    """
    solid = [block for block in source.cells if block.type in (*SIDES, *OTHERS) and len(block.data)]
    if not solid or any(block.type in OTHERS for block in solid) or source.points.shape[1] != 3:
        return source
    z = source.points[:, 2]
    used = np.concatenate([block.data[:, : 2 * SIDES[block.type]].ravel() for block in solid])
    if used.min() < 0 or used.max() >= len(z):
        return source
    low, high = _levels(z, used)
    if not all((_all_at(low, side) ^ _all_at(high, side)).all() for block in solid for side in _sides(block)):
        return source
    rows = [_in_layer(block, low) for block in source.cells]
    kept = [k for k, mine in enumerate(rows) if len(mine)]
    cells = [_cut(source.cells[k].type, source.cells[k].data[rows[k]], low) for k in kept]
    data = {name: [np.asarray(values[k])[rows[k]] for k in kept] for name, values in source.cell_data.items()}
    sets = {name: [_among(chosen[k], rows[k]) for k in kept] for name, chosen in source.cell_sets.items()}
    # Groups of cells that are left out, such as OpenFOAM's patches front and back: their names may be used by others.
    used = np.concatenate([np.zeros(0, int), *data.get(GROUP, ())])
    groups = {
        name: (number, dimension - 1) for name, (number, dimension) in source.field_data.items() if number in used
    }
    return replace(source, cells=cells, cell_data=data, cell_sets=sets, field_data=groups)


def _levels(z: Data, nodes: Data) -> tuple[Data, Data]:
    """Masks (n,) of the nodes at the lowest and at the highest z of the given ones."""
    bottom, top = float(z[nodes].min()), float(z[nodes].max())
    near = ROUNDING * (top - bottom)
    return np.asarray(np.abs(z - bottom) <= near), np.asarray(np.abs(z - top) <= near)


def _all_at(level: Data, cells: Data) -> Data:
    return np.asarray(level[cells].all(axis=1))


def _sides(block: Block) -> tuple[Data, Data]:
    """Corners (m, 3) or (m, 4) of both sides of solid cells."""
    count = SIDES[block.type]
    return block.data[:, :count], block.data[:, count : 2 * count]


def _in_layer(block: Block, low: Data) -> Data:
    """Numbers (k,) of the cells with a side or an edge in the lower plane: solid ones, and upright rectangles."""
    if block.type in SIDES:
        return np.arange(len(block.data))
    if block.type in ("quad", "quad8", "quad9"):
        return np.flatnonzero(low[block.data[:, :4]].sum(axis=1) == 2)
    return np.zeros(0, np.int64)


def _cut(kind: str, cells: Data, low: Data) -> Block:
    """The part of some cells in the lower plane, one for each."""
    if kind in SIDES:
        first, second = _sides(Block(kind, cells))
        return Block(FACES[SIDES[kind]], np.where(_all_at(low, first)[:, None], first, second))
    corners = cells[:, :4]
    order = np.argsort(~low[corners], axis=1, kind="stable")[:, :2]
    return Block("line", np.take_along_axis(corners, order, axis=1))


def _among(chosen: Data | None, rows: Data) -> Data | None:
    """Indices, in the rows, of the cells of a set that are among them."""
    return None if chosen is None else np.flatnonzero(np.isin(rows, chosen))
