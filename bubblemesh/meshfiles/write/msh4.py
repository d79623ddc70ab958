"""Gmsh's mesh format 4.1, as text: nodes and cells by entities, those of a partition with their parts, and ghosts."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.partition import Partition
from bubblemesh.meshfiles.groups import (
    CELL_KINDS,
    FACET_KINDS,
    Fields,
    facet_numbers,
    group_names,
    ids_of_groups,
    node_ids,
    region_numbers,
)
from bubblemesh.meshfiles.text import lines, numbered, write_text
from bubblemesh.meshfiles.write.gmsh import (
    KINDS,
    cell_parts,
    ends_of_periodic_sides,
    ghost_holders,
    names_text,
    periodic_entities,
    periodic_text,
)
from bubblemesh.records import record

POINTS, CURVES, SURFACES = range(3)  # dimensions
MAP = "16"  # head of the maps of periodic sides: so many numbers follow


@record
class Entity:
    """A point, curve or surface; if it has a parent, the piece of that in some parts of the mesh, numbered from 1."""

    dimension: int
    tag: int
    group: int | None
    parent: tuple[int, int] = (-1, -1)  # dimension and tag
    parts: tuple[int, ...] = ()


@record
class Layer:
    """Cells (m, k) of one kind, or nodes only if there is no kind; their entities, and the index (m,) of each."""

    kind: str | None
    cells: Integers
    entities: tuple[Entity, ...]
    index: Integers

    @property
    def places(self) -> Integers:
        """Dimension and tag (m, 2) of each cell's entity."""
        table = np.array([(entity.dimension, entity.tag) for entity in self.entities], np.int64)
        return table.reshape(-1, 2)[self.index]

    @property
    def next_tag(self) -> int:
        """The first number after those of all entities."""
        return max((entity.tag for entity in self.entities), default=0) + 1


Place = tuple[int, int]
"""Dimension and tag of an entity."""


class CellBlock(NamedTuple):
    """Cells (m, k) of an entity, by their nodes from 0, and their numbers (m,) in the file."""

    entity: Entity
    kind: str
    numbers: Integers
    cells: Integers


