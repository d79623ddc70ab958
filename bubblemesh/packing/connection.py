"""Bubbles connected by a constrained Delaunay triangulation."""

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.triangulation import triangulated

__all__ = ["connected", "enclosed"]

NEAREST_TO_CHORD = 0.2  # in units of spacing: a node nearer to a boundary edge would make a flat triangle


def connected(bubbles: Bubbles, domain: Domain) -> tuple[Integers, Integers, Integers]:
    """Boundary edges (e, 2), the piece (e,) of each, and triangles (t, 3) over the bubbles' centres."""
    edges, edge_piece = domain.boundary.edges(bubbles.piece, bubbles.s)
    return edges, edge_piece, triangulated(bubbles.x, edges)


def enclosed(bubbles: Bubbles, domain: Domain) -> Bubbles:
    """The bubbles without interior ones that the straight boundary edges leave outside, or hardly inside."""
    inside = _inside_chords(bubbles, domain)
    if inside.all():
        return bubbles
    keep = np.concatenate([np.arange(bubbles.boundary_count), bubbles.boundary_count + np.flatnonzero(inside)])
    return bubbles.kept(keep)


def _inside_chords(bubbles: Bubbles, domain: Domain) -> Booleans:
    """Interior bubbles (k,) that are inside the polygon of the boundary nodes."""
    edges, _ = domain.boundary.edges(bubbles.piece, bubbles.s)
    x, d = bubbles.x[bubbles.interior], bubbles.d[bubbles.interior]
    chords, centres = shapely.linestrings(bubbles.x[edges]), shapely.points(x)
    _, near = shapely.STRtree(chords).query_nearest(centres, all_matches=False)
    distance = shapely.distance(centres, chords[near])
    return _left_of(x, bubbles.x[edges[near]]) & (distance > NEAREST_TO_CHORD * d)


def _left_of(x: Floats, chord: Floats) -> Booleans:
    """Which points (k, 2) lie on the left of their segments (k, 2, 2)."""
    (ax, ay), (bx, by) = (x - chord[:, 0]).T, (chord[:, 1] - chord[:, 0]).T
    return bx * ay - by * ax > 0
