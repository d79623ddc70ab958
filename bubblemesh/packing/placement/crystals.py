"""Hexagonal lattices that fit the straight walls of a domain."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, taken
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.placement.plateaus import Plateau
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing

STRAIGHT = 1e-9  # relative difference of arc and chord
TURN = 60.0  # degrees by which a lattice is turned into itself
ALIKE = 1.0  # degrees: walls in directions that differ by less are served by one lattice
PARALLEL = 0.1  # degrees
ROOM = 4.0  # bubbles for each one on walls that a lattice does not fit
STRETCHED = 0.05  # most by which a lattice gives way to fit the walls
ROWS_APART = np.sqrt(3) / 2  # in terms of the distance of bubbles in a row


class LatticeWalls(NamedTuple):
    """Straight pieces of a boundary."""

    start: Floats  # (k, 2)
    along: Floats  # (k, 2): unit vectors
    length: Floats  # (k,)

    @classmethod
    def of(cls, domain: Domain) -> "LatticeWalls":
        """All straight pieces of a domain's boundary."""
        boundary = domain.boundary
        piece = np.flatnonzero(~boundary.closed)
        length = boundary.lengths[piece]
        start, end = boundary.points(piece, np.zeros(len(piece))), boundary.points(piece, length)
        chord = np.hypot(*(end - start).T)
        straight = np.flatnonzero(chord >= length * (1 - STRAIGHT))
        along = taken(end - start, straight) / chord[straight, None]
        return cls(taken(start, straight), along, chord[straight])

    def on(self, plateau: Plateau, spacing: Spacing) -> "LatticeWalls":
        """Walls longer than the spacing of a plateau that have it at their middle."""
        middle = self.start + self.along * self.length[:, None] / 2
        some = np.flatnonzero((self.length > plateau.d) & plateau.holds(spacing.extended(middle)))
        return LatticeWalls(*(taken(column, some) for column in self))

    @property
    def main(self) -> int:
        """Number of the longest of those along the directions of one lattice that are longest together."""
        angle = np.degrees(np.arctan2(self.along[:, 1], self.along[:, 0])) % TURN
        order = np.argsort(angle, kind="stable")
        angles, twice = np.append(angle[order], angle[order] + TURN), np.tile(order, 2)
        before = np.append(0.0, np.cumsum(self.length[twice]))
        end = np.searchsorted(angles, angle[order] + ALIKE, side="right")
        first = int(np.argmax(before[end] - before[: len(order)]))
        alike = twice[first : end[first]]
        return int(alike[np.argmax(self.length[alike])])


@record
class Crystal:
    """A hexagonal lattice for a plateau: rows of bubbles, every second one shifted by half a step."""

    plateau: Plateau
    origin: Floats  # (2,): one of its bubbles
    along: Floats  # (2,): unit vector of the rows
    step: float  # from bubble to bubble in a row
    height: float  # from row to row

    @classmethod
    def fitting(cls, plateau: Plateau, domain: Domain, spacing: Spacing) -> "Crystal":
        """The lattice along the main wall of a plateau, stretched a little to fit it and the longest one facing it."""
        d, walls = plateau.d, LatticeWalls.of(domain).on(plateau, spacing)
        if len(walls.length) == 0:
            x0, y0, x1, y1 = domain.bounds
            return cls(plateau, np.array([x0 + x1, y0 + y1]) / 2, np.array([1.0, 0.0]), d, ROWS_APART * d)
        main = walls.main
        origin, along = walls.start[main], walls.along[main]
        across = np.array([-along[1], along[0]])
        step = _fitting(walls.length[main], d)
        height = ROWS_APART * d * d / step  # as many bubbles as the spacing asks for
        away = np.abs(((walls.start - origin) * across).sum(axis=1))
        slope = np.abs((walls.along * across).sum(axis=1))
        facing = np.flatnonzero((slope < np.sin(np.radians(PARALLEL))) & (away > height / 2))
        if len(facing):
            height = _fitting(away[facing[np.argmax(walls.length[facing])]], height)
        return cls(plateau, origin, along, step, height)

    def has_room(self, domain: Domain, spacing: Spacing) -> bool:
        """Whether the plateau has many bubbles for each one on walls that the lattice does not fit."""
        chords = domain.boundary.chords()
        dx, dy = (chords.end - chords.start).T
        rows = np.arctan2(self.along[1], self.along[0])
        turn = np.degrees(np.arctan2(dy, dx) - rows) % TURN
        misfit = np.minimum(turn, TURN - turn) > ALIKE
        held = self.plateau.holds(spacing.extended((chords.start + chords.end) / 2))
        on_walls = float(np.hypot(dx, dy)[misfit & held].sum()) / self.plateau.d
        return self.plateau.bubbles >= ROOM * on_walls

    def coarser(self, factor: float) -> "Crystal":
        """The lattice around the same origin for a spacing so many times as large."""
        plateau = replace(self.plateau, d=self.plateau.d * factor)
        return replace(self, plateau=plateau, step=self.step * factor, height=self.height * factor)

    def nearest(self, x: Floats) -> Floats:
        """The places (n, 2) of the bubbles nearest to points x (n, 2), of each bubble the same to the last bit."""
        (ax, ay), (ox, oy) = self.along.tolist(), self.origin.tolist()
        dx, dy = x[:, 0] - ox, x[:, 1] - oy
        u, v = dx * ax + dy * ay, dy * ax - dx * ay  # along the rows and across
        low = np.floor(v / self.height)
        below, above = (self._in_row(row, u, v) for row in (low, low + 1))
        nearer = above.away < below.away
        along, across = np.where(nearer, above.along, below.along), np.where(nearer, above.across, below.across)
        return np.column_stack([ox + (along * ax - across * ay), oy + (along * ay + across * ax)])

    def _in_row(self, row: Floats, u: Floats, v: Floats) -> "_Nearest":
        """The bubbles of rows (n,) nearest to points."""
        shift = (row - 2 * np.floor(row / 2)) / 2
        along, across = (np.rint(u / self.step - shift) + shift) * self.step, row * self.height
        return _Nearest(along, across, (along - u) ** 2 + (across - v) ** 2)


class _Nearest(NamedTuple):
    """Places of bubbles from the origin of their lattice, and how far points are away from them."""

    along: Floats  # (n,)
    across: Floats  # (n,)
    away: Floats  # (n,): squared


def _fitting(length: float, step: float) -> float:
    """The step, or one like it that divides a length evenly."""
    even = length / max(round(length / step), 1)
    return even if abs(even / step - 1) <= STRETCHED else step
