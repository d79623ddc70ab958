"""Noded pieces: which of them run along others, and places beside them."""

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers, turned_left
from bubblemesh.geometry.boundary import Boundary

ASIDE, ASIDE_OF_A_CURVE = 1e-6, 1e-5  # of a chord's length: distance from a piece at which its region is looked up


def without_doubles(boundary: Boundary, tolerance: float) -> Boundary:
    """The boundary without inner pieces that run along another piece or have no length."""
    keep, _ = doubles(boundary, tolerance)
    return boundary.select(np.flatnonzero(keep))


def doubles(boundary: Boundary, tolerance: float) -> tuple[Booleans, Integers]:
    """Mask (p,) of the pieces that stay, and pairs (k, 2) of an inner piece and another one that it runs along."""
    low, high = np.sort(np.column_stack([boundary.start, boundary.end]), axis=1).T
    numbers = np.arange(len(boundary.kind))
    middle = boundary.points(numbers, boundary.lengths / 2)
    keep = ~boundary.inner | (low != high) | (boundary.lengths > 10 * tolerance)
    rank = np.empty(len(numbers), np.int64)
    rank[np.lexsort((numbers, np.where(boundary.inner, -boundary.ring, 0)))] = numbers
    spots = shapely.points(middle)
    i, j = shapely.STRtree(spots).query(spots, predicate="dwithin", distance=10 * tolerance)
    double = (rank[j] < rank[i]) & (low[i] == low[j]) & (high[i] == high[j]) & boundary.inner[i]
    keep[i[double]] = False
    return keep, np.column_stack([i[double], j[double]])


def probes(boundary: Boundary) -> tuple[Floats, Floats]:
    """Points (p, 2) next to the middles of the pieces, on the left and on the right of them."""
    numbers = np.arange(len(boundary.kind))
    piece, s, step = boundary.stations()
    first = np.searchsorted(piece, numbers)
    chord = first + np.bincount(piece) // 2
    at = s[chord] + step[chord] / 2
    aside = np.where(boundary.curved, ASIDE_OF_A_CURVE, ASIDE) * step[chord]
    middle, normal = boundary.points(numbers, at), aside[:, None] * turned_left(boundary.tangents(numbers, at))
    return middle + normal, middle - normal
