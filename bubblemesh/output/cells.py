"""What the formats store with the cells: ids, names of the groups, fields."""

from collections.abc import Mapping

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import CaseError
from bubblemesh.mesh import Mesh

__all__ = ["Fields", "facet_ids", "group_names", "region_id", "region_ids"]

Fields = Mapping[str, Floats]
"""Values for each triangle, (t,) arrays by name."""


def facet_ids(mesh: Mesh) -> Integers:
    """Return the (f,) ids of the boundary edges' labels: 1 for the first label."""
    return mesh.facet_labels.astype(np.int64) + 1


def region_id(mesh: Mesh) -> int:
    """Return the region's id: the one after the labels', as some readers tell groups apart by the id alone."""
    return len(mesh.labels) + 1


def region_ids(mesh: Mesh) -> Integers:
    """Return the (t,) region ids of the triangles."""
    return np.full(len(mesh.triangles), region_id(mesh), dtype=np.int64)


def group_names(mesh: Mesh) -> dict[str, tuple[int, int]]:
    """Return id and dimension for the name of each label and of the region.

    Readers keep one group for each name, so that a region which shares its name with a label gets a longer one.

    Raises
    ------
    CaseError
        If a name holds a character that XML has no form for, or that ends or escapes a quoted name in a msh file.
    """
    region = mesh.region
    while region in mesh.labels:
        region += "_region"
    names = {label: (index + 1, 1) for index, label in enumerate(mesh.labels)}
    names[region] = (region_id(mesh), 2)
    for name in names:
        _check_name(name)
    return names


def _check_name(name: str) -> None:
    if not name.isprintable() or '"' in name or "\\" in name:
        raise CaseError(
            f"the label {name!r} cannot be written to a mesh file: use a name without quotes, backslashes, "
            "line breaks and other control characters"
        )
