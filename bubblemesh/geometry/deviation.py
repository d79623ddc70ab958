"""Distance of the mesh's boundary from the rings that were followed as curves."""

from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Floats, Integers
from bubblemesh.geometry.domain import Domain


class Deviation(NamedTuple):
    """Largest distance between a ring as given and the mesh's boundary, and the point (x, y) where it is."""

    largest: float
    at: tuple[float, float]


def deviation(domain: Domain, points: Floats, facets: Integers, facet_piece: Integers) -> Deviation | None:
    """Deviation of boundary edges from the polylines that they follow; None without any such ring.

    Parameters
    ----------
    domain : Domain
    points : (n, 2)
        Nodes.
    facets : (b, 2)
        Boundary edges.
    facet_piece : (b,)
        The boundary piece of each.
    """
    found = []
    for number, given in domain.given_outlines.items():
        edges = points[facets[domain.boundary.ring[facet_piece] == number]]
        # Distances from a chord to its polyline and back are largest at the vertices, at nodes and in between.
        found.append(_farthest(given, edges))
        found.append(_farthest(np.vstack([edges[:, 0], edges.mean(axis=1)]), _closed(given)))
    return max(found) if found else None


def _closed(points: Floats) -> Floats:
    return np.stack([points, np.roll(points, -1, axis=0)], axis=1)


def _farthest(points: Floats, lines: Floats) -> Deviation:
    """Largest distance of the points (m, 2) from the nearest of the lines (k, 2, 2)."""
    _, distance = shapely.STRtree(shapely.linestrings(lines)).query_nearest(
        shapely.points(points), all_matches=False, return_distance=True
    )
    x, y = points[distance.argmax()].tolist()
    return Deviation(float(distance.max()), (x, y))
