"""Neighbours: polygons that share borders, and to which of them an area goes that is free."""

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers, different_rows
from bubblemesh.geometry.coverage import is_coverage
from bubblemesh.geometry.nesting import Shapes, holes_of, polygons_of

SURROUNDED = 1 - 1e-9  # share of the border of a piece that another one is all around


def common_holes(shapes: Shapes) -> Shapes:
    """Holes (h,) of all polygons (n,) together, with whatever lies within; if no borders are shared, those of each."""
    return holes_of(shapely.coverage_union_all(shapes) if is_coverage(shapes) else shapes)


def gaps_between(shapes: Shapes) -> Shapes:
    """Holes (g,) that two or more of polygons (n,) with exactly shared borders leave between them; else none."""
    if not is_coverage(shapes):
        return shapes[:0]
    holes = common_holes(shapes)
    pairs, _ = common_borders(np.concatenate([shapes, holes]))
    beside = pairs[pairs[:, 1] >= len(shapes)]  # the lower number first: holes have no common border
    several = np.bincount(np.unique(beside, axis=0)[:, 1], minlength=len(shapes) + len(holes))[len(shapes) :] > 1
    return holes[several]


def owners(pieces: Shapes, free: Booleans, surrounded: bool = False) -> Integers:
    """Number (n,) of the piece to which each piece (n,) goes: itself unless it is ``free``, -1 if it has no neighbour.

    A free piece goes to the neighbour with the longest common border, to the first of equal ones; if it must be
    ``surrounded``, only to one that is all around. If all neighbours are free it follows them. Borders are common where
    both have the same vertices.
    """
    owner = np.where(free, -1, np.arange(len(pieces)))
    pairs, lengths = common_borders(pieces)
    least = SURROUNDED * shapely.length(shapely.get_exterior_ring(pieces)) if surrounded else np.zeros(len(pieces))
    piece, other = np.concatenate([pairs, pairs[:, ::-1]]).T
    length = np.tile(lengths, 2)
    for _ in range(len(pieces)):
        beside = (owner[piece] < 0) & (owner[other] >= 0)
        if not beside.any():
            break
        choices, number = np.unique(np.column_stack([piece, owner[other]])[beside], axis=0, return_inverse=True)
        total = np.bincount(number.ravel(), length[beside])
        best = np.lexsort((choices[:, 1], -total, choices[:, 0]))
        first = best[np.flatnonzero(np.diff(choices[best, 0], prepend=-1))]
        first = first[total[first] >= least[choices[first, 0]]]
        if len(first) == 0:
            break
        owner[choices[first, 0]] = choices[first, 1]
    return owner


def common_borders(pieces: Shapes) -> tuple[Integers, Floats]:
    """Pairs (k, 2) of pieces with a common edge, one row for each edge, and the lengths (k,) of these."""
    rings, piece_of = shapely.get_rings(pieces, return_index=True)
    coordinates, ring_of = shapely.get_coordinates(rings, return_index=True)
    points, vertex = different_rows(coordinates)
    start = np.flatnonzero(np.diff(ring_of) == 0)
    ends = np.sort(np.column_stack([vertex.ravel()[start], vertex.ravel()[start + 1]]), axis=1)
    owner = piece_of[ring_of[start]]
    order = np.lexsort((owner, ends[:, 1], ends[:, 0]))
    ends, owner = ends[order], owner[order]
    same = np.flatnonzero((ends[1:] == ends[:-1]).all(axis=1) & (owner[1:] != owner[:-1]))
    long = np.hypot(*(points[ends[same, 0]] - points[ends[same, 1]]).T)
    return np.column_stack([owner[same], owner[same + 1]]), long


def merged(pieces: Shapes, owner: Integers) -> Shapes:
    """Pieces (n,) that own themselves, with those that they own (see `owners`); None in place of all others."""
    found = np.full(len(pieces), None, dtype=object)
    taken = np.bincount(owner[owner >= 0], minlength=len(pieces))
    for number in np.flatnonzero(taken).tolist():
        found[number] = pieces[number] if taken[number] == 1 else united(pieces[owner == number])
    return found


def united(shapes: Shapes) -> shapely.Geometry:
    """The union of polygons (n,), with just the vertices that these have if their borders are exactly shared."""
    whole = shapely.coverage_union_all(shapes) if is_coverage(shapes) else shapely.union_all(shapes)
    parts = polygons_of(whole)
    return parts[0] if len(parts) == 1 else shapely.MultiPolygon(parts)
