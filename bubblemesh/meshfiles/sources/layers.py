"""One layer of prisms on a plane mesh, as OpenFOAM needs and CalculiX makes of plane elements, back to that mesh."""

from dataclasses import replace

import numpy as np

from bubblemesh.meshfiles.sources.source import Block, Data, Source

PRISMS = ("wedge", "wedge15", "wedge18")
SOLIDS = (*PRISMS, "tetra", "tetra10", "pyramid", "pyramid13", "hexahedron", "hexahedron20", "hexahedron27")
ROUNDING = 1e-6  # of the layer's height


def flattened(source: Source) -> Source:
    """The lower side of a layer of prisms between two planes of one z each, or the source as it is if it is none.

    Prisms become triangles of their three lower corners, upright rectangles edges, and groups of both are one dimension
    lower; cells of other kinds are left out.
    """
    prisms = [block.data for block in source.cells if block.type in PRISMS and len(block.data)]
    solid = [block for block in source.cells if block.type in SOLIDS and len(block.data)]
    if not prisms or len(prisms) < len(solid) or source.points.shape[1] != 3:
        return source
    z = source.points[:, 2]
    corners = np.concatenate([cells[:, :6] for cells in prisms])
    if corners.min() < 0 or corners.max() >= len(z):
        return source
    low, high = _levels(z, corners)
    sides = np.concatenate([corners[:, :3], corners[:, 3:]])
    if not (_all_at(low, sides) ^ _all_at(high, sides)).all():
        return source
    cut = [_cut(block, low) for block in source.cells]
    kept = [k for k, block in enumerate(cut) if block is not None]
    cells = [block for block in cut if block is not None]
    data = {name: [values[k] for k in kept] for name, values in source.cell_data.items()}
    sets = {name: [chosen[k] for k in kept] for name, chosen in source.cell_sets.items()}
    groups = {name: (number, dimension - 1) for name, (number, dimension) in source.field_data.items()}
    return replace(source, cells=cells, cell_data=data, cell_sets=sets, field_data=groups)


def _levels(z: Data, corners: Data) -> tuple[Data, Data]:
    """Masks (n,) of the nodes at the lowest and at the highest z of some."""
    used = z[corners]
    bottom, top = float(used.min()), float(used.max())
    near = ROUNDING * (top - bottom)
    return np.asarray(np.abs(z - bottom) <= near), np.asarray(np.abs(z - top) <= near)


def _all_at(level: Data, cells: Data) -> Data:
    return np.asarray(level[cells].all(axis=1))


def _cut(block: Block, low: Data) -> Block | None:
    """The part of some cells in the lower plane, one for each."""
    if block.type in PRISMS:
        first = _all_at(low, block.data[:, :3])
        return Block("triangle", np.where(first[:, None], block.data[:, :3], block.data[:, 3:6]))
    if block.type in ("quad", "quad8", "quad9"):
        corners = block.data[:, :4]
        if (low[corners].sum(axis=1) != 2).any():
            return None
        order = np.argsort(~low[corners], axis=1, kind="stable")[:, :2]
        return Block("line", np.take_along_axis(corners, order, axis=1))
    return None
