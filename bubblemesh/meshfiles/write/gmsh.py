"""Gmsh's mesh format 2.2, with named groups: the version that most solvers read."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bubblemesh.arrays import Floats, Integers, different_rows
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.partition import Partition
from bubblemesh.meshfiles.groups import (
    CELL_KINDS,
    ENDS,
    FACET_KINDS,
    Fields,
    Group,
    cell_ids,
    facet_ids,
    facet_numbers,
    free_id,
    group_names,
    node_ids,
    node_numbers,
    plain_words,
    region_ids,
    region_numbers,
)
from bubblemesh.meshfiles.text import lines, numbered, write_text

# Gmsh's numbers of the kinds of cells, by meshio's names.
KINDS = {"line": 1, "triangle": 2, "quad": 3, "hexahedron": 5, "wedge": 6, "line3": 8, "triangle6": 9, "quad9": 10}
KINDS |= {"vertex": 15}

Holders = Mapping[int, Sequence[int]]
"""For each cell that is a ghost, by its number, the parts, from 1, in which it is one."""
NO_HOLDERS: Holders = {}


class GroupedCells(NamedTuple):
    """Cells (m, k) of one kind and their group ids (m,), with their parts if the mesh has a partition."""

    kind: str
    cells: Integers
    ids: Integers
    parts: Integers | None = None  # (m,) from 1
    holders: Holders = NO_HOLDERS
    entities: Integers | None = None  # (m,): their elementary entities, if these differ from the groups

    @property
    def tags(self) -> tuple[Integers, Integers]:
        """Numbers (m,) of the groups and of the elementary entities: readers need both, and other numbers than 0."""
        return self.ids, self.ids if self.entities is None else self.entities


Matching = tuple[int, tuple[int, int], Floats, Integers]
"""An entity that is a copy of another one, in meshio's order: its dimension, its own and the original's number, the map
(16,) from the original to the copy by rows, and nodes (k, 2) of the copy and of the original."""


def write_msh(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write points, edges and cells with their physical groups, in binary, and the matching nodes of periodic sides.

    With a partition, all of them have the tag of their part, but no ghosts, as readers expect the same number of tags
    for all cells of a kind. Fields are not written.
    """
    with path.open("wb") as file:
        file.write(b"$MeshFormat\n2.2 1 8\n%b\n$EndMeshFormat\n" % np.int32(1).tobytes())
        groups = sorted(_groups(mesh).items(), key=lambda item: item[1].dimension)  # in the order of meshio
        file.write("".join(names_text(groups)).encode())
        file.write(b"$Nodes\n%d\n" % len(mesh.points))
        nodes = np.zeros(len(mesh.points), [("number", "i4"), ("place", "f8", 3)])
        nodes["number"], nodes["place"][:, :2] = numbered(len(mesh.points)), mesh.points
        file.write(nodes.tobytes() + b"\n$EndNodes\n")
        blocks, number = _blocks(mesh), 0
        file.write(b"$Elements\n%d\n" % sum(len(block.cells) for block in blocks))
        for block in blocks:
            count = len(block.cells)
            tags = [*block.tags, *(() if block.parts is None else (np.ones(count, np.int64), block.parts))]
            rows = np.column_stack([number + numbered(count), *tags, block.cells + 1])
            file.write(np.array([KINDS[block.kind], count, len(tags)], np.int32).tobytes())
            file.write(rows.astype(np.int32).tobytes())
            number += count
        file.write(b"\n$EndElements\n")
        file.write("".join(periodic_text(periodic_entities(mesh), number="{:.16e}".format)).encode())


def as_meshio(mesh: Mesh) -> Any:
    """Return a `meshio.Mesh` of points, edges and cells, with Gmsh's ids and names, and its periodic sides."""
    import meshio

    blocks = _blocks(mesh)
    groups, entities = ([block.tags[k].astype(np.int32) for block in blocks] for k in range(2))
    return meshio.Mesh(
        mesh.points,
        [(block.kind, block.cells) for block in blocks],
        cell_data={"gmsh:physical": groups, "gmsh:geometrical": entities},
        field_data={name: np.array(group) for name, group in _groups(mesh).items()},
        gmsh_periodic=periodic_entities(mesh) or None,
    )