def write_msh4(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write points, edges and cells with their groups, the partition with its ghosts, and matching nodes.

    Nodes and cells have the same numbers as in Gmsh's other formats. Fields are not written.
    """
    whole = whole_layers(mesh)
    layers = whole if mesh.partition is None else divided_layers(mesh, mesh.partition, whole)
    surfaces, *others = layers
    cells = [*(layer for layer in others[::-1] if layer.kind is not None), *_by_kinds(mesh, surfaces)]
    places, count = by_places(layers, len(mesh.points)), sum(len(layer.cells) for layer in cells)
    text = [
        entities_text(mesh, whole, layers, mesh.partition),
        nodes_text(len(places), len(mesh.points), ((place, k, mesh.points[k]) for place, k in places)),
        elements_text(sum(len(layer.entities) for layer in cells), count, cell_blocks(cells)),
        periodic_text(periodic_entities(mesh), MAP),
    ]
    if mesh.partition is not None:
        before = len(mesh.labelled_nodes) + len(mesh.facets)
        text.append(ghosts_text(mesh.partition, before + 1 + mesh.cell_numbers))
    write_text(path, chain.from_iterable(text))


def _by_kinds(mesh: Mesh, surfaces: Layer) -> Iterator[Layer]:
    """The layer of a mesh's triangles as layers of cells, one for each kind, with the entities of these."""
    for nodes, triangles in mesh.cells:
        present, index = np.unique(surfaces.index[triangles[:, 0]], return_inverse=True)
        entities = tuple(surfaces.entities[k] for k in present.tolist())
        yield Layer(CELL_KINDS[nodes.shape[1]], nodes, entities, index.ravel())


def whole_layers(mesh: Mesh) -> list[Layer]:
    """Triangles, facets, labelled points and ends of periodic sides.

    The entities of the first two have the numbers of their groups.
    """
    found, ids = [], ids_of_groups(mesh).tolist()
    for dimension, kind, cells, number in (
        (SURFACES, CELL_KINDS[mesh.triangles.shape[1]], mesh.triangles, region_numbers(mesh)),
        (CURVES, FACET_KINDS[mesh.facets.shape[1]], mesh.facets, facet_numbers(mesh)),
    ):
        numbers, index = np.unique(number, return_inverse=True)
        found.append(Layer(kind, cells, tuple(Entity(dimension, k, ids[k - 1]) for k in numbers.tolist()), index))
    points = tuple(Entity(POINTS, k, number) for k, number in enumerate(node_ids(mesh).tolist(), start=1))
    labelled = Layer("vertex", mesh.labelled_nodes[:, None], points, np.arange(len(points)))
    nodes = ends_of_periodic_sides(mesh)  # nodes only: cells would need a group, as others have one
    ends = tuple(Entity(POINTS, labelled.next_tag + k, None) for k in range(len(nodes)))
    return [*found, labelled, Layer(None, nodes[:, None], ends, np.arange(len(ends)))]


def divided_layers(mesh: Mesh, partition: Partition, whole: Sequence[Layer]) -> list[Layer]:
    """Layers of a partition: an entity for each part of an entity, and curves for nodes that the same parts share.

    A node belongs to the last layer that has it: nodes that parts share are on their curve, labelled ones on a point.
    """
    surfaces, curves, *points = whole
    of_facets, of_triangles = cell_parts(mesh, partition)
    alone = np.concatenate([layer.cells[:, 0] for layer in points])
    divided = [_by_parts(surfaces, of_triangles), _by_parts(curves, of_facets)]
    _, part, _, starts = partition.node_parts
    several = np.flatnonzero(np.diff(starts) > 1)
    parts_of = {k: tuple((part[starts[k] : starts[k + 1]] + 1).tolist()) for k in {*several, *alone}}
    region = np.zeros(len(mesh.points), np.int64)
    region[mesh.triangles] = region_numbers(mesh)[:, None]
    sets = {parts_of[k]: k for k in several[::-1]}  # with the first node of each
    shared = tuple(
        Entity(CURVES, tag, None, (SURFACES, int(region[first])), parts)
        for tag, (parts, first) in enumerate(sorted(sets.items()), start=divided[1].next_tag)
    )
    number = {entity.parts: k for k, entity in enumerate(shared)}
    index = np.array([number[parts_of[k]] for k in several], np.int64)
    first = max(layer.next_tag for layer in points)
    return [
        *divided,
        Layer(None, several[:, None], shared, index),
        *(_owned(layer, first, parts_of) for layer in points),
    ]


def _owned(points: Layer, first: int, parts_of: Mapping[int, tuple[int, ...]]) -> Layer:
    """The layer of points with the parts of their nodes, in entities numbered after the ``first`` others."""
    entities = tuple(
        Entity(POINTS, first + entity.tag - 1, entity.group, (POINTS, entity.tag), parts_of[node])
        for entity, node in zip(points.entities, points.cells[:, 0].tolist(), strict=True)
    )
    return Layer(points.kind, points.cells, entities, points.index)


def _by_parts(layer: Layer, parts: Integers) -> Layer:
    """The layer with an entity for each part of its entities; ``parts`` (m,) are those of the cells."""
    rows, index = np.unique(np.column_stack([layer.index, parts]), axis=0, return_inverse=True)
    wholes = [layer.entities[which] for which, _ in rows.tolist()]
    entities = tuple(
        Entity(entity.dimension, tag, entity.group, (entity.dimension, entity.tag), (part,))
        for tag, (entity, part) in enumerate(zip(wholes, rows[:, 1].tolist(), strict=True), start=layer.next_tag)
    )
    return Layer(layer.kind, layer.cells, entities, index.ravel())


def entities_text(
    mesh: Mesh, whole: Sequence[Layer], layers: Sequence[Layer], partition: Partition | None
) -> Iterator[str]:
    """Sections before the nodes: groups, entities with groups, and the entities of a partition."""
    yield "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"
    yield from names_text(list(group_names(mesh).items()))
    yield "$Entities\n"
    yield from _rows(mesh.points, whole)
    yield "$EndEntities\n"
    if partition is not None:
        first = max(layer.next_tag for layer in layers)
        ghosts = "".join(f"{first + k} {k + 1}\n" for k in range(partition.count))
        yield f"$PartitionedEntities\n{partition.count}\n{partition.count}\n{ghosts}"
        yield from _rows(mesh.points, layers)
        yield "$EndPartitionedEntities\n"


def _rows(points: Floats, layers: Sequence[Layer]) -> Iterator[str]:
    """Numbers of points, curves, surfaces and volumes, and then all of these, each with its box."""
    rows: list[list[str]] = [[], [], [], []]
    for layer in layers:
        low, high = np.full((2, len(layer.entities), 2), [[[np.inf]], [[-np.inf]]])
        index = np.repeat(layer.index, layer.cells.shape[1])
        np.minimum.at(low, index, points[layer.cells.ravel()])
        np.maximum.at(high, index, points[layer.cells.ravel()])
        for entity, (x0, y0), (x1, y1) in zip(layer.entities, low.tolist(), high.tolist(), strict=True):
            row = f"{entity.tag} "
            if entity.parts:
                row += f"{entity.parent[0]} {entity.parent[1]} {len(entity.parts)} {' '.join(map(str, entity.parts))} "
            row += f"{x0!r} {y0!r} 0" if entity.dimension == POINTS else f"{x0!r} {y0!r} 0 {x1!r} {y1!r} 0"
            row += " 0" if entity.group is None else f" 1 {entity.group}"
            rows[entity.dimension].append(row + ("\n" if entity.dimension == POINTS else " 0\n"))
    yield " ".join(str(len(each)) for each in rows) + "\n"
    for each in rows:
        yield from each


def by_places(layers: Sequence[Layer], count: int) -> list[tuple[Place, Integers]]:
    """Nodes (m,), of ``count`` in all, by their entities, which are those of the last layer that has them."""
    places = np.zeros((count, 2), np.int64)
    for layer in layers:
        places[layer.cells] = layer.places[:, None]
    order = np.lexsort(places.T[::-1])
    blocks = np.split(order, np.flatnonzero(np.diff(places[order], axis=0).any(axis=1)) + 1)
    return [((int(places[nodes[0], 0]), int(places[nodes[0], 1])), nodes) for nodes in blocks]


def nodes_text(entities: int, count: int, blocks: Iterable[tuple[Place, Integers, Floats]]) -> Iterator[str]:
    """Section of the nodes, by blocks of their numbers (m,), from 0, and points (m, 2) on an entity."""
    yield f"$Nodes\n{entities} {count} 1 {count}\n"
    for (dimension, tag), nodes, points in blocks:
        yield f"{dimension} {tag} 0 {len(nodes)}\n"
        yield from lines("%d", nodes + 1)
        yield from lines("%r %r 0", points)
    yield "$EndNodes\n"


def cell_blocks(layers: Iterable[Layer]) -> Iterator[CellBlock]:
    """Cells of layers by their entities, numbered from 1 in the order of the layers."""
    before = 0
    for layer in layers:
        numbers = before + numbered(len(layer.cells))
        counts = np.bincount(layer.index, minlength=len(layer.entities))
        blocks = np.split(np.argsort(layer.index, kind="stable"), np.cumsum(counts)[:-1])
        for entity, mine in zip(layer.entities, blocks, strict=False):  # without entities there is a block all the same
            yield CellBlock(entity, str(layer.kind), numbers[mine], layer.cells[mine])
        before += len(layer.cells)


def elements_text(entities: int, count: int, blocks: Iterable[CellBlock]) -> Iterator[str]:
    """Section of the cells."""
    yield f"$Elements\n{entities} {count} 1 {count}\n"
    for entity, kind, numbers, cells in blocks:
        yield f"{entity.dimension} {entity.tag} {KINDS[kind]} {len(cells)}\n"
        yield from lines("%d" + " %d" * cells.shape[1], numbers, cells + 1)
    yield "$EndElements\n"


def ghosts_text(partition: Partition, numbers: Integers) -> Iterator[str]:
    """Section of the cells that are in halos; those of the triangles have numbers (t,) in the file."""
    holders, ghosts = ghost_holders(partition, numbers), partition.ghosts[:, 1]
    owner = dict(zip(numbers[ghosts].tolist(), partition.owner[ghosts].tolist(), strict=True))
    yield f"$GhostElements\n{len(holders)}\n"
    for number, parts in holders.items():
        told = " ".join(map(str, parts))
        yield f"{number} {owner[number] + 1} {len(parts)} {told}\n"
    yield "$EndGhostElements\n"
