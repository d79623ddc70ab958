"""What is small on a wall that is about straight: edges that layers become higher than, steps below the first one."""

from collections.abc import Sequence

import numpy as np

from bubblemesh.arrays import Floats, turned_left
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.curves import turning
from bubblemesh.layers.directions import HIGHEST_STRETCH
from bubblemesh.layers.ladder import Ladder
from bubblemesh.layers.walls import Walls, rotated

LEAST_TURN = np.radians(10)  # of a wall, from which on it has a bend
LEAST_SLOPE = 1e-6  # of edges across a wall: on flatter ones no way along the wall leads to above them
CLEAR_OF_STEP = (
    0.5  # of a layer: least height of its top above a step's edges, or triangles on those that face aside are flat
)


def plain_edges(boundary: Boundary, ladders: Sequence[Ladder]) -> Floats:
    """Lengths (p,) of pieces of a boundary that are below layers of that height on a straight wall; 0 for all others.

    They are straight, the pieces on both sides of them are longer and have the same layers, and go on from there as
    they do.
    """
    length, found = boundary.lengths, np.zeros(len(boundary.lengths))
    ends = np.concatenate([boundary.start, boundary.end])
    open_ones = np.flatnonzero(~boundary.closed)
    pieces_at = np.bincount(ends[ends >= 0], minlength=len(boundary.corners))
    into, out_of = (np.full(len(boundary.corners), -1) for _ in range(2))
    into[boundary.end[open_ones]], out_of[boundary.start[open_ones]] = open_ones, open_ones
    mine = open_ones[~boundary.approximated[open_ones]]
    begin, end = boundary.start[mine], boundary.end[mine]
    between = (pieces_at[begin] == 2) & (pieces_at[end] == 2) & (into[begin] >= 0) & (out_of[end] >= 0)
    mine, before, after = mine[between], into[begin[between]], out_of[end[between]]
    start, stop = np.zeros(len(mine)), length[mine]
    ways = (
        boundary.tangents(before, length[before]),
        boundary.tangents(mine, start),
        boundary.tangents(after, start),
    )
    turns = np.abs([turning(ways[0], ways[1]), turning(ways[1], ways[2]), turning(ways[0], ways[2])])
    plain = (turns < LEAST_TURN).all(axis=0) & (stop < np.minimum(length[before], length[after]))
    for ladder in ladders:
        labels = [boundary.labels.index(label) for label in ladder.labels]
        alike = np.isin(boundary.label, labels)
        here = plain & alike[mine] & alike[before] & alike[after] & (stop <= ladder.heights.max())
        found[mine[here]] = stop[here]
    return found


def small_steps(walls: Walls, ladders: Sequence[Ladder]) -> set[int]:
    """Sides that end at nodes of steps lower than the first layer, and have no fan there: they have one column.

    Such a step is one of sides that are shorter in all than the first layer is high, beside which the wall goes on in
    about the same direction.
    """
    first = np.array([ladder.first for ladder in ladders])[walls.ladder]
    length = np.hypot(*(walls.x[walls.ends[:, 1]] - walls.x[walls.ends[:, 0]]).T)
    short = walls.layered & (length < first)
    before, found = np.full(len(short), -1), set[int]()
    before[walls.following] = np.arange(len(short))
    for begin in np.flatnonzero(short & ~short[before]).tolist():
        chain = [begin]
        while short[after := int(walls.following[chain[-1]])] and length[chain].sum() < first[begin]:
            chain.append(after)
        sides = [int(before[begin]), *chain]
        if length[chain].sum() < first[begin] and _is_step(walls, [*sides, after], float(first[begin])):
            found |= {*sides}
    return found


def _is_step(walls: Walls, sides: list[int], first: float) -> bool:
    """Whether there is a place above a step, those of the sides but for the first and the last one."""
    before, *chain, after = sides
    turn = turn_between(walls, before, after)
    if len({*walls.ladder[sides].tolist()}) > 1 or abs(turn) >= LEAST_TURN:
        return False
    below = walls.x[walls.ends[chain]]
    top = (below[0, 0] + below[-1, 1]) / 2 + first * middle_way(walls, after, turn)
    return clear_of(below, top, walls.directions[after], first) is not None


def clear_of(below: Floats, top: Floats, along: Floats, height: float) -> Floats | None:
    """Place (2,) on top of a layer of some height that is above all edges ``below`` (k, 2, 2) it, or None.

    It is the nearest one to a ``top`` (2,), ``along`` (2,) the wall from there: edges of a step face its lower side.
    """
    left = turned_left(below[:, 1] - below[:, 0])
    left /= np.hypot(*left.T)[:, None]
    lacking, slope = CLEAR_OF_STEP * height - ((top - below[:, 0]) * left).sum(axis=1), left @ along
    with np.errstate(divide="ignore"):
        way = lacking / np.where(np.abs(slope) > LEAST_SLOPE, slope, 0.0)
    ahead, back = way[slope > LEAST_SLOPE].max(initial=-height), way[slope < -LEAST_SLOPE].min(initial=height)
    if ahead > back or (lacking[np.abs(slope) <= LEAST_SLOPE] > 0).any():
        return None
    return np.asarray(top + np.clip(0.0, ahead, back) * along)


def turn_between(walls: Walls, before: int, after: int) -> float:
    """Angle by which a wall turns to the left from one side to another."""
    first, last = walls.directions[before], walls.directions[after]
    return float(np.arctan2(first[0] * last[1] - first[1] * last[0], first @ last))


def middle_way(walls: Walls, after: int, turn: float) -> Floats:
    """Way up (2,) in the middle of a bend that turns by some angle, up to the side ``after`` it."""
    half = (np.pi - turn) / 2
    up = rotated(walls.directions[after][None], np.array([half]))[0]
    return np.asarray(up * min(1 / np.sin(half), HIGHEST_STRETCH))
