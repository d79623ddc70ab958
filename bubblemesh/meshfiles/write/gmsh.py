"""Gmsh's mesh format 2.2: the one that solvers read most widely, with named groups."""

from collections.abc import Iterator, Sequence
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles.groups import (
    Fields,
    Group,
    cell_kinds,
    facet_ids,
    group_names,
    node_ids,
    plain_words,
    region_ids,
)
from bubblemesh.meshfiles.text import lines, numbered, write_text

# Gmsh's numbers of the kinds of cells, by meshio's names.
KINDS = {"line": 1, "triangle": 2, "quad": 3, "wedge": 6, "line3": 8, "triangle6": 9, "vertex": 15}


class Block(NamedTuple):
    """Cells (m, k) of one kind and their group ids (m,)."""

    kind: str
    cells: Integers
    ids: Integers


Matching = tuple[int, tuple[int, int], Floats, Integers]
"""An entity that is a copy of another one, in meshio's order: its dimension, its own and the original's number, the map
(16,) from the original to the copy by rows, and nodes (k, 2) of the copy and of the original."""


def write_msh(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write points, edges and triangles with their physical groups, binary, and which nodes of periodic sides match.

    The format has no place for the fields.
    """
    result = as_meshio(mesh)
    result.points = np.pad(mesh.points, ((0, 0), (0, 1)))
    result.write(path, file_format="gmsh22", binary=True)


def as_meshio(mesh: Mesh) -> Any:
    """Return a `meshio.Mesh` of points, edges and triangles, with Gmsh's ids and names, and its periodic sides."""
    import meshio

    blocks = _blocks(mesh)
    # One elementary entity for each physical group: readers want both tags, and none of them 0.
    ids = [block.ids.astype(np.int32) for block in blocks]
    return meshio.Mesh(
        mesh.points,
        [(block.kind, block.cells) for block in blocks],
        cell_data={"gmsh:physical": ids, "gmsh:geometrical": ids},
        field_data={name: np.array(group) for name, group in group_names(mesh).items()},
        gmsh_periodic=_periodic(mesh) or None,
    )


def write_msh_ascii(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write points, edges, triangles, groups and matching nodes as `write_msh` does, as text."""
    text = _plane_text(mesh, _blocks(mesh), list(group_names(mesh).items()))
    write_text(path, chain(text, _periodic_text(_periodic(mesh))))


def write_words(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write what `write_msh_ascii` does but for matching nodes, the groups by words, as Netgen cuts names at spaces."""
    words = plain_words(mesh)
    groups = [(words[name], group) for name, group in group_names(mesh).items()]
    write_text(path, _plane_text(mesh, _blocks(mesh), groups))


def write_boundary(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write triangles and the edges of the boundary alone: deal.II takes no inner edges, and points for nothing."""
    blocks = [
        Block("line", mesh.facets[mesh.outer], facet_ids(mesh)[mesh.outer]),
        Block("triangle", mesh.triangles, region_ids(mesh)),
    ]
    present = {int(number) for block in blocks for number in np.unique(block.ids)}
    groups = [(name, group) for name, group in group_names(mesh).items() if group.id in present]
    write_text(path, _plane_text(mesh, blocks, groups))


def _plane_text(mesh: Mesh, blocks: Sequence[Block], groups: Sequence[tuple[str, Group]]) -> Iterator[str]:
    return msh_text(np.pad(mesh.points, ((0, 0), (0, 1))), blocks, groups)


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


def _periodic(mesh: Mesh) -> list[Matching]:
    """The periodic sides as Gmsh knows them: entities of edges, each with the one that it is a copy of."""
    found = []
    for sides in mesh.periodic_sides:
        affine = np.eye(4)
        affine[:2, 3] = sides.shift
        found.append((1, (sides.second + 1, sides.first + 1), affine.ravel(), sides.nodes[:, ::-1]))
    return found


def _periodic_text(matches: Sequence[Matching]) -> Iterator[str]:
    if not matches:
        return
    yield f"$Periodic\n{len(matches)}\n"
    for dimension, (copy, original), affine, nodes in matches:
        yield f"{dimension} {copy} {original}\nAffine {' '.join(map(repr, affine.tolist()))}\n{len(nodes)}\n"
        yield from lines("%d %d", nodes + 1)
    yield "$EndPeriodic\n"


def _blocks(mesh: Mesh) -> list[Block]:
    line, triangle = cell_kinds(mesh)
    blocks = [Block(line, mesh.facets, facet_ids(mesh)), Block(triangle, mesh.triangles, region_ids(mesh))]
    if len(mesh.labelled_nodes):
        blocks.insert(0, Block("vertex", mesh.labelled_nodes[:, None], node_ids(mesh)))
    return blocks
