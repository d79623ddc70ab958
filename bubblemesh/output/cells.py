"""What the formats store with the cells: ids, names of the groups, fields."""

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import CaseError
from bubblemesh.labels import FORBIDDEN, LONGEST, is_writable
from bubblemesh.meshes import Mesh

__all__ = ["Fields", "Group", "facet_ids", "group_names", "region_ids", "vertex_ids"]

Fields = Mapping[str, Floats]
"""Values for each triangle, (t,) arrays by name."""


class Group(NamedTuple):
    """Id of a label, a region or a labelled point, from 1, and the dimension of its cells."""

    id: int
    dimension: int


def facet_ids(mesh: Mesh) -> Integers:
    """Return the (f,) ids of the facets' labels: 1 for the first label."""
    return mesh.facet_labels.astype(np.int64) + 1


def region_ids(mesh: Mesh) -> Integers:
    """Return the (t,) region ids of the triangles: those after the labels', as some readers know groups by id alone."""
    return mesh.triangle_regions.astype(np.int64) + 1 + len(mesh.labels)


def vertex_ids(mesh: Mesh) -> Integers:
    """Return the (v,) ids of the labelled points: those after the regions'."""
    return mesh.vertex_labels.astype(np.int64) + 1 + len(mesh.labels) + len(mesh.regions)


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
            f"the label {name!r} cannot be written to a mesh file: use a name of at most {LONGEST} characters without "
            f"{FORBIDDEN}"
        )
