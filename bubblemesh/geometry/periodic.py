"""Periodic sides: pieces that are copies of others across the domain, shifted or turned about a point."""

from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, each_once
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.arrangement import TOUCHING
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.similarity import Similarity
from bubblemesh.messages import meant, two_places

SAMPLES = 9
NEARLY = 1e-4  # of the domain's size: sides that differ by less may be meant to match


class MatchingPieces(NamedTuple):
    """Pieces of a boundary that have counterparts, of which each is a copy of the other."""

    pairs: Integers  # (k, 2): a piece, and its copy
    turn: Floats  # (p,): by how many radians each piece of the boundary is turned to be its counterpart
    motions: tuple[Similarity, ...]  # what takes the first side of each pair of labels to the second


def matching_pieces(boundary: Boundary, labels: Sequence[tuple[str, str]], tolerance: float = 0.0) -> MatchingPieces:
    """Pieces of which the second of each pair is the first one, shifted or else turned about a point, and reversed.

    Reversed, so that a copy of the domain that is moved with it lies beside the domain, not on it. The pieces belong to
    sides whose labels match, in any order. GeometryError, with the coordinates, if there is no such label, or a piece
    has no counterpart. A ``tolerance`` by which sides were to be made alike is one that a message need not advise.
    """
    pairs, turn, motions = list[Integers](), np.zeros(len(boundary.kind)), list[Similarity]()
    used = Counter(name for names in labels for name in names)
    twice = next((name for name, times in used.items() if times > 1), None)
    if twice is not None:
        raise GeometryError(f"periodic: the side {twice!r} is named twice: each side has one counterpart")
    for names in labels:
        first, second = (pieces_of_side(boundary, name) for name in names)
        motion, copies = motion_of_sides(boundary, first, second, _tolerance(boundary))
        if (copies < 0).any():
            at = _unmatched(boundary, int(first[copies.argmin()]), second, motion)
            here, there = two_places(at, motion.point(at))
            raise GeometryError(
                f"periodic sides {names[0]!r} and {names[1]!r}: what is at {here} has no counterpart at "
                f"{there}: both sides need the same shape and the same vertices, moved or turned"
                f"{_advice(boundary, first, second, tolerance)}"
            )
        if len(first) != len(second):
            raise GeometryError(f"periodic sides {names[0]!r} and {names[1]!r} have different numbers of pieces")
        pairs.append(np.column_stack([first, copies]))
        turn[first], turn[second] = motion.angle, -motion.angle
        motions.append(motion)
    return MatchingPieces(np.concatenate([np.empty((0, 2), np.int64), *pairs]), turn, tuple(motions))


def counterparts(boundary: Boundary, pairs: Integers, piece: Integers, s: Floats) -> tuple[Integers, Integers, Floats]:
    """Counterparts of places at arc lengths s (m,) on pieces (m,), as far as these are on periodic sides.

    Returns
    -------
    tuple
        Numbers (k,) of the places on periodic sides, in the order of the pairs (p, 2) of `matching_pieces`; pieces (k,)
        and arc lengths (k,) of their counterparts.
    """
    here, there = np.stack([pairs, pairs[:, ::-1]], axis=1).reshape(-1, 2).T
    rank = np.full(len(boundary.kind), -1)
    rank[here] = np.arange(len(here))
    mine = np.flatnonzero(rank[piece] >= 0)
    mine = mine[np.argsort(rank[piece[mine]], kind="stable")]
    other = there[rank[piece[mine]]]
    return mine, other, boundary.wrapped(other, boundary.lengths[other] - s[mine])


def matching_edges(pairs: Integers, piece: Integers) -> Integers:
    """Pairs (m, 2) of edges on the pieces of `matching_pieces`, in opposite directions.

    Each edge follows a ``piece`` (e,); those of one piece come in its direction.
    """
    found = [np.column_stack([np.flatnonzero(piece == a), np.flatnonzero(piece == b)[::-1]]) for a, b in pairs.tolist()]
    return np.concatenate([np.empty((0, 2), np.int64), *found])


def pieces_of_side(boundary: Boundary, name: str) -> Integers:
    """The pieces (k,) of a side; GeometryError if there is no such side with corners."""
    sides = ~boundary.inner & ~boundary.closed
    known = [boundary.labels[k] for k in each_once(boundary.label[sides])]
    if name not in known:
        closed = name in boundary.labels
        hint = "one between corners is needed" if closed else meant(name, known)
        raise GeometryError(f"periodic: there is no side {name!r}: {hint}")
    return np.flatnonzero((boundary.label == boundary.labels.index(name)) & sides)


def motion_of_sides(
    boundary: Boundary, first: Integers, second: Integers, tolerance: float
) -> tuple[Similarity, Integers]:
    """The motion that takes pieces (k,) to others, and the copies (k,) to a tolerance there, -1 if there is none.

    It is a shift if all pieces match by one, else a turn; if they match by neither, the one by which more ends do.
    """
    shift = _shift(boundary, first, second)
    copies = _copies(boundary, first, second, shift, tolerance)
    if (copies >= 0).all():
        return shift, copies
    turn = _turn(boundary, first, second)
    turned = _copies(boundary, first, second, turn, tolerance)
    ends = [_lonely(boundary, first, second, motion).sum() for motion in (shift, turn)]
    return (turn, turned) if (turned >= 0).all() or ends[1] < ends[0] else (shift, copies)


