"""Gmsh's mesh format 2.2: the one that solvers read most widely, with named groups."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.meshes import Mesh
from bubblemesh.output.cells import Fields, Group, facet_ids, group_names, region_ids, vertex_ids
from bubblemesh.output.text import lines, numbered, write_text

__all__ = ["Block", "as_meshio", "msh_text", "write_msh", "write_msh_ascii"]

# Gmsh's numbers of the kinds of cells, by meshio's names.
KINDS = {"line": 1, "triangle": 2, "quad": 3, "wedge": 6, "line3": 8, "triangle6": 9, "vertex": 15}


class Block(NamedTuple):
    """Cells (m, k) of one kind and their group ids (m,)."""

    kind: str
    cells: Integers
    ids: Integers


def write_msh(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write points, edges and triangles with their physical groups, binary; the format has no place for the fields."""
    result = as_meshio(mesh)
    result.points = np.pad(mesh.points, ((0, 0), (0, 1)))
    result.write(path, file_format="gmsh22", binary=True)


def as_meshio(mesh: Mesh) -> Any:
    """Return a `meshio.Mesh` of points, edges and triangles, with Gmsh's ids and names of the groups."""
    import meshio

    blocks = _blocks(mesh)
    # One elementary entity for each physical group: readers want both tags, and none of them 0.
    ids = [block.ids.astype(np.int32) for block in blocks]
    return meshio.Mesh(
        mesh.points,
        [(block.kind, block.cells) for block in blocks],
        cell_data={"gmsh:physical": ids, "gmsh:geometrical": ids},
        field_data={name: np.array(group) for name, group in group_names(mesh).items()},
    )


def write_msh_ascii(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write the same as text."""
    points = np.pad(mesh.points, ((0, 0), (0, 1)))
    write_text(path, msh_text(points, _blocks(mesh), list(group_names(mesh).items())))


def msh_text(points: Floats, blocks: Sequence[Block], groups: Sequence[tuple[str, Group]]) -> Iterator[str]:
    """Text of a file with points (n, 3), blocks of cells and named groups."""
    yield f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n{len(groups)}\n"
    yield from (f'{group.dimension} {group.id} "{name}"\n' for name, group in groups)
    yield f"$EndPhysicalNames\n$Nodes\n{len(points)}\n"
    yield from lines("%d %r %r %r", numbered(len(points)), points)
    yield f"$EndNodes\n$Elements\n{sum(len(block.cells) for block in blocks)}\n"
    number = 0
    for block in blocks:
        count, width = block.cells.shape
        form = f"%d {KINDS[block.kind]} 2 %d %d" + " %d" * width
        yield from lines(form, number + numbered(count), block.ids, block.ids, block.cells + 1)
        number += count
    yield "$EndElements\n"


def _blocks(mesh: Mesh) -> list[Block]:
    line, triangle = {1: ("line", "triangle"), 2: ("line3", "triangle6")}[mesh.order]
    blocks = [Block(line, mesh.facets, facet_ids(mesh)), Block(triangle, mesh.triangles, region_ids(mesh))]
    if len(mesh.vertices):
        blocks.insert(0, Block("vertex", mesh.vertices[:, None], vertex_ids(mesh)))
    return blocks
