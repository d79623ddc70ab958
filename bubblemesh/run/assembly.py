"""From connected bubbles to a mesh with the domain's labels and regions; a coarse one for a picture of the spacing."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import shapely

from bubblemesh.arrays import Floats, Integers, each_once
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.paths import Point
from bubblemesh.geometry.periodic import matching_edges
from bubblemesh.meshes.edges import edge_keys, find_sides
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.quality import TARGET_SPACING
from bubblemesh.meshes.slices import Slice, SlicedMesh
from bubblemesh.meshes.triangulation import regions, sorted_triangles
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.net import Net, connect_inside
from bubblemesh.packing.placement.diffusion import ErrorDiffusion
from bubblemesh.problem.problem import Problem
from bubblemesh.spacing.spacing import Spacing

if TYPE_CHECKING:
    from bubblemesh.layers.joining import JoinedLayers
    from bubblemesh.layers.strips import Strips
    from bubblemesh.parts.pipeline import Parted

FINEST, COARSEST = 1 / 160, 1 / 60  # of the domain's size: triangles that pictures show
ENOUGH = 1_000_000  # nodes


def mesh_of(net: Net, domain: Domain) -> Mesh:
    """The mesh of connected bubbles, with the domain's labels and regions."""
    frame, piece = _frame(net.bubbles, domain)
    triangles = sorted_triangles(net.triangles)
    region = np.zeros(len(triangles), np.int64)
    if domain.parts.regions:
        region = regions(triangles, frame.facets, *_regions_beside(domain.boundary, piece))
    numbers, region = np.unique(domain.parts.name_indices[region], return_inverse=True)
    names = tuple(domain.parts.names[k] for k in numbers)
    return replace(frame, triangles=triangles, regions=names, triangle_regions=region)


def layered_mesh(joined: "JoinedLayers", domain: Domain, strips: "Strips") -> tuple[Mesh, Floats]:
    """The mesh of a packing and of layers that are joined to it, and the layer (t,) that each triangle is in.

    Layers are numbered from the wall on; triangles in none have 0.
    """
    mesh, n = mesh_of(joined.net, domain), len(joined.net.bubbles)
    # A side of each triangle tells where it is among the sorted ones.
    row = find_sides(mesh.triangles, n, joined.cells[:, :2])[0]
    layer = np.zeros(len(mesh.triangles))
    layer[row] = _layers(joined, strips)
    edges, middles = strips.curved
    edges = joined.number[edges]
    # Cells that are divided have lost edges, and of quadrilaterals the edges tell where their middle is.
    there = (find_sides(mesh.triangles, n, np.concatenate([edges, edges[:, ::-1]]))[0] >= 0).reshape(2, -1).any(axis=0)
    diagonals = joined.cells[joined.halves[:, 0]][:, [0, 2]]
    keys, others = (edge_keys(np.sort(pairs, axis=1), n) for pairs in (edges, diagonals))
    curved = there & ~np.isin(keys, others)
    whole = replace(mesh, quads=row[joined.halves], curved_edges=edges[curved], curved_middles=middles[curved])
    return whole, layer


def _layers(joined: "JoinedLayers", strips: "Strips") -> Integers:
    """Number (k,) of the layer that each triangle of the layers is in, from the wall on."""
    here = joined.number >= 0
    level = np.full(len(joined.net.bubbles), np.iinfo(np.int64).max - 1)  # of nodes that were put on fronts, too
    level[joined.number[here]] = strips.levels[here]
    return level[joined.cells].min(axis=1) + 1


