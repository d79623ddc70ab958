"""Landings: cuts meet walls and lines at bubbles that are there without any cut, as far as a straight line can.

They meet other cuts where these are met from their other side, if that is near: two ends close to each other would be
bubbles too near to each other.
"""

from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers, each_once
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.net import unconnected
from bubblemesh.packing.placement.diffusion import boundary_bubbles
from bubblemesh.packing.population import SHARP_CORNER
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing

REACH = 1.0  # spacings from a crossing to a bubble that it may move to
REACH_OF_ENDS = 4.0  # the same to the end of a cut
MOST = 12  # crossings that count: those where the bubbles are smallest
TURN = 0.05  # most by which a cut is turned, as a slope
HALF = 0.5  # spacings: from a crossing between two bubbles to these
ON = 1e-9  # spacings: a line runs through a bubble, but for rounding


class Landing(NamedTuple):
    """A line through bubbles."""

    through: Floats  # (k, 2): the bubbles
    slope: float  # by which it is turned to the left


class _Spots(NamedTuple):
    """Bubbles that crossings may move to, in the line's own directions."""

    bubble: Integers  # (m,): their numbers
    along: Floats  # (m,)
    off: Floats  # (m,): to the left of the line
    d: Floats  # (m,): spacings there
    crossing: Integers  # (m,): number of the crossing, from 0 on


@record
class Landings:
    """Bubbles on walls and lines, but for those at sharp corners, and ends of cuts on others."""

    x: Floats  # (n, 2)
    d: Floats  # (n,): spacing there
    reach: Floats  # (n,): from how far a crossing may move there

    @classmethod
    def of(cls, domain: Domain, spacing: Spacing) -> "Landings":
        """The bubbles of a domain that is not cut."""
        shell = unconnected(boundary_bubbles(domain, spacing), domain)
        smooth = shell.turns < SHARP_CORNER
        x, d = shell.bubbles.x[smooth], shell.bubbles.d[smooth]
        return cls(x, d, REACH * d)

    def with_ends(self, x: Floats, d: Floats) -> "Landings":
        """These and ends of cuts at x (k, 2), where the spacings are d (k,)."""
        parts = zip((self.x, self.d, self.reach), (x, d, REACH_OF_ENDS * d), strict=True)
        return Landings(*(np.concatenate(both) for both in parts))

    def near(self, at: Floats, way: Floats, crossings: Floats) -> Landing | None:
        """The line near to one through ``at`` (2,) in the direction of a unit vector (2,) that lands best.

        That is, whose crossings (k, 2) with walls and lines are nearest to bubbles; None if there are none near.
        """
        spots = self._spots(at, way, crossings)
        if len(spots.off) == 0:
            return None
        first, slope = _lines(spots)
        off = spots.off - spots.off[first, None] - slope[:, None] * (spots.along - spots.along[first, None])
        missed = np.minimum(np.abs(off) / spots.d, HALF)
        begin = np.flatnonzero(np.diff(spots.crossing, prepend=-1))
        best = int(np.minimum.reduceat(missed, begin, axis=1).sum(axis=1).argmin())
        return Landing(self.x[each_once(spots.bubble[missed[best] <= ON])], float(slope[best]))

    def _spots(self, at: Floats, way: Floats, crossings: Floats) -> _Spots:
        off = (self.x - at) @ (-way[1], way[0])
        near = np.flatnonzero(np.abs(off) <= self.reach)
        x, d = self.x[near], self.d[near]
        beside = np.hypot(*(crossings[:, None] - x).transpose(2, 0, 1)) <= self.reach[near]
        smallest = np.where(beside, d, np.inf).min(axis=1, initial=np.inf)
        crossing, spot = np.nonzero(beside[np.sort(np.argsort(smallest, kind="stable")[:MOST])])
        return _Spots(near[spot], (x[spot] - at) @ way, off[near[spot]], d[spot], crossing)


def _lines(spots: _Spots) -> tuple[Integers, Floats]:
    """Lines through a spot each (c,), and their slopes (c,): parallel ones, and those through a second spot."""
    i, j = np.nonzero(spots.crossing[:, None] < spots.crossing)
    along, off = spots.along[j] - spots.along[i], spots.off[j] - spots.off[i]
    gentle = np.abs(off) < TURN * np.abs(along)
    alone = np.arange(len(spots.off))
    slope = np.append(np.zeros(len(alone)), off[gentle] / along[gentle])
    return np.append(alone, i[gentle]), slope
