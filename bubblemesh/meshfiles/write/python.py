"""VTK's files with groups in the form of solvers in Python: the cell data of scikit-fem, and the ids of SfePy."""

import re
from pathlib import Path

import numpy as np

from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles.groups import (
    CELL_KINDS,
    Fields,
    facet_ids,
    group_names,
    point_ids,
    region_ids,
)

CUT = re.compile(r"[:<>&]")
# scikit-fem's number of the side between two corners of a triangle, by the sum of their ranks among its three nodes.
SIDE_OF_RANKS = np.array([-1, 0, 2, 1])


def write_skfem(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write triangles with the cell data in which scikit-fem itself stores subdomains and boundaries.

    The data of a region is 1 in its triangles; that of a label has a bit for each side of a triangle with the label.
    """
    import meshio

    words, groups, regions, labels = skfem_names(mesh), group_names(mesh), region_ids(mesh), facet_ids(mesh)
    data = {
        f"skfem:s:{words[name]}": [(regions == group.id).astype(np.int64)]
        for name, group in groups.items()
        if group.dimension == 2
    }
    triangle, side = mesh.sides.T
    if mesh.order == 1:  # scikit-fem sorts the nodes of each triangle, but not of those with six
        ranks = np.argsort(np.argsort(mesh.triangles, axis=1), axis=1)
        side = SIDE_OF_RANKS[ranks[triangle, side] + ranks[triangle, (side + 1) % 3]]
    for name, group in groups.items():
        if group.dimension == 1:
            mine = labels == group.id
            flags = np.zeros(len(mesh.triangles), np.int64)
            np.bitwise_or.at(flags, triangle[mine], 1 << side[mine])
            data[f"skfem:b:{words[name]}"] = [flags]
    grid = meshio.Mesh(_in_space(mesh), [(CELL_KINDS[mesh.triangles.shape[1]], mesh.triangles)], cell_data=data)
    grid.write(path, file_format="vtu", binary=True, compression="zlib")


def skfem_names(mesh: Mesh) -> dict[str, str]:
    """Return the name of each subdomain and boundary: scikit-fem cuts names at a colon, meshio writes no XML marks."""
    groups = {name: group for name, group in group_names(mesh).items() if group.dimension > 0}
    names: dict[str, str] = {}
    taken = set(groups)
    for name, group in groups.items():
        word = CUT.sub("_", name)
        while word != name and word in taken:
            word = f"{word}_{group.id}"
        names[name] = word
        taken.add(word)
    return names


def write_sfepy(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write triangles with the ids of regions as ``mat_id`` and those of nodes as ``node_groups``.

    A node has the id of its own label, else that of a facet at it, else 0.
    """
    import meshio

    grid = meshio.Mesh(
        _in_space(mesh),
        [(CELL_KINDS[mesh.triangles.shape[1]], mesh.triangles)],
        {"node_groups": point_ids(mesh)},
        {"mat_id": [region_ids(mesh)]},
    )
    grid.write(path, file_format="vtk42", binary=True)


def _in_space(mesh: Mesh) -> "np.ndarray[tuple[int, int], np.dtype[np.float64]]":
    return np.pad(mesh.points, ((0, 0), (0, 1)))
