"""Sources that make a spacing as fine as narrow parts of a domain need it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bubblemesh.arrays import Floats, Integers, members, select
from bubblemesh.errors import LimitError
from bubblemesh.geometry.curves import turning
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.narrow_parts import Gaps, Walls, reentrant_corners
from bubblemesh.messages import place
from bubblemesh.spacing.rules.sources import Sources, halved, short_intervals
from bubblemesh.spacing.spacing import Spacing

LARGEST_TURN = np.pi / 8  # of a curve between places from which gaps are looked for
NARROW = 0.95  # spacings are not narrower than what is wanted
APART_IN_GAP, FARTHEST_IN_GAP = (
    0.3,
    1.5,
)  # distance of sources: so much the spacing may grow in between; in terms of their sizes
CELLS = 1.4  # largest sides of a grid's cells around them, in terms of that distance
HALFWAY = 0.5  # the other wall finds the gap too
HALVINGS = 40
NO_GAPS = Gaps(np.zeros(0, np.int64), np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0), np.zeros(0, bool))


@dataclass(frozen=True)
class GapSources:
    """Sources that fill the narrow parts of a domain."""

    across: float  # spacings that are to fit between two walls
    growth: float  # of the spacing from the sources, per length
    least: Callable[[Floats], Floats]  # finest size (k,) that is of use at places (k, 2)
    max_nodes: float = np.inf

    def __call__(self, domain: Domain, spacing: Spacing) -> Sources:
        """Sources where the spacing is too coarse.

        LimitError if they need more than ``max_nodes`` nodes, with the narrowest place.
        """
        walls, corner = Walls(domain), reentrant_corners(domain)
        d = spacing(domain.boundary.corners[corner.corner])
        found, size = self._narrow(walls.facing_corners(corner, self.across * d), d)
        done = [self._sources(found, size, 1.0)]
        piece, begin, length = _probes(domain, spacing)
        waiting, sizes = NO_GAPS, np.zeros(0)
        for _ in range(HALVINGS):
            s = begin + length / 2
            d = spacing(domain.boundary.points(piece, s))
            found, size = self._narrow(walls.facing(piece, s, self.across * d, d), d)
            self._require_few(found, size, length[found.number])
            # Where both halves of a part have passed by the gap that its middle has.
            lost = ~np.isin(waiting.number, found.number % max(len(piece) // 2, 1))
            done.append(self._sources(select(waiting, lost), sizes[lost], HALFWAY))
            short = length[found.number] <= self._apart(size)
            done.append(self._sources(select(found, short), size[short], HALFWAY))
            waiting, sizes = select(found, ~short), size[~short]
            long, number = np.unique(waiting.number, return_inverse=True)
            if len(long) == 0:
                break
            waiting = waiting._replace(number=number)
            piece, begin, length = halved(piece[long], begin[long], length[long])
        return Sources.all_of(done)

    def _narrow(self, found: Gaps, d: Floats) -> tuple[Gaps, Floats]:
        """The gaps that are too narrow for the spacing d (m,) at the places, and the sizes (k,) that they need."""
        size = np.maximum(found.widths / self.across, self.least(found.places))
        narrow = size < NARROW * d[found.number]
        return select(found, narrow), size[narrow]

    def _apart(self, size: Floats) -> Floats:
        """Distance (k,) of sources on both walls of the gaps, and between these."""
        return min(APART_IN_GAP / self.growth, FARTHEST_IN_GAP) * size

    def _sources(self, found: Gaps, size: Floats, far: float) -> Sources:
        """Sources on the ways across the gaps, up to a part of these."""
        apart = self._apart(size)
        parts = np.ceil(far * found.widths / apart).astype(np.int64)
        way, number = members(parts + 1)
        share = far * number / parts[way]
        points = found.places[way] + share[:, None] * (found.feet - found.places)[way]
        return Sources(points, size[way], CELLS * apart[way])

    def _require_few(self, found: Gaps, size: Floats, length: Floats) -> None:
        """Refuse gaps that need too many nodes, on parts of walls of that length (k,).

        Away from the middle of a part the spacing may grow. Both walls of a gap find it, and two gaps may cross.
        """
        nodes = found.widths * length / (size * (size + self.growth * length / 2)) / np.sqrt(3) / 2
        if nodes.sum() > self.max_nodes:
            worst = size.argmin()
            raise LimitError(
                f"limits.max_nodes: spacing.across asks for more than the limit of {self.max_nodes} nodes: the part at "
                f"{place(found.places[worst])} is only {found.widths[worst]:.3g} wide: set spacing.minimum or raise "
                "the limit"
            )


def _probes(domain: Domain, spacing: Spacing) -> tuple[Integers, Floats, Floats]:
    """Piece, begin and length (k,) of parts of all lines that are short beside the spacing, and hardly bent."""
    boundary = domain.boundary
    piece, begin, _ = short_intervals(domain, spacing)
    chord_piece, s, step = boundary.stations()
    turn = np.abs(turning(boundary.tangents(chord_piece, s), boundary.tangents(chord_piece, s + step)))
    turns = np.diff(np.floor(np.cumsum(turn) / LARGEST_TURN), prepend=0) > 0
    piece, begin = np.append(piece, chord_piece[turns]), np.append(begin, s[turns])
    order = np.lexsort((begin, piece))
    piece, begin = piece[order], begin[order]
    end = np.where(np.diff(piece, append=-1) == 0, np.append(begin[1:], 0), boundary.lengths[piece])
    some = end > begin
    return piece[some], begin[some], (end - begin)[some]
