"""From connected bubbles to a mesh with the domain's labels and regions; a coarse one for a picture of the spacing."""

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.periodic import matching_edges
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.triangulation import regions, sorted_triangles
from bubblemesh.packing.net import Net, connect_inside
from bubblemesh.packing.placement.diffusion import ErrorDiffusion
from bubblemesh.problem.problem import Problem
from bubblemesh.spacing.spacing import Spacing

FINEST, COARSEST = 1 / 160, 1 / 60  # of the domain's size: triangles that pictures show
ENOUGH = 1_000_000  # nodes


def mesh_of(net: Net, domain: Domain) -> Mesh:
    """The mesh of connected bubbles, with the domain's labels and regions."""
    boundary, bubbles, parts = domain.boundary, net.bubbles, domain.parts
    facets, piece = boundary.edges(bubbles.piece, bubbles.s)
    begin, end = boundary.arcs(facets, piece, bubbles.s)
    triangles = sorted_triangles(net.triangles)
    region = np.zeros(len(triangles), np.int64)
    if parts.regions:
        region = regions(triangles, facets, boundary.left[piece], boundary.right[piece])
    numbers, region = np.unique(parts.name_indices[region], return_inverse=True)
    labels, label = np.unique(boundary.label[piece], return_inverse=True)
    corners = bubbles.x[: bubbles.corners]
    nodes = [np.hypot(*(corners - point.at).T).argmin() for point in parts.points]
    point_labels = tuple(dict.fromkeys(point.label for point in parts.points))
    return Mesh(
        bubbles.x,
        triangles,
        facets,
        label,
        tuple(boundary.labels[k] for k in labels),
        regions=tuple(parts.names[k] for k in numbers),
        triangle_regions=region,
        labelled_nodes=np.array(nodes, np.int64),
        node_labels=np.array([point_labels.index(point.label) for point in parts.points], np.int64),
        point_labels=point_labels,
        facet_middles=boundary.points(piece, boundary.wrapped(piece, (begin + end) / 2)),
        periodic=matching_edges(domain.periodic, piece),
    )


def previewed(problem: Problem) -> tuple[Mesh, Floats]:
    """Mesh that is just fine enough for a picture, and the spacing (n,) that the packing goes by at its nodes."""
    domain, wanted = problem.domain, problem.packing_spacing
    finest, coarsest = FINEST * domain.size, COARSEST * domain.size

    def shown(x: Floats, y: Floats) -> Floats:
        return np.clip(wanted.extended(np.column_stack([x, y])), finest, coarsest)

    spacing = Spacing(shown, finest)
    mesh = mesh_of(connect_inside(ErrorDiffusion()(domain, spacing, ENOUGH), domain, spacing), domain)
    return mesh, wanted(mesh.points)
