"""Areas enclosed by closed curves that may cross themselves and each other, by winding numbers."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Literal

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.arrangement import TOUCHING
from bubblemesh.geometry.arrangement.bellies import bellies
from bubblemesh.geometry.arrangement.noding import noded
from bubblemesh.geometry.arrangement.overlay import areas_beside, size_of
from bubblemesh.geometry.arrangement.pieces import probes, without_doubles
from bubblemesh.geometry.arrangement.regions import InnerParts
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.paths import Area, OpenPath, Ring, outlines

BATCH = 500  # places in a block, to bound the memory

# For winding numbers (m,) around places, the mask (m,) of the enclosed places.
FillRule = Literal["nonzero", "evenodd"]
FILL_RULES: Mapping[FillRule, Callable[[Integers], Booleans]] = {
    "nonzero": lambda turns: turns != 0,
    "evenodd": lambda turns: turns % 2 == 1,
}


def enclosed_areas(rule: FillRule, rings: Sequence[Ring]) -> list[Area]:
    """Areas that rings enclose by a rule, with the rings' curves cut where they cross.

    GeometryError, with the place, if curves are next to each other, but not the same.
    """
    paths = tuple(OpenPath.around(ring, "") for ring in rings)
    before = Boundary.empty().with_inner(paths)
    size = size_of(np.vstack(outlines(rings)))
    split = noded(before, size, 0, InnerParts(lines=paths))
    single = without_doubles(split, TOUCHING * size)
    left, right = (FILL_RULES[rule](_turns(split, points)) for points in probes(single))
    return areas_beside(rings, before, single, left, right)


def _turns(boundary: Boundary, points: Floats) -> Integers:
    """Winding numbers (n,) of the pieces of a boundary around points (n, 2)."""
    chords = boundary.chords()
    found = winding_numbers(np.stack([chords.start, chords.end], axis=1), points)
    between = bellies(boundary, points)
    np.add.at(found, between.point, between.turn)
    return found


def winding_numbers(chords: Floats, points: Floats) -> Integers:
    """Winding numbers (n,): turns to the left of closed walks along chords (m, 2, 2) around points (n, 2)."""
    found = np.zeros(len(points), np.int64)
    for point, _, turn in crossed(chords, points):
        np.add.at(found, point, turn)
    return found


def crossed(chords: Floats, points: Floats) -> Iterator[tuple[Integers, Integers, Integers]]:
    """Points, chords (m, 2, 2) that the rays from points (n, 2) to the right cross, +1 where upward, else -1.

    They come in blocks of some points each.
    """
    low, high = np.sort(chords[:, :, 1], axis=1).T
    far = chords[:, :, 0].max(axis=1)
    boxes = shapely.STRtree(shapely.box(chords[:, :, 0].min(axis=1), low, far, high))
    for first in range(0, len(points), BATCH):
        x, y = points[first : first + BATCH].T
        rays = shapely.linestrings(np.stack([x, np.maximum(far.max(), x)], 1), np.stack([y, y], 1))
        i, k = boxes.query(rays)
        (ax, ay), (bx, by) = chords[k, 0].T, chords[k, 1].T
        side = (bx - ax) * (y[i] - ay) - (by - ay) * (x[i] - ax)
        upward, downward = (ay <= y[i]) & (by > y[i]) & (side > 0), (ay > y[i]) & (by <= y[i]) & (side < 0)
        met = upward | downward
        yield first + i[met], k[met], np.where(upward[met], 1, -1)
