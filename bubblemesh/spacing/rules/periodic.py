"""Spacing beside periodic sides: the finer one of both sides counts, and grows from there into the domain."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.periodic import counterparts
from bubblemesh.spacing.rules.grading import STEEPEST_GROWTH, LimitedSpacing, gradient_limited, limited_for_packing
from bubblemesh.spacing.rules.sources import Sources, short_intervals
from bubblemesh.spacing.spacing import Spacing

ALIKE = 0.1  # relative difference of the spacings of both sides that is none: grading is no more exact
PASSES = 10  # across the sides: what comes in through one of them may leave through another one


def finer_of_both_sides(domain: Domain, spacing: Spacing, piece: Integers, s: Floats) -> Floats:
    """Spacing (k,) on pieces (k,) of the boundary at arc lengths s (k,), on periodic sides the finer one of both."""
    d = spacing(domain.boundary.points(piece, s))
    if len(domain.periodic):
        mine, other, at = counterparts(domain.boundary, domain.periodic, piece, s)
        d[mine] = np.minimum(d[mine], spacing(domain.boundary.points(other, at)))
    return d


def limited_across_sides(domain: Domain, after_rules: LimitedSpacing) -> LimitedSpacing:
    """The spacing after its rules, finer beside periodic sides where their counterparts are, if they are."""
    sources = _finer_opposite(domain, after_rules.spacing)
    if len(sources) == 0:
        return after_rules
    growth = STEEPEST_GROWTH if after_rules.growth is None else after_rules.growth
    found = _settled(
        domain, after_rules, sources, lambda before, s: gradient_limited(domain, before.spacing, growth, s)
    )
    return found if after_rules.growth is None else replace(found, steepest=after_rules.steepest)


def limited_for_packing_across_sides(domain: Domain, before: LimitedSpacing, sources: Sources) -> LimitedSpacing:
    """The spacing, `limited_for_packing` also across periodic sides."""
    return _settled(domain, before, sources, partial(limited_for_packing, domain))


def _settled(
    domain: Domain,
    before: LimitedSpacing,
    sources: Sources,
    limited: Callable[[LimitedSpacing, Sources], LimitedSpacing],
) -> LimitedSpacing:
    """The spacing ``limited`` by the sources, and by what they make fine across the sides."""
    result, told = limited(before, sources), Sources.none()
    for _ in range(PASSES if result is not before else 0):
        more = _finer_opposite(domain, result.spacing)
        if len(more) == 0 or np.array_equal(more.points, told.points):  # told in vain
            break
        sources, told = sources.joined(more), more
        result = limited(before, sources)
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
