"""Curved cells of files, which may fold over because of nodes other than the corners."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, extent
from bubblemesh.errors import FileError
from bubblemesh.meshes.edge_nodes import folded_quads, folded_triangles
from bubblemesh.meshes.quality import TRIANGLES_AT_A_TIME, doubled_areas
from bubblemesh.meshfiles.sources.source import Block
from bubblemesh.messages import place

HIGHER = "has cells of higher order: their corners are read"


class _Kind(NamedTuple):
    """Cells of second order."""

    folded: Callable[[Floats, Floats], Booleans]  # whether counter-clockwise cells, by corners and other nodes, are
    corners: int
    backward: list[int]  # order of the nodes that reverses a cell


def _with_centre(corners: Floats, middles: Floats) -> Floats:
    """The nodes (q, 5, 2) of quadrilaterals other than their corners (q, 4, 2), from those on their sides (q, 4, 2)."""
    centre = middles.sum(axis=1) / 2 - corners.sum(axis=1) / 4
    return np.concatenate([middles, centre[:, None]], axis=1)


KINDS: Mapping[str, _Kind] = {
    "triangle6": _Kind(folded_triangles, 3, [0, 2, 1, 5, 4, 3]),
    "quad8": _Kind(lambda a, b: folded_quads(a, _with_centre(a, b)), 4, [0, 3, 2, 1, 7, 6, 5, 4]),
    "quad9": _Kind(folded_quads, 4, [0, 3, 2, 1, 7, 6, 5, 4, 8]),
}


def curved_notes(points: Floats, blocks: Sequence[Block]) -> tuple[str, ...]:
    """Notes on cells between points (n, 2 or 3) that may fold over because of nodes other than the corners.

    A cell counts if bounds on its map do not exclude folding. FileError if a node is missing.
    """
    if not blocks:
        return ()
    count, first = 0, None
    for block in blocks:
        if block.type not in KINDS:
            continue
        if block.data.min() < 0 or block.data.max() >= len(points):
            raise FileError("a curved cell has a node that is not there: the file is damaged")
        for begin in range(0, len(block.data), TRIANGLES_AT_A_TIME):
            cells = np.asarray(points, float)[block.data[begin : begin + TRIANGLES_AT_A_TIME].astype(np.int64), :2]
            folded = np.flatnonzero(_folded(KINDS[block.type], cells))
            count += len(folded)
            first = cells[folded[0]].mean(axis=0) if first is None and len(folded) else first
    if first is None:
        return (HIGHER,)
    what = "1 curved cell folds" if count == 1 else f"{count:,} curved cells fold"
    at = place(first, extent(points[:, :2]))
    return HIGHER, f"{what} over, or nearly so, the first at {at}: nodes on its sides are too far from their middles"


def _folded(kind: _Kind, cells: Floats) -> Booleans:
    """Mask (m,) of the cells (m, k, 2) of a kind, in either orientation, that may be folded."""
    ends = [cells[:, [0, k, k + 1]] for k in range(1, kind.corners - 1)]
    clockwise = np.sum([doubled_areas(corners) for corners in ends], axis=0) < 0
    ahead = np.where(clockwise[:, None, None], cells[:, kind.backward], cells)
    return kind.folded(ahead[:, : kind.corners], ahead[:, kind.corners :])
