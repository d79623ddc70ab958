"""Open ends of embedded lines, which leave the faces open that the lines are to part; and what closes them."""

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Integers
from bubblemesh.geometry.arrangement.bellies import NEWTON_STEPS
from bubblemesh.geometry.arrangement.crossings import ChordBoxes, chord_boxes
from bubblemesh.geometry.arrangement.walks import EnclosedFaces
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.paths import OpenPath
from bubblemesh.messages import just_above, place
from bubblemesh.records import Uncached, record

FAR = 0.1  # of the domain's size: ends that are farther from all else are left out
HARDLY_MEANT = 1e-3  # of the domain's size: ends that are nearer to something do not end there on purpose
MOST_NAMED = 3


class Gap(NamedTuple):
    """What is between an open end of a line and the nearest thing."""

    width: float
    text: str  # where the line ends, and how far from what
    join: str | None  # the value of the key that closes it, if the line has it


@record(eq=False)
class OpenEnds(Uncached):
    """Ends, at which nothing else is, of the first so many lines, whose pieces have the ring numbers -1, -2 and so on.

    ``boundary`` has all noded pieces, ``faces`` those that bound faces.
    """

    lines: Sequence[OpenPath]
    boundary: Boundary
    faces: EnclosedFaces
    size: float  # of the domain

    def advice(self, face: int) -> str:
        """What to do about a face that is open."""
        gaps = self._gaps(face, FAR * self.size)[:MOST_NAMED]
        if not gaps:
            return "draw a line from side to side between them, or give both the same name"
        told = [gap.text + (f" (join: {gap.join} closes that)" if gap.join else "") for gap in gaps]
        return "; ".join(told)

    def notes(self, names: Mapping[int, str]) -> Iterator[str]:
        """Notes on lines with one region, by its face, on both sides, of which an end hardly ends there on purpose."""
        for face, name in names.items():
            for width, text, join in self._gaps(face, HARDLY_MEANT * self.size):
                advice = f"join: {join} closes the gap" if join else f"if {width:.2g} are missing, give the point there"
                yield f"region {name!r} is on both sides of a line: {text}: {advice}"

    def _gaps(self, face: int, reach: float) -> list[Gap]:
        """Gaps up to a width at open ends in a face, the narrowest first."""
        corner, piece, around = self._ends
        ends = zip(corner[around == face].tolist(), piece[around == face].tolist(), strict=True)
        found = (self._gap(one, own, reach) for one, own in ends)
        return sorted((gap for gap in found if gap is not None), key=lambda gap: gap.width)

    @cached_property
    def _ends(self) -> tuple[Integers, Integers, Integers]:
        """Corners (k,) of open ends, the pieces (k,) that end there, and the faces (k,) around them."""
        boundary = self.boundary
        own = boundary.inner & (-1 - boundary.ring < len(self.lines)) & ~boundary.closed
        uses = np.bincount(np.concatenate([boundary.start, boundary.end])[np.tile(~boundary.closed, 2)])
        corner = np.concatenate([boundary.start[own], boundary.end[own]])
        alone = uses[corner] == 1
        corner, piece = corner[alone], np.tile(np.flatnonzero(own), 2)[alone]
        return corner, piece, self.faces.around(boundary.corners[corner])

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
            return Gap(its_own, f"{told}, {its_own:.2g} from its other end", None)
        beside = boundary.labels[boundary.label[other[np.argmin(gaps)]]]
        join = just_above(width / line.unit) if "lines" in line.key else None
        return Gap(width, f"{told}, {width:.2g} from {beside!r}", join)

    def _to_other_end(self, corner: int, ring: int) -> float:
        """Distance of an open end from the other one of the same line, if that is open too."""
        corners, pieces, _ = self._ends
        others = corners[(self.boundary.ring[pieces] == ring) & (corners != corner)]
        away = self.boundary.corners[others] - self.boundary.corners[corner]
        return float(np.hypot(*away.T).min(initial=np.inf))
