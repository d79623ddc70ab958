"""Sources that make a spacing as fine as narrow parts of a domain need it."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers, members, select
from bubblemesh.errors import NODE_LIMIT, NodeLimitError
from bubblemesh.geometry.curves import turning
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.narrow_parts import NO_GAPS, FacingWalls, Gaps
from bubblemesh.messages import place
from bubblemesh.records import record
from bubblemesh.spacing.rules.sources import Sources, halved, short_intervals
from bubblemesh.spacing.spacing import Spacing

LARGEST_TURN = np.pi / 8  # of a curve between places from which gaps are looked for
NEARLY = 1 - 1e-9  # with room for rounding
NARROW = 0.95  # spacings: what is wider is not narrow
ROUNDINGS = 100  # of coordinates
POOR = 0.6  # spacings: triangles across what is wider are good as they are
# Distance of sources: so much the spacing may grow in between, and in terms of their sizes.
APART_IN_GAP, FARTHEST_IN_GAP = 0.3, 1.5
CELLS = 1.4  # largest sides of a grid's cells around them, in terms of that distance
HALFWAY = 0.5  # the other wall finds the gap too
GAP_HALVINGS = 40


def size_across(gaps: Gaps, spacing: Spacing) -> Floats:
    """Spacing (k,) at gaps, in the direction across them."""
    return spacing.towards(gaps.places, gaps.feet - gaps.places)


def surely_wide(walls: FacingWalls, spacing: Spacing, times: float = 1.0) -> bool:
    """Whether bounds of a spacing prove that no gap between walls is as narrow as so many ``times`` the spacing."""
    if walls.least_width == 0:
        return False
    bounds = spacing.bounds_in(walls.domain.bounds)
    return bounds is not None and bool(np.all((bounds.low > 0) & (times * bounds.high < NEARLY * walls.least_width)))


class NarrowPlace(NamedTuple):
    """Place (x, y) where a domain is narrow, and its width there."""

    at: tuple[float, float]
    width: float


@record
class GapSources:
    """Sources that fill the narrow parts of a domain."""

    across: float  # spacings that are to fit between two walls
    growth: float  # of the spacing from the sources, per length
    least: Callable[[Floats], Floats]  # finest size (k,) that is of use at places (k, 2)
    max_nodes: float = np.inf
    narrow: float = NARROW  # parts in terms of the spacing, below which something is done
    requested: Spacing | None = None  # whose sizes across them count too, if they depend on the direction

    def __call__(self, domain: Domain, spacing: Spacing) -> Sources:
        """Sources where the spacing is too coarse.

        LimitError if they need more than ``max_nodes`` nodes, with the narrowest place.
        """
        return self._found(FacingWalls(domain), spacing, refuse=True)[0]

    def affordable(self, walls: FacingWalls, spacing: Spacing) -> tuple[Sources, NarrowPlace | None]:
        """Sources but for the narrowest parts, as far as ``max_nodes`` nodes are enough; the narrowest one left out."""
        return self._found(walls, spacing, refuse=False)

    def _found(self, walls: FacingWalls, spacing: Spacing, refuse: bool) -> tuple[Sources, NarrowPlace | None]:
        """Sources for ``max_nodes`` nodes at most, and the narrowest place left out; or ``refuse`` to leave any out."""
        if surely_wide(walls, spacing, self.across):
            return Sources.none(), None
        domain, corner = walls.domain, walls.reentrant
        d = spacing(domain.boundary.corners[corner.corner])
        found, size = self._narrow(walls.facing_corners(corner, self.across * d), d)
        done, finest, left_out = [self._sources(found, size, 1.0)], 0.0, None
        piece, begin, length = _probes(domain, spacing)
        waiting, sizes = NO_GAPS, np.zeros(0)
        for _ in range(GAP_HALVINGS):
            s = begin + length / 2
            d = spacing(domain.boundary.points(piece, s))
            found, size = self._narrow(walls.facing(piece, s, self.across * d, d), d)
            nodes = self._nodes(found, size, length[found.number])
            if nodes.sum() > self.max_nodes:
                worst = size.argmin()
                x, y = found.places[worst].tolist()
                left_out = NarrowPlace((x, y), float(found.widths[worst]))
                if refuse:
                    raise self._too_many(left_out)
                finest = max(finest, self._largest_left_out(size, nodes))
            found, size = select(found, size > finest), size[size > finest]
            # Where both halves of a part have passed by the gap that its middle has.
            seen = np.zeros(max(len(piece) // 2, 1), bool)
            seen[found.number % len(seen)] = True
            lost = ~seen[waiting.number]
            done.append(self._sources(select(waiting, lost), sizes[lost], HALFWAY))
            short = length[found.number] <= self._apart(size)
            done.append(self._sources(select(found, short), size[short], HALFWAY))
            waiting, sizes = select(found, ~short), size[~short]
            long, number = np.unique(waiting.number, return_inverse=True)
            if len(long) == 0:
                break
            waiting = waiting._replace(number=number)
            piece, begin, length = halved(piece[long], begin[long], length[long])
        sources = Sources.all_of(done)
        return (sources if left_out is None else sources.select(sources.sizes > finest)), left_out

    def _narrow(self, found: Gaps, d: Floats) -> tuple[Gaps, Floats]:
        """The gaps that are too narrow for the spacing d (m,) at the places, and the sizes (k,) that they need."""
        size = np.maximum(found.widths / self.across, self.least(found.places))
        rounding = ROUNDINGS * np.spacing(np.abs(found.places).max(initial=0.0))  # walls that touch are no gap
        narrow = (size < self.narrow * d[found.number]) & (size > rounding)
        found, size = select(found, narrow), size[narrow]
        if self.requested is not None and self.requested.in_metric:
            narrow = size < self.narrow * size_across(found, self.requested)
            found, size = select(found, narrow), size[narrow]
        return found, size

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

    def _nodes(self, found: Gaps, size: Floats, length: Floats) -> Floats:
        """Nodes (k,) that gaps need at least, on parts of walls of that length (k,).

        Away from the middle of a part the spacing may grow. Both walls of a gap find it, and two gaps may cross.
        """
        nodes: Floats = found.widths * length / (size * (size + self.growth * length / 2)) / np.sqrt(3) / 2
        return nodes

    def _too_many(self, narrowest: NarrowPlace) -> NodeLimitError:
        """The error that gaps need too many nodes, with the narrowest one."""
        return NodeLimitError(
            f"{NODE_LIMIT}: spacing.across asks for more than the limit of {self.max_nodes} nodes: the part at "
            f"{place(narrowest.at)} is only {narrowest.width:.3g} wide: set spacing.minimum or raise the limit"
        )

    def _largest_left_out(self, size: Floats, nodes: Floats) -> float:
        """The largest size of gaps that are left out, so that the nodes (k,) of the wider ones are few enough."""
        order = np.argsort(-size)
        return float(size[order][np.argmax(np.cumsum(nodes[order]) > self.max_nodes)])


def _probes(domain: Domain, spacing: Spacing) -> tuple[Integers, Floats, Floats]:
    """Piece, begin and length (k,) of parts of all lines that are short beside the spacing, and hardly bent."""
    boundary = domain.boundary
    piece, begin, _ = short_intervals(domain, spacing)
    chord_piece, s, step = boundary.stations()
    turn, bent = np.zeros(len(s)), boundary.curved[chord_piece]
    ends = (boundary.tangents(chord_piece[bent], at) for at in (s[bent], (s + step)[bent]))
    turn[bent] = np.abs(turning(*ends))
    turns = np.diff(np.floor(np.cumsum(turn) / LARGEST_TURN), prepend=0) > 0
    piece, begin = np.append(piece, chord_piece[turns]), np.append(begin, s[turns])
    order = np.lexsort((begin, piece))
    piece, begin = piece[order], begin[order]
    end = np.where(np.diff(piece, append=-1) == 0, np.append(begin[1:], 0), boundary.lengths[piece])
    some = end > begin
    return piece[some], begin[some], (end - begin)[some]