def _shift(boundary: Boundary, first: Integers, second: Integers) -> Similarity:
    """The shift that takes the middle of pieces to that of others."""
    return Similarity(shift=complex(*(_middle(boundary, second) - _middle(boundary, first))))


def _turn(boundary: Boundary, first: Integers, second: Integers) -> Similarity:
    """The turn that takes the middle of pieces to that of others, and the sum of their ways to that one, reversed.

    Where ways add up to nothing, and tell no angle, it is the shift.
    """
    ways = (boundary.corners[boundary.end[k]] - boundary.corners[boundary.start[k]] for k in (first, second))
    way, back = (complex(*sum_) for sum_ in (each.sum(axis=0) for each in ways))
    if min(abs(way), abs(back)) <= _tolerance(boundary):
        return _shift(boundary, first, second)
    factor = -back / way
    here, there = (complex(*_middle(boundary, k)) for k in (first, second))
    return Similarity(factor / abs(factor), there - factor / abs(factor) * here)


def _middle(boundary: Boundary, pieces: Integers) -> Floats:
    """Mean of the ends of the chains that pieces make, which vertices on the way do not move."""
    ends, times = np.unique(np.concatenate([boundary.start[pieces], boundary.end[pieces]]), return_counts=True)
    return boundary.corners[ends[times == 1] if (times == 1).any() else ends].mean(axis=0)


def _unmatched(boundary: Boundary, piece: int, others: Integers, motion: Similarity) -> tuple[float, float]:
    """Place on a piece with nothing alike on the other ones: a vertex where they have none, or else its middle."""
    lonely = _lonely(boundary, np.array([piece]), others, motion)
    middle = boundary.points(np.array([piece]), boundary.lengths[[piece]] / 2)[0]
    ends = boundary.corners[[boundary.start[piece], boundary.end[piece]]]
    x, y = (middle if lonely.all() or not lonely.any() else ends[lonely.argmax()]).tolist()
    return x, y


def _lonely(boundary: Boundary, pieces: Integers, others: Integers, motion: Similarity) -> Booleans:
    """Mask (2k,) of the starts and then the ends of pieces (k,) that a motion takes to no end of the others."""
    ends, known = (boundary.corners[np.concatenate([boundary.start[k], boundary.end[k]])] for k in (pieces, others))
    away = np.hypot(*np.moveaxis(motion.points(ends)[:, None] - known, -1, 0)).min(axis=1)
    return np.asarray(away > _tolerance(boundary))


def _copies(boundary: Boundary, pieces: Integers, others: Integers, motion: Similarity, tolerance: float) -> Integers:
    """The first of the ``others`` that is a copy of each piece (k,), moved and reversed; -1 if there is none."""
    alike = _misfits(boundary, pieces, others, motion) <= tolerance
    return np.where(alike.any(axis=1), others[alike.argmax(axis=1)], -1)


def _misfits(boundary: Boundary, pieces: Integers, others: Integers, motion: Similarity) -> Floats:
    """By how much (k, m) each piece (k,), moved and reversed, differs from the others (m,)."""
    share = np.linspace(0, 1, SAMPLES)
    here = motion.points(_samples(boundary, pieces, share)).reshape(-1, SAMPLES, 2)
    there = _samples(boundary, others, 1 - share).reshape(-1, SAMPLES, 2)
    return np.array([np.abs(each - there).max(axis=(1, 2)) for each in here])


def _advice(boundary: Boundary, first: Integers, second: Integers, tolerance: float) -> str:
    """What makes two sides match if they nearly do, and no tolerance was given for that; else nothing."""
    size = float(np.ptp(boundary.corners, axis=0).max())
    motions = _shift(boundary, first, second), _turn(boundary, first, second)
    misfit = min(float(_misfits(boundary, first, second, motion).min(axis=1).max()) for motion in motions)
    if tolerance or len(first) != len(second) or misfit > NEARLY * size:
        return ""
    return (
        f"; they differ by up to {misfit:.2g}, and {TOUCHING:g} of the size of the domain is allowed, "
        f"{TOUCHING * size:.2g}: "
        f"periodic_tolerance: {2 * misfit:.1g} in domain makes the second side the first one moved"
    )


def _samples(boundary: Boundary, pieces: Integers, share: Floats) -> Floats:
    """Points (k * m, 2) at shares (m,) of the lengths of pieces (k,)."""
    return boundary.points(np.repeat(pieces, len(share)), (boundary.lengths[pieces][:, None] * share).ravel())


def _tolerance(boundary: Boundary) -> float:
    return TOUCHING * float(np.ptp(boundary.corners, axis=0).max())
