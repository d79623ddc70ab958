"""Formats of flow solvers, whose boundaries are markers or patches with names: SU2 and OpenFOAM."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.meshfiles.groups import (
    CELL_KINDS,
    Fields,
    Group,
    facet_numbers,
    named_groups,
    plain_words,
    region_numbers,
)
from bubblemesh.meshfiles.text import lines, write_text
from bubblemesh.meshfiles.write.gmsh import GroupedCells, msh_text

LINE, CELLS = 3, {3: 5, 4: 9}  # VTK's numbers of the kinds of cells, in SU2's files, by the number of nodes
SOLIDS = {"triangle": "wedge", "quad": "hexahedron"}
FRONT, BACK = "front", "back"


def write_su2(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write cells, nodes and one marker for each label, without regions and fields.

    Labels of inner edges become markers, too, for SU2's option ``MARKER_INTERNAL``.
    """
    write_text(path, _su2_text(mesh))


def marker_names(mesh: Mesh) -> dict[str, str]:
    """Return the name of each label's marker."""
    return plain_words(mesh, dimensions=(1,))


def _su2_text(mesh: Mesh) -> Iterator[str]:
    words = marker_names(mesh)
    yield f"NDIME= 2\nNELEM= {sum(len(cells.nodes) for cells in mesh.cells)}\n"
    for nodes, _ in mesh.cells:
        yield from lines(f"{CELLS[nodes.shape[1]]}{' %d' * nodes.shape[1]}", nodes)
    yield f"NPOIN= {len(mesh.points)}\n"
    yield from lines("%r %r", mesh.points)
    yield f"NMARK= {len(mesh.labels)}\n"
    for index, label in enumerate(mesh.labels):
        mine = mesh.facets[mesh.facet_labels == index]
        yield f"MARKER_TAG= {words[label]}\nMARKER_ELEMS= {len(mine)}\n"
        yield from lines(f"{LINE} %d %d", mine)


def patch_names(mesh: Mesh) -> dict[str, str]:
    """Return the name of each label's patch and of each region's zone."""
    return plain_words(mesh, reserved=(FRONT.upper(), BACK.upper()), dimensions=(1, 2))


def write_openfoam(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write a layer of prisms and hexahedra in Gmsh's ASCII format 2.2, as meshes of OpenFOAM have volume.

    The layer begins at z = 0; its height is the side of a square with the area of the mean triangle. Labels become
    patches of quadrilaterals, regions cell zones; the lower side is the patch ``back``, the upper one ``front``.
    Labelled points and fields are not written. Patches and zones are known by their names, and have numbers that are
    all different, as OpenFOAM needs them, in place of ids of one's own.
    """
    n, words = len(mesh.points), patch_names(mesh)
    names = named_groups(mesh.labels, mesh.regions, mesh.point_labels)
    groups = [
        (words[name], Group(number, dimension + 1))
        for number, (name, dimension) in enumerate(names.items(), start=1)
        if name in words
    ]
    front, back = len(names) + 1, len(names) + 2
    height = float(np.sqrt(signed_areas(mesh.points, mesh.triangles).mean()))
    points = np.vstack([np.pad(mesh.points, ((0, 0), (0, 1)), constant_values=z) for z in (0.0, height)])
    kinds = [CELL_KINDS[cells.nodes.shape[1]] for cells in mesh.cells]
    blocks = [GroupedCells("quad", np.hstack([mesh.facets, mesh.facets[:, ::-1] + n]), facet_numbers(mesh))]
    for number, move, turn in ((front, n, 1), (back, 0, -1)):
        blocks += [
            GroupedCells(kind, cells.nodes[:, ::turn] + move, np.full(len(cells.nodes), number))
            for kind, cells in zip(kinds, mesh.cells, strict=True)
        ]
    zones = region_numbers(mesh)
    blocks += [
        GroupedCells(SOLIDS[kind], np.hstack([cells.nodes, cells.nodes + n]), zones[cells.triangles[:, 0]])
        for kind, cells in zip(kinds, mesh.cells, strict=True)
    ]
    write_text(path, msh_text(points, blocks, [*groups, (FRONT, Group(front, 2)), (BACK, Group(back, 2))]))
