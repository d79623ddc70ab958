"""Periodic sides: pieces that are shifted copies of others across the domain."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from bubblemesh.arrays import Floats, Integers, each_once
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.arrangement import TOUCHING
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.messages import meant, two_places

SAMPLES = 9


def matching_pieces(boundary: Boundary, labels: Sequence[tuple[str, str]]) -> Integers:
    """Pairs (k, 2) of pieces, of which the second is the first one, shifted and reversed.

    They belong to sides whose labels match, in any order of their pieces. GeometryError, with the coordinates, if there
    is no such label, or a piece has no counterpart.
    """
    pairs: list[tuple[int, int]] = []
    used = Counter(name for names in labels for name in names)
    twice = next((name for name, times in used.items() if times > 1), None)
    if twice is not None:
        raise GeometryError(f"periodic: the side {twice!r} is named twice: each side has one counterpart")
    for names in labels:
        first, second = (_pieces(boundary, name) for name in names)
        shift = _middle(boundary, second) - _middle(boundary, first)
        for piece in first:
            match = [other for other in second if _is_copy(boundary, int(piece), int(other), shift)]
            if not match:
                at = _unmatched(boundary, int(piece), second, shift)
                here, there = two_places(at, at + shift)
                raise GeometryError(
                    f"periodic sides {names[0]!r} and {names[1]!r}: what is at {here} has no counterpart at "
                    f"{there}: both sides need the same shape and the same vertices, moved but not turned"
                )
            pairs.append((int(piece), int(match[0])))
        if len(first) != len(second):
            raise GeometryError(f"periodic sides {names[0]!r} and {names[1]!r} have different numbers of pieces")
    return np.array(pairs, np.int64).reshape(-1, 2)


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


def _pieces(boundary: Boundary, name: str) -> Integers:
    sides = ~boundary.inner & ~boundary.closed
    known = [boundary.labels[k] for k in each_once(boundary.label[sides])]
    if name not in known:
        closed = name in boundary.labels
        hint = "one between corners is needed" if closed else meant(name, known)
        raise GeometryError(f"periodic: there is no side {name!r}: {hint}")
    return np.flatnonzero((boundary.label == boundary.labels.index(name)) & sides)


def _middle(boundary: Boundary, pieces: Integers) -> Floats:
    """Mean of the ends of the chains that pieces make, which vertices on the way do not move."""
    ends, times = np.unique(np.concatenate([boundary.start[pieces], boundary.end[pieces]]), return_counts=True)
    return boundary.corners[ends[times == 1] if (times == 1).any() else ends].mean(axis=0)


def _unmatched(boundary: Boundary, piece: int, others: Integers, shift: Floats) -> Floats:
    """Place (2,) on a piece with nothing alike on the other ones: a vertex where they have none, or else its middle."""
    ends = boundary.corners[[boundary.start[piece], boundary.end[piece]]]
    middle = boundary.points(np.array([piece]), boundary.lengths[[piece]] / 2)[0]
    known = boundary.corners[np.concatenate([boundary.start[others], boundary.end[others]])]
    away = np.hypot(*np.moveaxis(ends[:, None] + shift - known, -1, 0)).min(axis=1)
    lonely = away > TOUCHING * float(np.ptp(boundary.corners, axis=0).max())
    return np.asarray(middle if lonely.all() or not lonely.any() else ends[away.argmax()])


def _is_copy(boundary: Boundary, piece: int, other: int, shift: Floats) -> bool:
    share = np.linspace(0, 1, SAMPLES)
    here = boundary.points(np.full(SAMPLES, piece), share * boundary.lengths[piece])
    there = boundary.points(np.full(SAMPLES, other), (1 - share) * boundary.lengths[other])
    tolerance = TOUCHING * float(np.ptp(boundary.corners, axis=0).max())
    return bool(np.abs(here + shift - there).max() <= tolerance)
