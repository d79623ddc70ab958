"""Bubbles connected by a constrained Delaunay triangulation."""

from bubblemesh.arrays import Integers
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.triangulation import triangulated

__all__ = ["connected"]


def connected(bubbles: Bubbles, domain: Domain) -> tuple[Integers, Integers, Integers]:
    """Boundary edges (e, 2), the piece (e,) of each, and triangles (t, 3) over the bubbles' centres."""
    edges, edge_piece = domain.boundary.edges(bubbles.piece, bubbles.s)
    return edges, edge_piece, triangulated(bubbles.x, edges)
