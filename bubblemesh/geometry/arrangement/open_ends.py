"""Open ends of embedded lines, which part nothing there; and what closes the gaps to what is nearest."""

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.arrangement.bellies import NEWTON_STEPS
from bubblemesh.geometry.arrangement.crossings import ChordBoxes, chord_boxes
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.paths import OpenPath
from bubblemesh.messages import just_above, place
from bubblemesh.records import Uncached, record

FAR = 0.1  # of the domain's size: ends that are farther from all else are left out
NEARLY_CLOSED = 0.5  # of the length of a line: its ends are farther from each other in a line that does not close
MOST_NAMED = 3


class Gap(NamedTuple):
    """What is between an open end of a line and the nearest thing."""

    at: Floats  # (2,), the open end
    width: float
    text: str  # where the line ends, and how far from what
    join: str | None  # the value of the key that closes it, if the line has it


@record(eq=False)
class OpenEnds(Uncached):
    """Ends of lines at which nothing else is; the pieces of the lines have the ring numbers -1, -2 and so on."""

    lines: Sequence[OpenPath]
    boundary: Boundary  # of noded pieces, each once
    size: float  # of the domain
    rings_joined: bool = True  # whether `join` moves ends onto rings

    def advice(self, some: Booleans) -> str:
        """Where some ends (k,) leave gaps, and what closes these; empty if none is near to anything."""
        gaps = self.gaps(np.where(some, FAR * self.size, 0.0))[:MOST_NAMED]
        told = [gap.text + (f" (join: {gap.join} closes that)" if gap.join else "") for gap in gaps]
        return "; ".join(told)

    @property
    def places(self) -> Floats:
        """Places (k, 2) of the ends."""
        return self.boundary.corners[self._ends[0]]

    def gaps(self, reaches: Floats) -> list[Gap]:
        """Gaps at the ends up to a width (k,) of each, the narrowest first; none where that is 0."""
        ends = zip(*(column.tolist() for column in self._ends), reaches.tolist(), strict=True)
        found = (self._gap(corner, piece, reach) for corner, piece, reach in ends if reach > 0)
        return sorted((gap for gap in found if gap is not None), key=lambda gap: gap.width)

    @cached_property
    def _ends(self) -> tuple[Integers, Integers]:
        """Corners (k,) of open ends, and the pieces (k,) that end there."""
        boundary = self.boundary
        own = boundary.inner & (-1 - boundary.ring < len(self.lines)) & ~boundary.closed
        uses = np.bincount(np.concatenate([boundary.start, boundary.end])[np.tile(~boundary.closed, 2)])
        corner = np.concatenate([boundary.start[own], boundary.end[own]])
        alone = uses[corner] == 1
        return corner[alone], np.tile(np.flatnonzero(own), 2)[alone]

    @cached_property
    def _chords(self) -> ChordBoxes:
        return chord_boxes(self.boundary, self.size)

    def _gap(self, corner: int, piece: int, reach: float) -> Gap | None:
        """The gap from an open end of a piece to what is nearest; None if that is farther than a reach."""
        boundary, chords = self.boundary, self._chords
        at, ring = boundary.corners[corner], boundary.ring[piece]
        line = self.lines[-1 - int(ring)]
        told = f"the line {line.name} ends at {place(at)}"
        near = chords.boxes.query(shapely.Point(at), predicate="dwithin", distance=reach)
        near = near[boundary.ring[chords.piece[near]] != ring]
        other, points = chords.piece[near], np.broadcast_to(at, (len(near), 2))
        s = boundary.foot(points, other, chords.s[near] + chords.step[near] / 2, NEWTON_STEPS)
        gaps = np.hypot(*(boundary.points(other, boundary.wrapped(other, s)) - at).T)
        width, its_own = float(gaps.min(initial=np.inf)), self._to_other_end(corner, ring)
        if min(width, its_own) > reach:
            return None
        if its_own < width:
            return Gap(at, its_own, f"{told}, {its_own:.2g} from its other end", None)
        nearest = other[np.argmin(gaps)]
        beside = boundary.labels[boundary.label[nearest]]
        joins = "lines" in line.key and (self.rings_joined or boundary.inner[nearest])
        return Gap(at, width, f"{told}, {width:.2g} from {beside!r}", just_above(width / line.unit) if joins else None)

    def _to_other_end(self, corner: int, ring: int) -> float:
        """Distance of the first open end of a line from the other one, if the line nearly closes: one gap for both."""
        corners, pieces = self._ends
        others = corners[(self.boundary.ring[pieces] == ring) & (corners > corner)]
        away = self.boundary.corners[others] - self.boundary.corners[corner]
        width = float(np.hypot(*away.T).min(initial=np.inf))
        length = float(self.boundary.lengths[self.boundary.ring == ring].sum())
        return width if width < NEARLY_CLOSED * length else np.inf
