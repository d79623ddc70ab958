"""From connected bubbles to a mesh with the domain's labels and regions."""

import numpy as np

from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.periodic import matching_edges
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.triangulation import regions, sorted_triangles
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.net import Net


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
    vertices = [_node_at(point.at, bubbles) for point in parts.points]
    point_labels = tuple(dict.fromkeys(point.label for point in parts.points))
    return Mesh(
        bubbles.x,
        triangles,
        facets,
        label,
        tuple(boundary.labels[k] for k in labels),
        regions=tuple(parts.names[k] for k in numbers),
        triangle_regions=region,
        labelled_nodes=np.array(vertices, np.int64),
        node_labels=np.array([point_labels.index(point.label) for point in parts.points], np.int64),
        point_labels=point_labels,
        facet_middles=boundary.points(piece, boundary.wrapped(piece, (begin + end) / 2)),
        periodic=matching_edges(domain.periodic, piece),
    )


def _node_at(point: tuple[float, float], bubbles: Bubbles) -> int:
    """The corner that is an embedded point."""
    return int(np.hypot(*(bubbles.x[: bubbles.corners] - point).T).argmin())
