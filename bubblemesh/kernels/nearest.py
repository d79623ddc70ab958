"""The nearest chords of many points: the twin of the search in `geometry.distance.nearest_chord`."""

from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.kernels.library import call


class RunTree(NamedTuple):
    """Runs of chords as the leaves of a binary tree, in which each box encloses the boxes of its two branches.

    Box 1 is that of the root, boxes 2 k and 2 k + 1 are those of the branches of box k, and the second half of them
    belongs to the leaves. If there are fewer runs than leaves, the boxes left over are empty.
    """

    boxes: Floats  # (2 * leaves, 4): low x and y, high x and y
    points: Floats  # (r, 2, g + 1): x and y of runs of up to g chords, the last one repeated in shorter runs
    rectangles: Floats  # (r, 6): centre and axis of each run's rectangle, half its length and half its width
    first: Integers  # (r,): number of each run's first chord
    counts: Integers  # (r,): numbers of its chords

    @classmethod
    def of(cls, points: Floats, rectangles: Floats, first: Integers, counts: Integers, margin: float) -> "RunTree":
        """Tree of runs (r,), at least one, in an order in which neighbours are near to each other."""
        leaves = 1 << (len(points) - 1).bit_length()
        boxes = np.tile([np.inf, np.inf, -np.inf, -np.inf], (2 * leaves, 1))
        boxes[leaves : leaves + len(points), :2] = points.min(axis=1) - margin
        boxes[leaves : leaves + len(points), 2:] = points.max(axis=1) + margin
        while leaves > 1:
            pairs = boxes[leaves : 2 * leaves].reshape(-1, 2, 4)
            leaves //= 2
            boxes[leaves : 2 * leaves, :2] = pairs[..., :2].min(axis=1)
            boxes[leaves : 2 * leaves, 2:] = pairs[..., 2:].max(axis=1)
        flat = np.ascontiguousarray
        return cls(boxes, flat(points.transpose(0, 2, 1), float), flat(rectangles, float), flat(first), flat(counts))


def nearest_chords(tree: RunTree, points: Floats, slack: float) -> Integers:
    """Number (m,) of the chord nearest to each of ``points`` (m, 2); the first of equally near ones.

    The search skips boxes whose squared distance is more than ``slack`` times the least one until then.
    """
    found = np.empty(len(points), np.int64)
    call(
        "nearest_chords",
        n=len(points),
        places=np.ascontiguousarray(points, np.float64),
        count=len(tree.points),
        leaves=len(tree.boxes) // 2,
        length=tree.points.shape[2] - 1,
        boxes=tree.boxes,
        points=tree.points,
        rectangles=tree.rectangles,
        first=tree.first,
        counts=tree.counts,
        slack=slack,
        nearest=found,
    )
    return found
