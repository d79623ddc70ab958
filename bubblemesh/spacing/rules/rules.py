"""Rules that a spacing follows beyond its values at points: what the boundary needs, and how fast it grows."""

from dataclasses import dataclass

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.geometry.domain import Domain
from bubblemesh.spacing.rules.gap_sources import GapSources
from bubblemesh.spacing.rules.grading import STEEPEST_GROWTH, LimitedSpacing, gradient_limited
from bubblemesh.spacing.rules.sources import Sources, coarse_curves, curvature_sources, short_pieces
from bubblemesh.spacing.spacing import Spacing


@dataclass(frozen=True)
class Rules:
    """Rules that a spacing follows.

    Attributes
    ----------
    growth : float or None
        Largest growth per length, from short pieces and tight curves of the boundary on as well.
    per_circle : float or None
        Nodes on a full turn of the boundary's curves.
    across : float or None
        Spacings across the narrowest parts of the domain.
    minimum : float
        The last two make the spacing nowhere finer.
    """

    growth: float | None = None
    per_circle: float | None = None
    across: float | None = None
    minimum: float = 0.0

    def __call__(self, domain: Domain, spacing: Spacing, max_nodes: float = np.inf) -> LimitedSpacing:
        """The largest spacing below the given one that follows the rules.

        Raises
        ------
        LimitError
            If curves or narrow parts alone need more than ``max_nodes`` nodes, with the key and the place.
        """
        if self == Rules(minimum=self.minimum):
            return LimitedSpacing(spacing)
        growth, sources = STEEPEST_GROWTH if self.growth is None else self.growth, Sources.none()
        if self.growth is not None:
            # What the boundary makes fine in any case would otherwise grow faster from there.
            sources = short_pieces(domain, spacing).joined(coarse_curves(domain, spacing))
        if self.per_circle is not None:
            curves = curvature_sources(domain, spacing, self.per_circle, growth, self.minimum, max_nodes)
            sources = sources.joined(curves)
        sources = sources.not_below(self.minimum)
        if self.across is not None:
            gaps = GapSources(self.across, min(growth, STEEPEST_GROWTH), self._least, max_nodes)
            sources = sources.joined(gaps(domain, spacing))
        return gradient_limited(domain, spacing, growth, sources)

    def _least(self, points: Floats) -> Floats:
        return np.full(len(points), self.minimum)
