"""Nearest chords of very many points: whole blocks of points rule out runs of chords together."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, concatenated, taken
from bubblemesh.geometry.distance.chord_runs import ChordRuns
from bubblemesh.kernels.hilbert import along_hilbert_curve
from bubblemesh.kernels.library import or_numpy
from bubblemesh.kernels.nearest import nearest_chords

BLOCK = 16  # points, or smaller blocks, of a block
PAIRS = 1 << 12  # of blocks and runs at a time, so that the arrays stay in the processor's caches
TOGETHER = 64  # points with one common lower bound
SLACK = 1 + 1e-12  # for rounding


class Tier(NamedTuple):
    """Places (n, 2), each with a reach (n,) within which its part of the points lies."""

    places: Floats
    reach: Floats


class Candidates(NamedTuple):
    """Blocks (p,), sorted, and runs (p,) that may hold what is nearest to something in them.

    ``foot`` (b, 2) is a place on a chord for each block, near to it.
    """

    foot: Floats
    owner: Integers
    run: Integers


class Blocks(NamedTuple):
    """Blocks of consecutive places, and the runs that may hold the nearest chord of anything within their reach.

    The arrays x, y, reach and limit are (g, b): a column for each block, where the last place fills the last block.
    ``limit`` is a squared distance from the chords that none of the places exceeds.
    """

    first: int
    x: Floats
    y: Floats
    reach: Floats
    limit: Floats
    real: Booleans
    owner: Integers
    run: Integers

    def spread(self, values: Floats) -> Floats:
        """Values (g, p) of the places in the block of each pair, of those (g, b) of all blocks."""
        return values[:, self.owner]


def nearest_in_numpy(runs: ChordRuns, points: Floats) -> Integers:
    """The same as `nearest_chord`, in NumPy."""
    found = np.zeros(len(points), np.int64)
    if len(points) == 0:
        return found
    order = along_hilbert_curve(points)
    tiers = _tiers(points[order], runs.margin)
    pairs = Candidates(runs.start[:1], np.zeros(len(runs.first), np.int64), np.arange(len(runs.first)))
    for tier in tiers[:0:-1]:
        parts = [_candidates(runs, blocks) for blocks in _blocks(tier, pairs)]
        pairs = concatenated(parts)
    chords = [_nearest(runs, blocks)[0].T[blocks.real.T] for blocks in _blocks(tiers[0], pairs)]
    found[order] = np.concatenate(chords)
    return found


@or_numpy(nearest_in_numpy)
def nearest_chord(runs: ChordRuns, points: Floats) -> Integers:
    """Number (m,) of the chord nearest to each of ``points`` (m, 2); the first of equally near ones.

    It does not depend on the other points: the search only leaves out chords that are farther away.
    """
    return nearest_chords(runs.tree, points, SLACK)


def distance_at_least(runs: ChordRuns, points: Floats, along_curve: bool = False) -> Floats:
    """Lower bounds (m,) of the distances of points (m, 2) from all chords, much quicker than the distances.

    They are close for points whose neighbours among the points are much nearer than the chords. Points ``along_curve``
    are already in an order in which neighbours follow each other; others are sorted so.
    """
    bounds = np.zeros(len(points))
    if len(points) == 0:
        return bounds
    order = np.arange(len(points)) if along_curve else along_hilbert_curve(points)
    begin = np.arange(0, len(points), TOGETHER)
    middle, away = _middles(points if along_curve else taken(points, order), begin)
    foot = runs.feet(middle, nearest_chord(runs, middle))[1]
    distance = np.hypot(*(middle - foot).T) / SLACK - 2 * runs.margin
    bounds[order] = np.maximum(np.repeat(distance, np.diff(begin, append=len(points))) - away, 0)
    return bounds


def _middles(places: Floats, begin: Integers) -> tuple[Floats, Floats]:
    """Middles (b, 2) of blocks of places (n, 2), and distances (n,) of the places from those."""
    size = np.diff(begin, append=len(places))
    middle = np.add.reduceat(places, begin) / size[:, None]
    return middle, np.hypot(*(places - np.repeat(middle, size, axis=0)).T)


def _tiers(points: Floats, margin: float) -> list[Tier]:
    """The points, the middles of blocks of them, and so on up to a single block."""
    tiers = [Tier(points, np.full(len(points), margin))]
    while len(tiers[-1].places) > BLOCK:
        places, reach = tiers[-1]
        begin = np.arange(0, len(places), BLOCK)
        middle, away = _middles(places, begin)
        tiers.append(Tier(middle, np.maximum.reduceat(away + reach, begin)))
    return tiers


def _blocks(tier: Tier, pairs: Candidates) -> Iterator[Blocks]:
    """The blocks of a tier, some at a time."""
    size = min(BLOCK, len(tier.places))
    count = -(-len(tier.places) // size)
    first = np.searchsorted(pairs.owner, np.arange(count + 1))
    cuts = np.flatnonzero(np.diff(first[:-1] // PAIRS, prepend=-1))
    for begin, end in zip(cuts.tolist(), [*cuts[1:].tolist(), count], strict=True):
        number = np.arange(begin * size, end * size).reshape(-1, size).T
        known = np.minimum(number, len(tier.places) - 1)
        x, y = np.moveaxis(tier.places[known], 2, 0)
        (foot_x, foot_y), mine = pairs.foot[begin:end].T, slice(first[begin], first[end])
        limit = (x - foot_x) ** 2 + (y - foot_y) ** 2
        yield Blocks(begin, x, y, tier.reach[known], limit, known == number, pairs.owner[mine] - begin, pairs.run[mine])


def _nearest(runs: ChordRuns, blocks: Blocks) -> tuple[Integers, Floats, Floats]:
    """Nearest chords (g, b) of the places, their squared distances, and those (g, p) of the places from the runs."""
    near = runs.at_least(blocks.spread(blocks.x), blocks.spread(blocks.y), blocks.run)
    begin = np.searchsorted(blocks.owner, np.arange(blocks.x.shape[1]))
    promising = near == blocks.spread(np.minimum.reduceat(near, begin, axis=1))
    _, squared, chord = _among(runs, blocks, promising)
    limit = np.minimum(squared.reshape(blocks.x.shape), blocks.limit)
    rest = (near <= blocks.spread(limit) * SLACK) & ~promising
    place, other, other_chord = _among(runs, blocks, rest)
    better = (other < squared[place]) | ((other == squared[place]) & (other_chord < chord[place]))
    squared[place[better]], chord[place[better]] = other[better], other_chord[better]
    return chord.reshape(blocks.x.shape), squared.reshape(blocks.x.shape), near


def _among(runs: ChordRuns, blocks: Blocks, chosen: Booleans) -> tuple[Integers, Floats, Integers]:
    """Places (k,) with any of the ``chosen`` runs (g, p), their squared distances and the nearest chords of these."""
    row, pair = np.nonzero(chosen)
    place = row * blocks.x.shape[1] + blocks.owner[pair]  # grouped, since a block's pairs follow each other
    squared, chord = runs.nearest(blocks.x.ravel()[place], blocks.y.ravel()[place], blocks.run[pair])
    begin = np.flatnonzero(np.diff(place, prepend=-1))
    if len(begin) == 0:
        return place, squared, chord
    least = np.minimum.reduceat(squared, begin)
    hit = np.flatnonzero(squared == np.repeat(least, np.diff(begin, append=len(place))))
    return place[begin], least, chord[hit[np.searchsorted(hit, begin)]]


def _candidates(runs: ChordRuns, blocks: Blocks) -> Candidates:
    """Blocks and runs that are left for the places as blocks of the next tier.

    With b the foot of a place c, and q a point of a run, the difference of the squared distances from q and from b is
    linear. So q is nowhere nearer within the reach if |c - q|^2 exceeds |c - b|^2 by more than twice that times
    |q - b|. Where the boundary is far away that rules out much more than the triangle inequality would.
    """
    chord, squared, near = _nearest(runs, blocks)
    foot = runs.feet(np.column_stack([blocks.x.ravel(), blocks.y.ravel()]), chord.ravel())[1].reshape(*chord.shape, 2)
    foot_x, foot_y = np.moveaxis(foot, 2, 0)
    away = 2 * (np.sqrt(squared) + blocks.reach)  # of b from anything that is nearer than b to a place within reach
    apart = np.minimum(runs.at_most(blocks.spread(foot_x), blocks.spread(foot_y), blocks.run), blocks.spread(away))
    kept = near <= (blocks.spread(squared) + 2 * blocks.spread(blocks.reach) * apart) * SLACK
    row, pair = np.nonzero(kept & blocks.real[:, blocks.owner])
    place = (blocks.first + blocks.owner[pair]) * len(blocks.x) + row
    order = np.argsort(place, kind="stable")
    return Candidates(np.moveaxis(foot, 1, 0)[blocks.real.T], place[order], blocks.run[pair[order]])
