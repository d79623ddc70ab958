"""Where the keys of a case take what is drawn: one similarity for each of its copies."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Protocol, Self, TypeVar

import numpy as np

from bubblemesh.arrays import Integers
from bubblemesh.case.drawing import AroundKeys, DrawnKeys, GridKeys, TurnKeys
from bubblemesh.case.fields import MOST_COPIES
from bubblemesh.case.geometry_files import SelectedFile
from bubblemesh.errors import CaseError
from bubblemesh.geometry.similarity import UNMOVED, Similarity
from bubblemesh.spacing.expression import Expression


class Movable(Protocol):
    """Things that similarities move: rings, lines, points."""

    def moved(self, by: Similarity) -> Self: ...


T = TypeVar("T", bound=Movable)


def drawn(things: Iterable[T], keys: DrawnKeys) -> list[T]:
    """Things where some keys take them: all of the first copy, then all of the next one, and so on.

    CaseError if that makes too many of them.
    """
    given, similarities = list(things), similarities_of(keys)
    if similarities == [UNMOVED]:
        return given
    if len(given) * len(similarities) > MOST_COPIES:
        raise CaseError(f"makes {len(given) * len(similarities):,} copies, more than {MOST_COPIES:,}: ask for fewer")
    return [thing.moved(similarity) for similarity in similarities for thing in given]


def similarities_of(keys: DrawnKeys) -> list[Similarity]:
    """Similarities that take what is drawn to its copies; lengths of files are scaled when they are read."""
    turn = keys.rotate if isinstance(keys.rotate, TurnKeys) else TurnKeys(by=keys.rotate or 0.0)
    scale = 1.0 if isinstance(keys, SelectedFile) else keys.scale or 1.0
    first = Similarity.of(keys.mirror, scale, turn.by, turn.about, keys.move or (0.0, 0.0))
    match keys.repeat:
        case None:
            return [first]
        case GridKeys(grid=(columns, rows), step=(dx, dy), where=where):
            i, j = np.divmod(np.arange(columns * rows), rows)
            shifts = [complex(dx * a, dy * b) for a, b in zip(*_kept(i, j, where), strict=True)]
            return [replace(first, shift=first.shift + shift) for shift in shifts]
        case AroundKeys(around=center, times=times, where=where):
            i = np.arange(times)
            turns = [Similarity.of(rotate=360 * k / times, about=center) for k in _kept(i, 0 * i, where)[0]]
            return [first.then(turn) for turn in turns]


def _kept(i: Integers, j: Integers, where: Expression | None) -> tuple[list[int], list[int]]:
    """Numbers of the copies that are left; CaseError if all are left out."""
    if where is not None:
        kept = np.flatnonzero(where(i.astype(float), j.astype(float)))
        if len(kept) == 0:
            raise CaseError(f"repeat: no copy has {where}: correct the condition, or remove what it repeats")
        i, j = i[kept], j[kept]
    return i.tolist(), j.tolist()
