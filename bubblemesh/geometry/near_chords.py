"""Chords of pieces that are near each other: where to look for what curves have in common."""

from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.cuts import NEARLY

__all__ = ["NEWTON_STEPS", "PARALLEL", "Chords", "Pairs", "chords_of", "limited", "near_pairs"]

NEWTON_STEPS = 12
PARALLEL = 1e-6  # sine of the angle between two lines, below which they follow each other rather than cross
SAGITTA = 0.02  # of a chord's length, which its curve stays closer to


class Chords(NamedTuple):
    """Chords of a fine polygonal copy: piece (m,), arc length (m,) and its step (m,), and boxes around the curve."""

    piece: Integers
    s: Floats
    step: Floats
    boxes: shapely.STRtree


class Pairs(NamedTuple):
    """Chords near each other: their pieces p and q (m,), the arc lengths a and b of their middles, their steps."""

    p: Integers
    q: Integers
    a: Floats
    b: Floats
    step_a: Floats
    step_b: Floats

    def kept(self, which: Integers | Booleans) -> "Pairs":
        """Those of them."""
        return Pairs(*(column[which] for column in self))  # type: ignore[arg-type]


def chords_of(boundary: Boundary, size: float) -> Chords:
    """Chords of all pieces, with boxes that hold the curves and a margin within which others are near."""
    piece, s, step = boundary.panels()
    ends = np.stack([boundary.points(piece, s), boundary.points(piece, s + step)], axis=1)
    around = np.where(boundary.curved[piece], SAGITTA * step, 0) + NEARLY * size
    low, high = ends.min(axis=1) - around[:, None], ends.max(axis=1) + around[:, None]
    return Chords(piece, s, step, shapely.STRtree(shapely.box(*low.T, *high.T)))


def near_pairs(boundary: Boundary, chords: Chords) -> Pairs:
    """Chords of inner pieces beside those of others, or of the same piece, where they may cross or touch."""
    piece, s, step, boxes = chords
    mine = np.flatnonzero(boundary.inner[piece])
    i, j = boxes.query(boxes.geometries[mine], predicate="intersects")
    i = mine[i]
    i, j = (column[(i < j) | ~boundary.inner[piece[j]]] for column in (i, j))
    start, end, curved = boundary.start, boundary.end, boundary.curved
    p, q = piece[i], piece[j]
    joined = (start[p] == start[q]) | (start[p] == end[q]) | (end[p] == start[q]) | (end[p] == end[q])
    gap = np.abs(s[i] - s[j])  # neighbours on one curve are no crossing
    gap = np.where(boundary.closed[p] | (start[p] == end[p]), np.minimum(gap, boundary.lengths[p] - gap), gap)
    wanted = np.where(p == q, gap > 1.5 * step[i], curved[p] | curved[q] | ~joined)
    i, j = i[wanted], j[wanted]
    return Pairs(piece[i], piece[j], s[i] + step[i] / 2, s[j] + step[j] / 2, step[i], step[j])


def limited(ahead: Floats, step: Floats) -> Floats:
    """Steps (m,) of an iteration, not far beyond a chord."""
    return np.clip(ahead, -2 * step, 2 * step)
