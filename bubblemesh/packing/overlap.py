"""Overlap ratios: how crowded each bubble is, from the bubbles near it."""

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.adjacency import Neighbours
from bubblemesh.packing.bubbles import Bubbles

__all__ = ["REACH_OF_OVERLAP", "boundary_overlaps", "overlaps"]

REACH_OF_OVERLAP = 2.0  # 2 r_i + r_j is the farthest: below two l0 for any two radii


def overlaps(near: Neighbours) -> Floats:
    """Overlap ratios (n,): alpha_i = sum over neighbours of max(0, 2 r_i + r_j - l) / r_i; 6 in a perfect packing."""
    i, j = near.pairs.T
    r, distance = near.d / 2, near.distances
    on_i = np.maximum(0, 2 * r[i] + r[j] - distance) / r[i]
    on_j = np.maximum(0, 2 * r[j] + r[i] - distance) / r[j]
    return np.bincount(np.append(i, j), np.append(on_i, on_j), len(r)).astype(float)


def boundary_overlaps(bubbles: Bubbles, domain: Domain) -> Floats:
    """Overlap ratios (b,) of the sliding bubbles with the two bubbles on either side of them; 2 if all are in place."""
    edges, _ = domain.boundary.edges(bubbles.piece, bubbles.s)
    ahead, behind = (np.full(bubbles.boundary_count, -1) for _ in range(2))
    ahead[edges[:, 0]], behind[edges[:, 1]] = edges[:, 1], edges[:, 0]
    me = np.arange(bubbles.corners, bubbles.boundary_count)
    x, r = bubbles.x, bubbles.d / 2
    alpha = np.zeros(len(me))
    for step in (ahead, behind):
        first = step[me]
        second = np.where(first >= bubbles.corners, step[first], -1)  # not past a corner
        for other in (first, second):
            overlap = 2 * r[me] + r[other] - np.hypot(*(x[me] - x[other]).T)
            alpha += np.where((other >= 0) & (other != me), np.maximum(0, overlap) / r[me], 0)
    return alpha
