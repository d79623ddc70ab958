"""Small mistakes of files that are dropped on reading: points given twice, spikes, rings that bound no area."""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from bubblemesh.arrays import Booleans, Floats
from bubblemesh.geometry.paths import Point
from bubblemesh.geometry.rings import LineTo, Piece, end_of
from bubblemesh.messages import counted, place, with_labels
from bubblemesh.records import record

SAME = 1e-13  # of a ring's extent: nearer points are the same, as in rings of a case
ROUNDINGS = 4  # rounding errors of coordinates by which the end of a spike may be off its longer side


@record
class Slips:
    """Numbers of mistakes that were dropped, by kind, and the place of the first one."""

    doubles: int = 0  # points given twice in a row, which are lines of no length
    spikes: int = 0  # points at which a ring turns back on itself
    flat: int = 0  # rings that bound no area
    copies: int = 0  # curves given twice
    first: Point | None = None
    labels: tuple[str, ...] = ()  # of curves given twice, where the one that stays has another label
    largest: float = 0.0  # coordinate of loops that something was dropped from

    def __add__(self, other: "Slips") -> "Slips":
        first = other.first if self.first is None else self.first
        doubles, spikes, flat = self.doubles + other.doubles, self.spikes + other.spikes, self.flat + other.flat
        labels = tuple(dict.fromkeys((*self.labels, *other.labels)))
        largest = max(self.largest, other.largest)
        return Slips(doubles, spikes, flat, self.copies + other.copies, first, labels, largest)

    def moved(self, place_of: Callable[[Point], Point | None]) -> "Slips":
        """The slips with the place that a function gives for the first one, if it does."""
        return self if self.first is None else replace(self, first=place_of(self.first))

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on all slips together; empty if there are none."""
        kinds = {
            "duplicate point": self.doubles,
            "spike": self.spikes,
            "double line": self.copies,
            "flat ring": self.flat,
        }
        parts = [counted(number, noun) for noun, number in kinds.items() if number]
        where = "" if self.first is None else f", the first at {place(self.first)}"
        return (f"{', '.join(parts)} dropped{where}{with_labels(self.labels)}",) if parts else ()


def clean_loop(start: Point, pieces: Sequence[Piece]) -> tuple[Point, list[Piece], Slips]:
    """Start and pieces of a closed loop without lines of no length and without spikes, and what was dropped.

    A spike is a point between two straight lines of which the second runs back along the first. If a loop of straight
    lines has no area, no piece is left.
    """
    ends = np.array([start, *(end_of(piece) for piece in pieces)], float)
    if not has_slips(ends, np.array([isinstance(piece, LineTo) for piece in pieces])):
        return start, list(pieces), Slips()
    tolerance, rounding = _tolerances(ends)
    loop = _Loop(tolerance, rounding)
    here = start
    for piece in pieces:
        loop.append(here, piece)
        here = end_of(piece)
    loop.close()
    kept = [piece for _, piece in loop.pieces]
    largest = float(np.abs(ends).max())
    if len(kept) < 3 and all(isinstance(piece, LineTo) for piece in kept):
        return start, [], Slips(flat=1, first=start, largest=largest)
    return loop.pieces[0][0], kept, replace(loop.slips, largest=largest)


def has_slips(ends: Floats, straight: Booleans | bool = True) -> bool:
    """Whether `clean_loop` would drop anything of a loop through ``ends`` (n + 1, 2), of which the last is the first.

    ``straight`` is the mask (n,) of the pieces that are straight lines, by default all.
    """
    tolerance, rounding = _tolerances(ends)
    steps, straight = np.diff(ends, axis=0), np.broadcast_to(straight, len(ends) - 1)
    short = straight & (np.abs(steps).max(axis=1) <= tolerance)
    (ux, uy), (wx, wy) = steps.T, np.roll(steps, -1, axis=0).T
    longer = np.maximum(np.hypot(ux, uy), np.hypot(wx, wy))
    back = (ux * wx + uy * wy < 0) & (np.abs(ux * wy - uy * wx) <= rounding * longer)
    return bool(short.any() or (back & straight & np.roll(straight, -1)).any())


def _tolerances(ends: Floats) -> tuple[float, float]:
    """Distances below which points count as the same, and lines as running back along each other."""
    return SAME * float(np.ptp(ends, axis=0).max()), ROUNDINGS * float(np.spacing(np.abs(ends).max()))


@dataclass
class _Loop:
    """Pieces of a loop with their starts, as far as they have been checked."""

    tolerance: float
    rounding: float
    pieces: deque[tuple[Point, Piece]] = field(default_factory=deque)
    slips: Slips = field(default_factory=Slips)

    def append(self, start: Point, piece: Piece) -> None:
        """Append a piece, or drop it, or shorten the last one by it."""
        if isinstance(piece, LineTo) and self._same(start, piece.to):
            self.slips += Slips(doubles=1, first=start)
            return
        while self.pieces and self._is_spike(self.pieces[-1], (start, piece)):
            self.slips += Slips(spikes=1, first=start)
            start, piece = _merged(self.pieces.pop(), (start, piece))
            if self._same(start, piece.to):
                return
        self.pieces.append((start, piece))

    def close(self) -> None:
        """Drop the spikes at the start of the loop."""
        while len(self.pieces) > 1 and self._is_spike(self.pieces[-1], self.pieces[0]):
            first, last = self.pieces.popleft(), self.pieces.pop()
            self.slips += Slips(spikes=1, first=first[0])
            start, merged = _merged(last, first)
            if not self._same(start, merged.to):
                self.append(start, merged)

    def _same(self, a: Point, b: Point) -> bool:
        return max(abs(a[0] - b[0]), abs(a[1] - b[1])) <= self.tolerance

    def _is_spike(self, one: tuple[Point, Piece], other: tuple[Point, Piece]) -> bool:
        """Whether the ``other`` of two straight pieces runs back along the first."""
        (a, to), (b, away) = one, other
        if not (isinstance(to, LineTo) and isinstance(away, LineTo)):
            return False
        ux, uy, wx, wy = b[0] - a[0], b[1] - a[1], away.to[0] - b[0], away.to[1] - b[1]
        longer = max(np.hypot(ux, uy), np.hypot(wx, wy))
        return ux * wx + uy * wy < 0 and abs(ux * wy - uy * wx) <= self.rounding * longer


def _merged(one: tuple[Point, Piece], other: tuple[Point, Piece]) -> tuple[Point, LineTo]:
    """The straight line that remains if the second of two runs back along the first; it has the longer one's label."""
    (a, to), (b, away) = one, other
    end = end_of(away)
    longer = to if np.hypot(b[0] - a[0], b[1] - a[1]) >= np.hypot(end[0] - b[0], end[1] - b[1]) else away
    return a, LineTo(end, longer.label)
