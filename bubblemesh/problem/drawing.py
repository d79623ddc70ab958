"""Where the keys of a case take what is drawn: one similarity for each of its copies."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Protocol, Self, TypeVar

import numpy as np

from bubblemesh.arrays import Integers
from bubblemesh.case.drawing import AroundKeys, DrawnKeys, GridKeys, RepeatKeys, TurnKeys
from bubblemesh.case.fields import MOST_COPIES
from bubblemesh.case.geometry_files import SelectedFile
from bubblemesh.errors import CaseError
from bubblemesh.geometry.similarity import UNMOVED, Similarity

Name = Callable[[str | None], str]
"""Makes the name of a copy of the name of what is repeated, if that has one."""


class Movable(Protocol):
    """Things that similarities move: rings, lines, points; they may be outside of the domain if they are optional."""

    def moved(self, by: Similarity) -> Self: ...

    def relabelled(self, name: Name) -> Self: ...

    def as_optional(self) -> Self: ...


T = TypeVar("T", bound=Movable)


def drawn(
    things: Iterable[T], keys: DrawnKeys, named: Callable[[T, Name], T] = lambda thing, name: thing.relabelled(name)
) -> list[T]:
    """Things where some keys take them: all of the first copy, then all of the next one, and so on.

    ``named`` gives a copy its name, by default in all of its labels. CaseError if that makes too many of them, or one
    cannot have its name.
    """
    given, repeat = list(things), keys.repeat
    if repeat is not None and repeat.outside == "skip":
        given = [thing.as_optional() for thing in given]
    i, j = _numbers(repeat)
    similarities = _similarities(keys, i, j)
    names: Sequence[Name | None] = [None] * len(i)
    if repeat is not None and repeat.name is not None:
        names = repeat.name.of_copies(i, j)
    elif similarities == [UNMOVED]:
        return given
    if len(given) * len(similarities) > MOST_COPIES:
        raise CaseError(f"makes {len(given) * len(similarities):,} copies, more than {MOST_COPIES:,}: ask for fewer")
    copies = ((thing.moved(by), name) for by, name in zip(similarities, names, strict=True) for thing in given)
    return [thing if name is None else named(thing, name) for thing, name in copies]


def _numbers(repeat: RepeatKeys | None) -> tuple[Integers, Integers]:
    """Column (n,) and row (n,) of each copy, from 0; CaseError if all are left out."""
    match repeat:
        case None:
            return np.zeros(1, np.int64), np.zeros(1, np.int64)
        case GridKeys(grid=(columns, rows)):
            i, j = np.divmod(np.arange(columns * rows), rows)
        case AroundKeys(times=times):
            i, j = np.arange(times), np.zeros(times, np.int64)
    if repeat.where is None:
        return i, j
    kept = np.flatnonzero(repeat.where(i.astype(float), j.astype(float)))
    if len(kept) == 0:
        raise CaseError(f"repeat: no copy has {repeat.where}: correct the condition, or remove what it repeats")
    return i[kept], j[kept]


def _similarities(keys: DrawnKeys, i: Integers, j: Integers) -> list[Similarity]:
    """Similarities that take what is drawn to its copies; lengths of files are scaled when they are read."""
    turn = keys.rotate if isinstance(keys.rotate, TurnKeys) else TurnKeys(by=keys.rotate or 0.0)
    scale = 1.0 if isinstance(keys, SelectedFile) else keys.scale or 1.0
    first = Similarity.of(keys.mirror, scale, turn.by, turn.about, keys.move or (0.0, 0.0))
    match keys.repeat:
        case None:
            return [first]
        case GridKeys(step=(dx, dy)):
            shifts = [complex(dx * a, dy * b) for a, b in zip(i.tolist(), j.tolist(), strict=True)]
            return [replace(first, shift=first.shift + shift) for shift in shifts]
        case AroundKeys(around=center, times=times):
            return [first.then(Similarity.of(rotate=360 * k / times, about=center)) for k in i.tolist()]
