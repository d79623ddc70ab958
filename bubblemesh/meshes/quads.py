"""Quadrilaterals: pairs of triangles of a mesh that share an edge, their diagonal, and cells cut into such pairs."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, cross
from bubblemesh.errors import CaseError

FLAT = 1e-12  # of a quadrilateral's area: a half with less counts as flat
EQUAL = 1e-9  # difference of cosines below which angles count as equal


class Cells(NamedTuple):
    """Cells of one kind: their nodes (m, k), and the triangle (m, 1) or the two halves (m, 2) of each."""

    nodes: Integers
    triangles: Integers


def cells_of(triangles: Integers, quads: Integers) -> tuple[Cells, ...]:
    """Triangles (t, 3) or (t, 6) that are not halves, then quadrilaterals of the pairs (q, 2), without empty blocks."""
    if not len(quads):
        return (Cells(triangles, np.arange(len(triangles))[:, None]),)
    whole = np.ones(len(triangles), bool)
    whole[quads] = False
    rest = np.flatnonzero(whole)
    found = (Cells(triangles[rest], rest[:, None]), Cells(quadrilaterals(triangles, quads), quads))
    return tuple(cells for cells in found if len(cells.nodes))


def cell_numbers(cells: Sequence[Cells], count: int) -> Integers:
    """Number (t,) of the cell that each of so many triangles is, or is half of, among all cells in their order."""
    number, before = np.zeros(count, np.int64), 0
    for nodes, triangles in cells:
        number[triangles] = before + np.arange(len(nodes))[:, None]
        before += len(nodes)
    return number


def cell_sides(cells: Sequence[Cells], numbers: Integers, sides: Integers, facets: Integers) -> Integers:
    """Cell and number of its side, (f, 2), on whose left each facet lies.

    Parameters
    ----------
    cells
        Blocks of cells.
    numbers : (t,)
        Cell of each triangle, as in `cell_numbers`.
    sides : (f, 2)
        Triangle and side on whose left each facet lies, -1 for none.
    facets : (f, 2) or (f, 3)
        Node indices of the facets.
    """
    triangle, side = sides.T
    cell, side = np.where(triangle < 0, -1, numbers[triangle]), side.copy()
    for nodes, triangles in cells:
        if triangles.shape[1] == 2:
            before = numbers[triangles[0, 0]]
            here = np.flatnonzero((cell >= before) & (cell < before + len(nodes)))
            side[here] = np.argmax(nodes[cell[here] - before, :4] == facets[here, :1], axis=1)
    return np.column_stack([cell, side])


def quadrilaterals(triangles: Integers, quads: Integers) -> Integers:
    """Nodes (q, 4) of the quadrilaterals of pairs (q, 2) of triangles (t, 3), as the triangles turn.

    Of triangles (t, 6) they are (q, 9): after the corners the nodes on edges 0-1, 1-2, 2-3 and 3-0, and the middle one,
    which is that of the diagonal.
    """
    first, second = triangles[quads[:, 0]], triangles[quads[:, 1]]
    a, b = _from_apex(first, second), _from_apex(second, first)
    corners = [a[:, 0], a[:, 1], b[:, 0], b[:, 1]]
    if triangles.shape[1] == 3:
        return np.column_stack(corners)
    return np.column_stack([*corners, a[:, 3], b[:, 5], b[:, 3], a[:, 5], a[:, 4]])


def _from_apex(mine: Integers, other: Integers) -> Integers:
    """Triangles (q, 3) or (q, 6), turned to begin with the first corner that the other triangle (q, 3) lacks."""
    turn: Integers = (_apex(mine, other)[:, None] + np.arange(3)) % 3
    columns = np.hstack([turn, turn + 3])[:, : mine.shape[1]]
    return np.take_along_axis(mine, columns, axis=1)


def _apex(mine: Integers, other: Integers) -> Integers:
    """Number (q,) of the first corner of each triangle that the other one does not have."""
    shared = (mine[:, :3, None] == other[:, None, :3]).any(axis=2)
    return np.argmin(shared, axis=1)


def corner_angles(corners: Floats) -> Floats:
    """Angles (q, 4) in radians at the corners (q, 4, 2) of convex quadrilaterals that are counter-clockwise."""
    ahead, back = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    return np.asarray(np.arctan2(cross(ahead, back), (ahead * back).sum(axis=-1)))


def diagonals(triangles: Integers, quads: Integers) -> Integers:
    """Number (q, 2) of the side of each half that is the diagonal: side k goes from corner k to corner k + 1."""
    first, second = triangles[quads[:, 0]], triangles[quads[:, 1]]
    return (np.column_stack([_apex(first, second), _apex(second, first)]) + 1) % 3


def require_pairs(triangles: Integers, quads: Integers) -> None:
    """Check that the triangles of pairs (q, 2) share an edge and turn the same way, and are in one pair at most."""
    if quads.size == 0:
        return
    count = np.bincount(quads.ravel())
    if count.max() > 1:
        raise CaseError(f"quads: the triangle {count.argmax()} is in {count.max()} pairs: give it in one at most")
    first, second = triangles[quads[:, 0], :3], triangles[quads[:, 1], :3]
    a, b = _from_apex(first, second), _from_apex(second, first)
    apart = (a[:, 1:] != b[:, :0:-1]).any(axis=1) | (a[:, 0] == b[:, 0])
    if apart.any():
        i, j = quads[np.argmax(apart)].tolist()
        raise CaseError(f"quads: the triangles {i} and {j} share no edge, or turn different ways")


class Halves(NamedTuple):
    """Quadrilaterals cut into triangles."""

    triangles: Integers  # (t, 3), with the orientation of their quadrilaterals
    cells: Integers  # (t,) quadrilateral of each triangle, ascending
    quads: Integers  # (q, 2) pairs of triangles that are a convex quadrilateral
    dented: Integers  # quadrilaterals that are not convex
    crossed: Integers  # quadrilaterals that no diagonal halves, since they have no area or cross themselves


def halved(points: Floats, cells: Integers) -> Halves:
    """Quadrilaterals cut into triangles, from their nodes (m, 4) at points (n, 2) in either orientation.

    The cut follows the diagonal whose triangles have the smaller largest angle; if the quadrilateral is not convex, the
    diagonal inside. A quadrilateral with the same node twice in a row becomes one triangle.
    """
    triangles = np.stack([cells[:, [[0, 1, 2], [0, 2, 3]]], cells[:, [[1, 2, 3], [1, 3, 0]]]], axis=1)  # (m, 2, 2, 3)
    corners = points[triangles]
    area = _twice_area(corners)
    whole = area.sum(axis=2, keepdims=True)
    inside = (area * np.sign(whole) > FLAT * np.abs(whole)).all(axis=2)
    convex = inside.all(axis=1)
    # The larger the angle, the smaller its cosine.
    blunt = _least_cosine(corners).min(axis=2)
    choice = np.where(convex, blunt[:, 1] > blunt[:, 0] + EQUAL, ~inside[:, 0] & inside[:, 1]).astype(int)
    chosen = triangles[np.arange(len(cells)), choice]
    collapsed = cells == np.roll(cells, -1, axis=1)
    once = collapsed.sum(axis=1) == 1
    chosen[once, 0] = _without_second(cells[once], collapsed[once])
    kept = np.column_stack([np.ones(len(cells), bool), ~once])
    number = np.cumsum(kept.ravel()).reshape(-1, 2) - 1
    return Halves(
        chosen[kept],
        np.repeat(np.arange(len(cells)), kept.sum(axis=1)),
        number[convex & ~once],
        np.flatnonzero(~convex & inside.any(axis=1) & ~once),
        np.flatnonzero(~inside.any(axis=1) & ~once),
    )


def _twice_area(corners: Floats) -> Floats:
    """Twice the signed areas of triangles (..., 3, 2)."""
    u, v = corners[..., 1, :] - corners[..., 0, :], corners[..., 2, :] - corners[..., 0, :]
    return cross(u, v)


def _least_cosine(corners: Floats) -> Floats:
    """Cosine of the largest angle of triangles (..., 3, 2); not finite if a side has no length."""
    sides = np.roll(corners, -1, axis=-2) - corners
    length = np.hypot(sides[..., 0], sides[..., 1])
    with np.errstate(invalid="ignore", divide="ignore"):
        cosines = -(sides * np.roll(sides, 1, axis=-2)).sum(axis=-1) / (length * np.roll(length, 1, axis=-1))
    return np.asarray(cosines.min(axis=-1))


def _without_second(cells: Integers, same: Booleans) -> Integers:
    """Triangles (m, 3) of cells (m, 4), without the node that is the same as the next one."""
    return cells[~same].reshape(-1, 3)
