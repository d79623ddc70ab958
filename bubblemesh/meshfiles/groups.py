"""Groups of cells: labels of edges, regions of triangles and labelled points, as files know them."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import CaseError
from bubblemesh.labels import FORBIDDEN, LONGEST_NAME, is_writable
from bubblemesh.meshes.mesh import Mesh

Fields = Mapping[str, Floats]
"""Values for each triangle, (t,) arrays by name."""


class Group(NamedTuple):
    """Id of a label, a region or a labelled point, from 1, and the dimension of its cells."""

    id: int
    dimension: int


def cell_kinds(mesh: Mesh) -> tuple[str, str]:
    """Return what meshio calls the edges and the triangles of a mesh."""
    return ("line", "triangle") if mesh.order == 1 else ("line3", "triangle6")


def facet_ids(mesh: Mesh) -> Integers:
    """Return the (f,) ids of the facets' labels: 1 for the first label."""
    return mesh.facet_labels.astype(np.int64) + 1


def region_ids(mesh: Mesh) -> Integers:
    """Return the (t,) region ids of the triangles: those after the labels', as some readers know groups by id alone."""
    return mesh.triangle_regions.astype(np.int64) + 1 + len(mesh.labels)


def node_ids(mesh: Mesh) -> Integers:
    """Return the (v,) ids of the labelled points: those after the regions'."""
    return mesh.node_labels.astype(np.int64) + 1 + len(mesh.labels) + len(mesh.regions)


def group_names(mesh: Mesh) -> dict[str, Group]:
    """Return the group of each label, each region and each labelled point by its name, in the order of the ids.

    Readers keep one group for each name, so that a region or a point which shares its name with an earlier group gets
    a longer one.

    Raises
    ------
    CaseError
        If a name is none that every format can hold, or two labels, regions or points have the same one.
    """
    kinds = [(mesh.labels, 1, ""), (mesh.regions, 2, "_region"), (mesh.point_labels, 0, "_point")]
    found: dict[str, Group] = {}
    for names, dimension, suffix in kinds:
        twice = next((name for name, count in Counter(names).items() if count > 1), None)
        if twice is not None:
            raise CaseError(f"the name {twice!r} is there twice: give all that belong to it the same index")
        for name in names:
            _check_name(name)
            found[_unused(name, suffix, {*found, *names} - ({name} - {*found}))] = Group(len(found) + 1, dimension)
    return found


def _unused(name: str, suffix: str, taken: Iterable[str]) -> str:
    while name in taken:
        name += suffix
    return name


def _check_name(name: str) -> None:
    if not is_writable(name):
        raise CaseError(
            f"the label {name!r} cannot be written to a mesh file: use a name of at most {LONGEST_NAME} characters "
            f"without {FORBIDDEN}"
        )


# What the readers of meshio and the writers of this package call the numbers of groups.
TAGS = ("gmsh:physical", "medit:ref", "su2:tag", "cell_tags", "material", "label")
DIMENSIONS = {"label": 1, "region": 2}


def cell_groups(mesh: Any, blocks: Sequence[int], noun: str) -> tuple[tuple[str, ...], Integers]:
    """Names of the groups that the cells of some blocks are in, and the index (c,) of each cell's group.

    Parameters
    ----------
    mesh : meshio.Mesh
    blocks : sequence of int
        Numbers of the blocks, all of one kind of group.
    noun : {"label", "region"}
        What a group is called whose name the file does not tell.

    Returns
    -------
    names : tuple of str
        Empty where the file has no groups of such cells; then the indices are as well.
    index : (c,)
    """
    for name in TAGS:
        if blocks and name in mesh.cell_data:
            tags = np.concatenate([np.asarray(mesh.cell_data[name][k]) for k in blocks])
            if tags.ndim == 1 and np.array_equal(tags, np.round(tags)):
                numbers, index = np.unique(tags.astype(np.int64), return_inverse=True)
                return tuple(_name(mesh, int(number), noun) for number in numbers), index
    return _of_sets(mesh, blocks, noun)


def _name(mesh: Any, tag: int, noun: str) -> str:
    for name, (number, dimension) in mesh.field_data.items():
        if (number, dimension) == (tag, DIMENSIONS[noun]):
            return str(name)
    names = getattr(mesh, "cell_tags", {}).get(tag)  # of MED files
    return ", ".join(names) if names else f"{noun} {tag}"


def _of_sets(mesh: Any, blocks: Sequence[int], noun: str) -> tuple[tuple[str, ...], Integers]:
    """Groups by the sets of cells that the file names; of several sets with a cell the smallest counts."""
    counts = [len(mesh.cells[k].data) for k in blocks]
    start = np.cumsum([0, *counts])
    sets = {}
    for name, chosen in mesh.cell_sets.items():
        members = [start[i] + np.asarray(chosen[k], np.int64) for i, k in enumerate(blocks) if chosen[k] is not None]
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