def write_msh_ascii(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write the file of `write_msh` as text; cells also have the tags of the parts in which they are ghosts."""
    text = _plane_text(mesh, _blocks(mesh, halo=True), list(_groups(mesh).items()))
    write_text(path, chain(text, periodic_text(periodic_entities(mesh))))


def write_words(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write the file of `write_msh_ascii`, with words as names, as Netgen cuts these at spaces; no matching nodes."""
    words = plain_words(mesh)
    groups = [(words[name], group) for name, group in group_names(mesh).items()]
    write_text(path, _plane_text(mesh, _blocks(replace(mesh, partition=None, periodic=mesh.periodic[:0])), groups))


def write_boundary(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write triangles and boundary edges only: deal.II refuses inner edges, and does not use points."""
    ids, entities = facet_ids(mesh)[mesh.outer], facet_numbers(mesh)[mesh.outer]
    blocks = [
        GroupedCells("line", mesh.facets[mesh.outer], ids, entities=entities),
        GroupedCells("triangle", mesh.triangles, region_ids(mesh), entities=region_numbers(mesh)),
    ]
    present = {Group(number, k) for k, block in enumerate(blocks, start=1) for number in np.unique(block.ids).tolist()}
    groups = [(name, group) for name, group in group_names(mesh).items() if group in present]
    write_text(path, _plane_text(mesh, blocks, groups))


def _plane_text(mesh: Mesh, blocks: Sequence[GroupedCells], groups: Sequence[tuple[str, Group]]) -> Iterator[str]:
    return msh_text(np.pad(mesh.points, ((0, 0), (0, 1))), blocks, groups)


def msh_text(points: Floats, blocks: Sequence[GroupedCells], groups: Sequence[tuple[str, Group]]) -> Iterator[str]:
    """Text of a file with points (n, 3), blocks of cells and named groups."""
    yield "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
    yield from names_text(groups)
    yield f"$Nodes\n{len(points)}\n"
    yield from lines("%d %r %r %r", numbered(len(points)), points)
    yield f"$EndNodes\n$Elements\n{sum(len(block.cells) for block in blocks)}\n"
    number = 0
    for block in blocks:
        count, width = block.cells.shape
        nodes, numbers = " %d" * width, number + numbered(count)
        if block.parts is None:
            yield from lines(f"%d {KINDS[block.kind]} 2 %d %d{nodes}", numbers, *block.tags, block.cells + 1)
        else:
            tags = _tags(*block.tags, block.parts, block.holders)
            yield from lines(f"%d {KINDS[block.kind]} %s{nodes}", numbers, tags, block.cells + 1)
        number += count
    yield "$EndElements\n"


def periodic_entities(mesh: Mesh) -> list[Matching]:
    """The periodic sides in Gmsh's form: entities of edges, each with its original."""
    found = []
    for sides in mesh.periodic_sides:
        affine = np.eye(4)
        affine[:2, [0, 1, 3]] = sides.motion
        found.append((1, (sides.second + 1, sides.first + 1), affine.ravel(), sides.nodes[:, ::-1]))
    return found


def periodic_text(
    matches: Sequence[Matching], head: str = "Affine", number: Callable[[float], str] = repr
) -> Iterator[str]:
    """Section of the entities that are copies, with nodes from 0; empty if there are none.

    The maps begin with ``head``, the word of version 2.2 or the count of numbers in 4.1; ``number`` formats numbers.
    """
    if not matches:
        return
    yield f"$Periodic\n{len(matches)}\n"
    for dimension, (copy, original), affine, nodes in matches:
        yield f"{dimension} {copy} {original}\n{head} {' '.join(map(number, affine.tolist()))}\n{len(nodes)}\n"
        yield from lines("%d %d", nodes + 1)
    yield "$EndPeriodic\n"


def _blocks(mesh: Mesh, *, halo: bool = False) -> list[GroupedCells]:
    """Labelled points, facets and cells; with ``halo``, cells also have the parts in which they are ghosts."""
    facets, triangles, holders = None, None, NO_HOLDERS
    if mesh.partition is not None:
        facets, triangles = cell_parts(mesh, mesh.partition)
        holders = ghost_holders(mesh.partition, mesh.cell_numbers) if halo else NO_HOLDERS
    kind = FACET_KINDS[mesh.facets.shape[1]]
    blocks = [GroupedCells(kind, mesh.facets, facet_ids(mesh), facets, entities=facet_numbers(mesh))]
    before = 0
    for cells in mesh.cells:
        count, width = cells.nodes.shape
        mine = {cell - before: others for cell, others in holders.items() if before <= cell < before + count}
        parts = None if triangles is None else triangles[cells.triangles[:, 0]]
        entities = region_numbers(mesh)[cells.triangles[:, 0]]
        blocks.append(GroupedCells(CELL_KINDS[width], cells.nodes, cell_ids(mesh, cells), parts, mine, entities))
        before += count
    ids, ends = node_ids(mesh), ends_of_periodic_sides(mesh)
    nodes = np.append(mesh.labelled_nodes, ends)
    if len(nodes):
        groups = np.append(ids, np.full(len(ends), _id_of_ends(mesh)))
        entities = np.append(node_numbers(mesh), len(group_names(mesh)) + numbered(len(ends)))
        parts = None if mesh.partition is None else mesh.partition.node_owner[nodes] + 1
        blocks.insert(0, GroupedCells("vertex", nodes[:, None], groups, parts, entities=entities))
    return blocks


def _groups(mesh: Mesh) -> dict[str, Group]:
    """Groups by their names, with one for ends of periodic sides: readers need a named group for all cells."""
    found = dict(group_names(mesh))
    if len(ends_of_periodic_sides(mesh)):
        name = ENDS
        while name in found:
            name += "-"
        found[name] = Group(_id_of_ends(mesh), 0)
    return found


def _id_of_ends(mesh: Mesh) -> int:
    return free_id(mesh)


def ends_of_periodic_sides(mesh: Mesh) -> Integers:
    """Nodes (k,) without a label of their own where a periodic side meets another one.

    For Gmsh each of them has to be a point: it moves nodes of copies to the places of the originals, and a node can
    have one curve only.
    """
    if len(mesh.periodic) == 0:
        return np.zeros(0, np.int64)
    rows, _ = different_rows(np.column_stack([mesh.facets[:, :2].ravel(), np.repeat(mesh.facet_labels, 2)]))
    several = np.bincount(rows[:, 0], minlength=len(mesh.points)) > 1
    several[mesh.labelled_nodes] = False
    periodic = np.zeros(len(mesh.points), bool)
    periodic[mesh.facets[mesh.periodic.ravel(), :2]] = True
    return np.flatnonzero(several & periodic)


def cell_parts(mesh: Mesh, partition: Partition) -> tuple[Integers, Integers]:
    """Parts (f,) and (t,) of facets and triangles, from 1 as Gmsh counts.

    A facet has the part of the triangle on its left.
    """
    left = mesh.sides[:, 0]
    facets = np.where(left < 0, partition.node_owner[mesh.facets[:, 0]], partition.owner[left])
    return facets + 1, partition.owner + 1


def ghost_holders(partition: Partition, numbers: Integers) -> Holders:
    """For each cell that is a ghost, the parts, from 1, in which it is one; in ascending order.

    The ``numbers`` (t,) are the cells of the triangles: a cell is a ghost if one of its triangles is.
    """
    part, triangle = partition.ghosts.T
    ghosts = np.column_stack([numbers[triangle], part])
    holders: dict[int, list[int]] = {}
    for cell, part in np.unique(ghosts, axis=0).tolist():
        holders.setdefault(cell, []).append(part + 1)
    return holders


def names_text(groups: Sequence[tuple[str, Group]]) -> Iterator[str]:
    """Section of the groups by their names, the same in all versions of the format."""
    yield f"$PhysicalNames\n{len(groups)}\n"
    yield from (f'{group.dimension} {group.id} "{name}"\n' for name, group in groups)
    yield "$EndPhysicalNames\n"


def _tags(groups: Integers, entities: Integers, parts: Integers, holders: Holders) -> NDArray[np.object_]:
    """Number and tags (m,) of cells: group, entity, number of parts, part, and those of the ghosts as negative ones."""
    tags = np.empty(len(groups), object)
    rows = zip(groups.tolist(), entities.tolist(), parts.tolist(), strict=True)
    tags[:] = [f"4 {group} {entity} 1 {part}" for group, entity, part in rows]
    for cell, others in holders.items():
        ghosts = " ".join(f"-{part}" for part in others)
        tags[cell] = f"{4 + len(others)} {groups[cell]} {entities[cell]} {1 + len(others)} {parts[cell]} {ghosts}"
    return tags
