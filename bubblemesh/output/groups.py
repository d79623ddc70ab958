"""Groups of cells in a foreign mesh: the labels of its edges and the regions of its triangles."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from bubblemesh.arrays import Integers

__all__ = ["grouped"]

# What the readers of meshio and the writers of this package call the numbers of groups.
TAGS = ("gmsh:physical", "medit:ref", "su2:tag", "cell_tags", "material", "label")
DIMENSIONS = {"label": 1, "region": 2}


def grouped(mesh: Any, kinds: Sequence[str], noun: str) -> tuple[tuple[str, ...], Integers]:
    """Names of the groups that cells of some kinds are in, and the index (c,) of each cell's group.

    Parameters
    ----------
    mesh : meshio.Mesh
    kinds : sequence of str
        Types of the cells.
    noun : {"label", "region"}
        What a group is called whose name the file does not tell.

    Returns
    -------
    names : tuple of str
        Empty where the file has no groups of such cells; then the indices are as well.
    index : (c,)
    """
    mine = [k for k, block in enumerate(mesh.cells) if block.type in kinds and len(block.data)]
    for name in TAGS:
        if mine and name in mesh.cell_data:
            tags = np.concatenate([np.asarray(mesh.cell_data[name][k]) for k in mine])
            if tags.ndim == 1 and np.array_equal(tags, np.round(tags)):
                numbers, index = np.unique(tags.astype(np.int64), return_inverse=True)
                return tuple(_name(mesh, int(number), noun) for number in numbers), index
    return _of_sets(mesh, mine, noun)


def _name(mesh: Any, tag: int, noun: str) -> str:
    for name, (number, dimension) in mesh.field_data.items():
        if (number, dimension) == (tag, DIMENSIONS[noun]):
            return str(name)
    names = getattr(mesh, "cell_tags", {}).get(tag)  # of MED files
    return ", ".join(names) if names else f"{noun} {tag}"


def _of_sets(mesh: Any, mine: Sequence[int], noun: str) -> tuple[tuple[str, ...], Integers]:
    """Groups by the sets of cells that the file names; of several sets with a cell the smallest counts."""
    counts = [len(mesh.cells[k].data) for k in mine]
    start = np.cumsum([0, *counts])
    sets = {}
    for name, blocks in mesh.cell_sets.items():
        members = [start[i] + np.asarray(blocks[k], np.int64) for i, k in enumerate(mine) if blocks[k] is not None]
        cells = np.concatenate([np.zeros(0, np.int64), *members])
        if len(cells):
            sets[str(name)] = cells
    if not sets:
        return (), np.zeros(0, np.int64)
    names = sorted(sets, key=lambda name: -len(sets[name]))
    index = np.full(start[-1], -1)
    for number, name in enumerate(names):
        index[sets[name]] = number
    present, index = np.unique(index, return_inverse=True)
    return tuple(f"no {noun}" if k < 0 else names[k] for k in present), index
