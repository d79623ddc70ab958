"""Rules that a spacing follows beyond its values at points: what the boundary needs, growth, and periodic sides.

Of periodic sides the finer one counts on both, and the spacing grows from there into the domain.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.narrow_parts import FacingWalls
from bubblemesh.geometry.periodic import counterparts
from bubblemesh.records import record
from bubblemesh.spacing.rules.gap_sources import POOR, GapSources, NarrowPlace
from bubblemesh.spacing.rules.grading import (
    STEEPEST_GROWTH,
    Ground,
    LimitedSpacing,
    compared,
    gradient_limited,
    limited_for_packing,
)
from bubblemesh.spacing.rules.sources import Sources, coarse_curves, curvature_sources, short_intervals, short_pieces
from bubblemesh.spacing.spacing import Spacing

ALIKE = 0.1  # relative difference of the spacings of both sides that counts as none: grading is no more exact
ACROSS = 1.0  # spacings across narrow parts where no other number is asked for
PASSES = 10  # across the sides: what comes in through one of them may leave through another one


@record
class Rules:
    """Rules that a spacing follows."""

    growth: float | None = None  # largest one per length, from short pieces and tight curves of the boundary as well
    per_circle: float | None = None  # nodes on a full turn of curves
    across: float | None = None  # spacings across the narrowest parts of the domain; 0 leaves them as they are
    minimum: float = 0.0  # per_circle and across make the spacing nowhere finer

    @property
    def packing_growth(self) -> float:
        """Largest growth per length that a packing gets where it has to be finer than these rules make it."""
        return STEEPEST_GROWTH if self.growth is None else min(self.growth, STEEPEST_GROWTH)

    def __call__(
        self, domain: Domain, spacing: Spacing, max_nodes: float = np.inf, hidden: Floats | None = None
    ) -> LimitedSpacing:
        """The largest spacing below the given one that follows the rules, with the ground of what is given.

        Pieces of the boundary that are ``hidden``, as of `short_pieces`, do not make it finer by being short or curved.
        LimitError if curves or narrow parts alone need more than ``max_nodes`` nodes, with the key and the place.
        """
        if self.growth is None and self.per_circle is None and not self.across:
            return LimitedSpacing(spacing)
        growth, sources = STEEPEST_GROWTH if self.growth is None else self.growth, Sources.none()
        if self.growth is not None:
            # What the boundary makes fine in any case would otherwise grow faster from there.
            sources = short_pieces(domain, spacing, hidden).joined(coarse_curves(domain, spacing, hidden))
        if self.per_circle is not None:
            curves = curvature_sources(domain, spacing, self.per_circle, growth, self.minimum, max_nodes, hidden)
            sources = sources.joined(curves)
        sources = sources.not_below(self.minimum)
        if self.across:
            gaps = GapSources(self.across, self.packing_growth, self._least, max_nodes)
            sources = sources.joined(gaps(domain, spacing))
        return gradient_limited(domain, spacing, growth, sources)

    def affordable_gaps(
        self, walls: FacingWalls, spacing: Spacing, requested: Spacing, max_nodes: float
    ) -> tuple[Sources, NarrowPlace | None]:
        """Sources by which one spacing fits across narrow parts, unless the rules have an ``across`` of their own.

        Narrow are parts that are so beside the spacing, and beside the ``requested`` one in the direction across them.
        Parts are left out, the narrowest first, that take more than ``max_nodes`` nodes; the narrowest one comes out.
        """
        if self.across is not None:
            return Sources.none(), None
        return GapSources(ACROSS, self.packing_growth, self._least, max_nodes, POOR, requested).affordable(
            walls, spacing
        )

    def _least(self, points: Floats) -> Floats:
        return np.full(len(points), self.minimum)


def finer_of_both_sides(domain: Domain, spacing: Spacing, piece: Integers, s: Floats) -> Floats:
    """Spacing (k,) on pieces (k,) of the boundary at arc lengths s (k,), on periodic sides the finer one of both."""
    d = spacing.along(domain.boundary, piece, s)
    if len(domain.periodic):
        mine, other, at = counterparts(domain.boundary, domain.periodic, piece, s)
        d[mine] = np.minimum(d[mine], spacing.along(domain.boundary, other, at))
    return d


def limited_across_sides(
    domain: Domain, given: Spacing, after_rules: LimitedSpacing, ground: Ground | None
) -> LimitedSpacing:
    """The spacing after its rules, finer beside periodic sides where their counterparts are, if they are.

    With the ``ground`` of the rules, the ``given`` spacing is limited once more. The one after its rules grows as fast
    as it may: new cells would be split until they follow those in which it is interpolated.
    """
    sources = _finer_opposite(domain, after_rules.spacing)
    if len(sources) == 0:
        return after_rules
    growth = STEEPEST_GROWTH if after_rules.growth is None else after_rules.growth
    before = after_rules if ground is None else LimitedSpacing(given)

    def limited(before: LimitedSpacing, sources: Sources, ground: Ground | None) -> LimitedSpacing:
        return gradient_limited(domain, before.spacing, growth, sources, ground)

    found = _settled(domain, before, sources, limited, ground)
    if ground is not None:
        found = compared(domain, found, after_rules.spacing)
    found = replace(found, ground=None)
    return found if after_rules.growth is None else replace(found, steepest=after_rules.steepest)


def limited_for_packing_across_sides(
    domain: Domain,
    before: LimitedSpacing,
    sources: Sources,
    growth: float = STEEPEST_GROWTH,
    ground: Ground | None = None,
) -> LimitedSpacing:
    """The spacing, `limited_for_packing` also across periodic sides; the sources of a ``ground`` count as well."""

    def limited(before: LimitedSpacing, sources: Sources, ground: Ground | None) -> LimitedSpacing:
        return limited_for_packing(domain, before, sources, growth, ground)

    return _settled(domain, before, sources, limited, ground)


def _settled(
    domain: Domain,
    before: LimitedSpacing,
    sources: Sources,
    limited: Callable[[LimitedSpacing, Sources, Ground | None], LimitedSpacing],
    ground: Ground | None,
) -> LimitedSpacing:
    """The spacing ``limited`` by the sources, and by what they make fine across the sides.

    It keeps the ground that is limited by the sources only, which others may share.
    """
    result, told, beside = limited(before, sources, ground), Sources.none(), Sources.none()
    ground = result.ground
    for _ in range(PASSES if result is not before else 0):
        more = _finer_opposite(domain, result.spacing)
        if len(more) == 0 or np.array_equal(more.points, told.points):  # told in vain
            break
        beside, told = beside.joined(more), more
        result = replace(limited(before, beside, ground), ground=ground)
    return result


def _finer_opposite(domain: Domain, spacing: Spacing) -> Sources:
    """The spacings of periodic sides, at their counterparts where these are coarser."""
    if len(domain.periodic) == 0:
        return Sources.none()
    piece, begin, length = short_intervals(domain, spacing)
    s = begin + length / 2
    mine, other, at = counterparts(domain.boundary, domain.periodic, piece, s)
    d, opposite = spacing(domain.boundary.points(piece[mine], s[mine])), domain.boundary.points(other, at)
    finer = d < (1 - ALIKE) * spacing(opposite)
    return Sources(opposite[finer], d[finer])
