"""Gmsh's mesh format 4.1 of a mesh in slices, which are the parts of its partition."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import chain
from pathlib import Path

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.partition import Partition
from bubblemesh.meshes.slices import Border, Slice, SlicedMesh, among
from bubblemesh.meshfiles.text import write_text
from bubblemesh.meshfiles.write.gmsh import periodic_entities, periodic_text
from bubblemesh.meshfiles.write.msh4 import (
    MAP,
    SURFACES,
    CellBlock,
    Entity,
    Place,
    by_places,
    cell_blocks,
    divided_layers,
    elements_text,
    entities_text,
    ghosts_text,
    nodes_text,
    whole_layers,
)

Surface = tuple[int, int]
"""A slice and a region that it has triangles in."""


def write_sliced_msh4(mesh: SlicedMesh, path: Path) -> None:
    """Write the file of `write_msh4` for a partition whose parts are the slices.

    Everything but inner nodes and triangles follows from the border, and from the box of each surface.
    """
    border = mesh.border()
    boxes, inner = _surveyed(mesh, border.crowded)
    small, partition = _with_boxes(border, boxes)
    whole = whole_layers(small)
    layers = divided_layers(small, partition, whole)
    surfaces, curves, _, points, _ = layers
    on_curves = [(place, k) for place, k in by_places(layers, len(small.points)) if place[0] != SURFACES]
    entities = {_surface_of(entity, whole[0].entities): entity for entity in surfaces.entities}
    before = len(points.cells) + len(curves.cells)

    def nodes() -> Iterator[tuple[Place, Integers, Floats]]:
        for place, k in on_curves:
            yield place, border.nodes[k], small.points[k]
        for (number, region), entity in entities.items():
            if (number, region) in inner:
                part = mesh.read(number)
                mine = _inner_nodes(part, region, border.crowded)
                yield (SURFACES, entity.tag), mine, mesh.points(mine, number, part)

    def cells() -> Iterator[CellBlock]:
        for block in cell_blocks([points, curves]):
            yield block._replace(cells=border.nodes[block.cells])
        for (number, region), entity in entities.items():
            part, first = mesh.read(number), before + mesh.first_triangles[number] + 1
            mine = np.flatnonzero(part.regions == region)
            yield CellBlock(entity, str(surfaces.kind), first + mine, part.triangles[mine])

    text = [
        entities_text(small, whole, layers, partition),
        nodes_text(len(on_curves) + len(inner), mesh.nodes, nodes()),
        elements_text(
            sum(len(layer.entities) for layer in (surfaces, curves, points)), before + mesh.triangles, cells()
        ),
        periodic_text(periodic_entities(mesh.frame), MAP),
        ghosts_text(border.partition, before + border.cells + 1),
    ]
    write_text(path, chain.from_iterable(text))


def _surveyed(mesh: SlicedMesh, crowded: Booleans) -> tuple[dict[Surface, Floats], set[Surface]]:
    """Boxes (2, 2) of all surfaces, and those surfaces that have nodes of their own."""
    boxes, inner = {}, set()
    for number, part in enumerate(mesh.slices()):
        for region in np.unique(part.regions).tolist():
            x = mesh.points(np.unique(part.triangles[part.regions == region]), number, part)
            boxes[number, region] = np.array([x.min(axis=0), x.max(axis=0)])
            if len(_inner_nodes(part, region, crowded)):
                inner.add((number, region))
    return boxes, inner


def _inner_nodes(part: Slice, region: int, crowded: Booleans) -> Integers:
    """Nodes (m,) of a slice's triangles in a region that are not crowded ones."""
    nodes = np.unique(part.triangles[part.regions == region])
    return nodes[~among(crowded, nodes)]


def _with_boxes(border: Border, boxes: dict[Surface, Floats]) -> tuple[Mesh, Partition]:
    """The mesh of a border, and a flat triangle across the box of each surface; with their partition."""
    mesh, partition = border.mesh, border.partition
    number, region = np.array(list(boxes)).T
    across = len(mesh.points) + 2 * np.arange(len(boxes))[:, None] + [0, 1, 0]
    triangles = np.concatenate([mesh.triangles, across])
    small = replace(
        mesh,
        points=np.concatenate([mesh.points, *boxes.values()]),
        triangles=triangles,
        triangle_regions=np.append(mesh.triangle_regions, region),
    )
    return small, replace(partition, triangles=triangles, owner=np.append(partition.owner, number))


def _surface_of(entity: Entity, regions: tuple[Entity, ...]) -> Surface:
    """The slice and the region of a part of an entity."""
    return entity.parts[0] - 1, entity.parent[1] - regions[0].tag
