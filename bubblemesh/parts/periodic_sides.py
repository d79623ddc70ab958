"""Cuts beside periodic sides: their ends meet exactly at counterparts of each other, or are well apart.

Each end is a node on its side, and one at its counterpart on the other: two that are next to each other make a short
edge on both.
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations, permutations, product

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.geometry.arrangement import TOUCHING
from bubblemesh.geometry.boundary import Boundary, Chords
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.periodic import counterparts
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing

NEXT = 1.0  # spacings: ends that are nearer, and not the same, are too near
STEPS = 3  # of Newton's method, from a chord to its curve
SQUARE = 0.05  # least sine of the angle between a cut and a side for these


@record
class CutPeriodicSides:
    """The periodic sides of a domain, and where cuts meet them so far."""

    boundary: Boundary
    pairs: Integers  # (k, 2): pieces that match
    chords: Chords  # of these pieces
    size: float  # of the domain
    spacing: Spacing
    met: Floats  # (n, 2): ends of cuts, and counterparts of ends

    @classmethod
    def of(cls, domain: Domain, spacing: Spacing) -> "CutPeriodicSides":
        """The periodic sides of a domain that is not cut yet."""
        chords = domain.boundary.chords()
        mine = np.isin(chords.piece, domain.periodic)
        own = Chords(chords.piece[mine], chords.s[mine], chords.step[mine], chords.start[mine], chords.end[mine])
        return cls(domain.boundary, domain.periodic, own, domain.size, spacing, np.zeros((0, 2)))

    def with_cut(self, ends: Floats) -> "CutPeriodicSides":
        """What is met once there is a cut between two points (2, 2)."""
        return replace(self, met=np.concatenate([self.met, *self._crossings(ends)]))

    def apart(self, ends: Floats) -> float:
        """The least distance, in spacings, of nodes on a side if there were a cut between two points (2, 2).

        Those at the same place, and those that are farther apart than `NEXT`, count as infinitely far.
        """
        here, there = self._crossings(ends)
        if len(here) == 0:
            return np.inf
        others = np.concatenate([self.met, there])
        away = np.hypot(*(here[:, None] - others).transpose(2, 0, 1))
        spacings = away / self.spacing.extended(here)[:, None]
        return float(np.where((away <= TOUCHING * self.size) | (spacings >= NEXT), np.inf, spacings).min())

    def lines(self, ends: Floats) -> Iterator[Floats]:
        """Lines (2, 2), as two points on each, near to one between ``ends`` (2, 2) that may meet the sides better.

        They are parallel to it through places that are met already, run from a place to its own counterpart, or run
        through two places, of those that are met and those where the line itself crosses the sides.
        """
        here, there = self._crossings(ends)
        reach = NEXT * self.spacing.extended(here)
        near = [self.met[np.hypot(*(self.met - x).T) <= r] for x, r in zip(here, reach, strict=True)]
        known = [np.concatenate([places, [x]]) for places, x in zip(near, here, strict=True)]
        for places in near:
            yield from (np.array([x, x + ends[1] - ends[0]]) for x in places)
        for one, two in permutations(range(len(here)), 2):
            if np.hypot(*(there[one] - here[two])) <= reach[two]:
                yield from (np.array([x, x + there[one] - here[one]]) for x in known[one])
        for first, second in combinations(known, 2):
            yield from (np.array(pair) for pair in product(first, second))

    def _crossings(self, ends: Floats) -> tuple[Floats, Floats]:
        """Places (k, 2) where a line between two points (2, 2) crosses the sides, and their counterparts (k, 2)."""
        way = ends[1] - ends[0]
        start, end = (_left_of(points, ends) for points in (self.chords.start, self.chords.end))
        across = np.flatnonzero((start >= 0) != (end >= 0))
        share = start[across] / (start[across] - end[across])
        piece, step = self.chords.piece[across], self.chords.step[across]
        s = self.chords.s[across] + share * step
        for _ in range(STEPS if self.boundary.curved[piece].any() else 0):
            slope = _left_of(self.boundary.tangents(piece, s) + ends[0], ends)
            off = _left_of(self.boundary.points(piece, s), ends)
            steep = np.abs(slope) > SQUARE * np.hypot(*way)
            s = self.boundary.wrapped(piece, s - np.where(steep, off / np.where(steep, slope, 1.0), 0.0))
        at = self.boundary.points(piece, s)
        along = (at - ends[0]) @ way / (way @ way)
        within = (along >= 0) & (along <= 1)
        own, other, there = counterparts(self.boundary, self.pairs, piece[within], s[within])
        return at[within][own], self.boundary.points(other, there)


def _left_of(points: Floats, ends: Floats) -> Floats:
    """Twice the area (n,) of each triangle between two points (2, 2) and points (n, 2), positive on the left."""
    (ux, uy), (x, y) = ends[1] - ends[0], (points - ends[0]).T
    return np.asarray(ux * y - uy * x)