def sliced_mesh(parted: "Parted", domain: Domain, fields: Mapping[str, Floats]) -> tuple[SlicedMesh, Integers]:
    """The mesh of what was packed in parts: a slice for each, of its core, and of the seams' triangles in its area.

    The fields (t,) are those of the triangles in the seams; the regions (t,) that are returned, by their numbers in
    the domain, are theirs, too.
    """
    net, parts = parted.net, domain.parts
    frame, piece = _frame(net.bubbles, domain)
    walls = np.concatenate([frame.facets, parted.rim])
    sides = (np.append(side, parted.rim_region) for side in _regions_beside(domain.boundary, piece))
    region = regions(net.triangles, walls, *sides)
    numbers = each_once(parts.name_indices[np.append(region, parted.regions)])
    index = np.searchsorted(numbers, parts.name_indices)
    counts = np.bincount(parted.cell, minlength=len(parted.sizes))
    blocks = np.split(np.argsort(parted.cell, kind="stable"), np.cumsum(counts)[:-1])

    def read(part: int) -> Slice:
        core, mine = parted.core(part), blocks[part]
        cores = {"quality": core.quality, TARGET_SPACING: core.target}
        return Slice(
            core.x,
            np.concatenate([net.triangles[mine], core.triangles]),
            index[np.concatenate([region[mine], core.region])],
            {name: np.concatenate([values[mine], cores[name]]) for name, values in fields.items()},
        )

    named = replace(frame, regions=tuple(parts.names[k] for k in numbers))
    sizes = parted.sizes + np.column_stack([np.zeros_like(counts), counts])
    return SlicedMesh(named, ~net.two_sided, sizes, tuple(fields), read), region


def _frame(bubbles: Bubbles, domain: Domain) -> tuple[Mesh, Integers]:
    """A mesh of bubbles without triangles, with the domain's labels; and the boundary piece (f,) of each facet.

    An inner facet has on its left what it belongs to, whichever way its piece runs.
    """
    boundary, parts = domain.boundary, domain.parts
    facets, piece = boundary.edges(bubbles.piece, bubbles.s)
    begin, end = boundary.arcs(facets, piece, bubbles.s)
    facing = np.where(boundary.turned[piece, None], facets[:, ::-1], facets)
    labels, label = np.unique(boundary.label[piece], return_inverse=True)
    numbers = {label: k for k, label in enumerate(dict.fromkeys(point.label for point in parts.points))}
    frame = Mesh(
        bubbles.x,
        np.zeros((0, 3), np.int64),
        facing,
        label,
        tuple(boundary.labels[k] for k in labels),
        labelled_nodes=_nearest(bubbles.x[: bubbles.corners], [point.at for point in parts.points]),
        node_labels=np.array([numbers[point.label] for point in parts.points], np.int64),
        point_labels=tuple(numbers),
        facet_middles=boundary.points(piece, boundary.wrapped(piece, (begin + end) / 2)),
        periodic=matching_edges(domain.periodic, piece),
    )
    return frame, piece


def _regions_beside(boundary: Boundary, piece: Integers) -> tuple[Integers, Integers]:
    """Numbers (f,) of the regions on the left and on the right of facets, which lie on the pieces (f,)."""
    left, right, turned = boundary.left[piece], boundary.right[piece], boundary.turned[piece]
    return np.where(turned, right, left), np.where(turned, left, right)


def _nearest(corners: Floats, places: Sequence[Point]) -> Integers:
    """Number (k,) of the corner, of some (n, 2), that is nearest to each of k places."""
    if not places:
        return np.zeros(0, np.int64)
    return np.asarray(shapely.STRtree(shapely.points(corners)).nearest(shapely.points(places)), np.int64)


def previewed(problem: Problem) -> tuple[Mesh, Floats]:
    """Mesh that is just fine enough for a picture, and the spacing (n,) that the packing goes by at its nodes."""
    domain, packing = problem.domain, problem.packing_spacing
    finest, coarsest = FINEST * domain.size, COARSEST * domain.size

    def shown(x: Floats, y: Floats) -> Floats:
        return np.clip(packing.extended(np.column_stack([x, y])), finest, coarsest)

    spacing = Spacing(shown, finest)
    mesh = mesh_of(connect_inside(ErrorDiffusion()(domain, spacing, ENOUGH), domain, spacing), domain)
    return mesh, packing(mesh.points)
