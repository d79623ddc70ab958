"""Open ends of embedded lines, which part nothing there; and what closes the gaps to what is nearest."""

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers, pairs_of_groups
from bubblemesh.geometry.arrangement.bellies import NEWTON_STEPS
from bubblemesh.geometry.arrangement.crossings import ChordBoxes, chord_boxes
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.paths import OpenPath
from bubblemesh.messages import just_above, place
from bubblemesh.records import Uncached, record

FAR = 0.1  # of the domain's size: ends that are farther from all else are left out
NEARLY_CLOSED = 0.5  # of the length of a line: its ends are farther from each other in a line that does not close
MOST_ENDS_NAMED = 3
REACHES = 4.0 ** np.arange(-10, 1)  # of FAR, one after the other, until that many gaps are found


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
        """Where some ends (k,) leave the narrowest gaps, and what closes these; empty if none is near to anything."""
        gaps: list[Gap] = []
        for reach in FAR * self.size * REACHES:  # all gaps at once would be about the square of the ends
            gaps = self.gaps(np.where(some, reach, 0.0))
            if len(gaps) >= MOST_ENDS_NAMED:
                break
        told = [gap.text + (f" (join: {gap.join} closes that)" if gap.join else "") for gap in gaps[:MOST_ENDS_NAMED]]
        return "; ".join(told)

    @property
    def places(self) -> Floats:
        """Places (k, 2) of the ends."""
        return self.boundary.corners[self._ends[0]]

    def gaps(self, reaches: Floats) -> list[Gap]:
        """Gaps at the ends up to a width (k,) of each, the narrowest first; none where that is 0."""
        widths, nearest = self._to_others(reaches)
        either = np.minimum(widths, self._to_other_ends)
        found = np.flatnonzero((reaches > 0) & (either <= reaches))
        found = found[np.argsort(either[found], kind="stable")]
        columns = (column[found].tolist() for column in (*self._ends, widths, nearest, self._to_other_ends))
        return [self._gap(*row) for row in zip(*columns, strict=True)]

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

    def _gap(self, corner: int, piece: int, width: float, nearest: int, to_other_end: float) -> Gap:
        """The gap at an open end of a piece, this wide to the nearest other piece, or else to the other end."""
        boundary, at = self.boundary, self.boundary.corners[corner]
        line = self.lines[-1 - int(boundary.ring[piece])]
        told = f"the line {line.name} ends at {place(at)}"
        if to_other_end < width:
            return Gap(at, to_other_end, f"{told}, {to_other_end:.2g} from its other end", None)
        beside = boundary.labels[boundary.label[nearest]]
        joins = "lines" in line.key and (self.rings_joined or bool(boundary.inner[nearest]))
        return Gap(at, width, f"{told}, {width:.2g} from {beside!r}", just_above(width / line.unit) if joins else None)

    def _to_others(self, reaches: Floats) -> tuple[Floats, Integers]:
        """Distances (k,) of the ends from the nearest pieces (k,) of others; infinite if none is within reach (k,)."""
        boundary, chords = self.boundary, self._chords
        corner, own = self._ends
        asked = np.flatnonzero(reaches > 0)
        points = shapely.points(self.places[asked])
        row, chord = chords.boxes.query(points, predicate="dwithin", distance=reaches[asked])
        end, other = asked[row], chords.piece[chord]
        foreign = boundary.ring[other] != boundary.ring[own[end]]
        end, other, chord = end[foreign], other[foreign], chord[foreign]
        at = boundary.corners[corner[end]]
        s = boundary.foot(at, other, chords.s[chord] + chords.step[chord] / 2, NEWTON_STEPS)
        away = np.hypot(*(boundary.points(other, boundary.wrapped(other, s)) - at).T)
        order = np.lexsort((away, end))
        first = order[np.diff(end[order], prepend=-1) > 0]
        widths, nearest = np.full(len(corner), np.inf), np.full(len(corner), -1)
        widths[end[first]], nearest[end[first]] = away[first], other[first]
        return widths, nearest

    @cached_property
    def _to_other_ends(self) -> Floats:
        """Distances (k,) of ends from the next one of their lines, if these nearly close: one gap for both ends."""
        boundary, (corner, piece) = self.boundary, self._ends
        line = -1 - boundary.ring
        one, other = pairs_of_groups(line[piece])
        later = corner[other] > corner[one]
        one, other = one[later], other[later]
        away = np.hypot(*(self.places[other] - self.places[one]).T)
        lengths = np.bincount(line[boundary.inner], boundary.lengths[boundary.inner])
        closing = away < NEARLY_CLOSED * lengths[line[piece[one]]]
        widths = np.full(len(corner), np.inf)
        np.minimum.at(widths, one[closing], away[closing])
        return widths
