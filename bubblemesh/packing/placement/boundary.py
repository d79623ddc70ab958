"""Boundary bubbles in equal parts of the integral of ds / d."""

import numpy as np

from bubblemesh.arrays import GAUSS, Floats, Integers, members
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.periodic import counterparts
from bubblemesh.spacing.rules.periodic import finer_of_both_sides
from bubblemesh.spacing.rules.sources import short_intervals
from bubblemesh.spacing.spacing import Spacing

FEWEST_ON_A_CLOSED_CURVE = 3


def equidistributed(domain: Domain, spacing: Spacing) -> tuple[Integers, Floats]:
    """Pieces (m,) and arc lengths (m,) that divide each boundary piece equally in the integral of ds / d.

    A piece gets as many intervals as the integral says, to the nearest whole number and at least one.
    """
    boundary = domain.boundary
    piece, begin, length = short_intervals(domain, spacing)
    weight = length / 2 * sum(1 / finer_of_both_sides(domain, spacing, piece, begin + t * length) for t in GAUSS)
    total = np.bincount(piece, weight, minlength=len(boundary.lengths))
    fewest = np.where(boundary.closed, FEWEST_ON_A_CLOSED_CURVE, 1)
    intervals = np.maximum(np.rint(total).astype(np.int64), fewest)
    # A closed curve has a bubble at its start, an open piece a corner.
    count = np.where(boundary.closed, intervals, intervals - 1)
    owner, rank = members(count)
    rank = rank + ~boundary.closed[owner]
    before = np.cumsum(total) - total
    target = before[owner] + total[owner] * rank / intervals[owner]
    reached = np.cumsum(weight)
    last = np.searchsorted(piece, np.arange(len(count)), side="right") - 1
    panel = np.minimum(np.searchsorted(reached, target, side="right"), last[owner])
    share = (target - (reached - weight)[panel]) / weight[panel]
    # Sums over all pieces round: what should be a panel of this piece may come out as the end of the one before.
    s = np.where(piece[panel] == owner, begin[panel] + share * length[panel], 0.0)
    return _mirrored(domain, owner, boundary.wrapped(owner, s))


def _mirrored(domain: Domain, piece: Integers, s: Floats) -> tuple[Integers, Floats]:
    """Pieces and arc lengths with those of periodic sides taken from their counterparts, which run the other way."""
    pairs = domain.periodic
    if len(pairs) == 0:
        return piece, s
    own = ~np.isin(piece, pairs[:, 1])
    piece, s = piece[own], s[own]
    _, other, at = counterparts(domain.boundary, pairs, piece, s)
    piece, s = np.append(piece, other), np.append(s, at)
    order = np.lexsort((s, piece))
    return piece[order], s[order]
