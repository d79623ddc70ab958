"""Rules that a wanted spacing follows beyond its values at points: what the boundary needs, and how fast it grows."""

from dataclasses import dataclass

import numpy as np

from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.gaps import Gaps, gaps
from bubblemesh.spacing.grading import GROWTH, Graded, graded
from bubblemesh.spacing.panels import panels
from bubblemesh.spacing.refinement import Sources, coarse_curves, short_pieces
from bubblemesh.spacing.spacing import Spacing

__all__ = ["Rules", "resolving_gaps"]

PROBINGS = 2  # for gaps: the second at the finer spacing that the first one leads to


@dataclass(frozen=True)
class Rules:
    """What a spacing has to respect.

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

    def __call__(self, domain: Domain, spacing: Spacing) -> Graded:
        """The largest spacing below the given one that follows the rules."""
        if (self.growth, self.per_circle, self.across) == (None, None, None):
            return Graded(spacing)
        growth, sources = GROWTH if self.growth is None else self.growth, Sources.none()
        if self.growth is not None:
            # What the boundary makes fine in any case would otherwise grow faster from there.
            sources = short_pieces(domain, spacing).joined(coarse_curves(domain, spacing))
        if self.per_circle is not None:
            sources = sources.joined(coarse_curves(domain, spacing, 2 * np.pi / self.per_circle))
        sources = sources.not_below(self.minimum)
        if self.across is None:
            return graded(domain, spacing, growth, sources)
        return resolving_gaps(domain, spacing, growth, self.across, sources, self.minimum)


def resolving_gaps(
    domain: Domain, spacing: Spacing, growth: float, across: float, sources: Sources, minimum: float = 0.0
) -> Graded:
    """The spacing, finer where fewer than ``across`` of it fit between two walls, but not below a ``minimum``.

    It grows by at most ``growth`` per length from there, and from the sources.
    """
    result = graded(domain, spacing, growth, sources)
    for _ in range(PROBINGS):
        piece, begin, length = panels(domain, result.spacing)
        s = begin + length / 2
        found = gaps(domain, piece, s, across * result.spacing(domain.boundary.points(piece, s)))
        if len(found.places) == 0:
            break
        sources = sources.joined(_filling(found, across).not_below(minimum))
        result = graded(domain, spacing, growth, sources)
    return result


def _filling(found: Gaps, across: float) -> Sources:
    """Sources from one wall of the gaps to the other, as far apart as their sizes."""
    parts = int(np.ceil(across))
    share = (np.arange(parts) / parts)[:, None, None]
    ways = found.places + share * (found.feet - found.places)
    return Sources(ways.reshape(-1, 2), np.tile(found.widths / across, parts))
