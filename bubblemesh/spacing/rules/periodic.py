"""Spacing beside periodic sides: the finer one of both sides counts, and grows from there into the domain."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.periodic import counterparts
from bubblemesh.spacing.rules.grading import GROWTH, Graded, graded, packable
from bubblemesh.spacing.rules.sources import Sources, panels
from bubblemesh.spacing.spacing import Spacing

ALIKE = 0.1  # relative difference of the spacings of both sides that is none: grading is no more exact
PASSES = 10  # across the sides: what comes in through one of them may leave through another one


def finest(domain: Domain, spacing: Spacing, piece: Integers, s: Floats) -> Floats:
    """Spacing (k,) on pieces (k,) of the boundary at arc lengths s (k,), on periodic sides the finer one of both."""
    d = spacing(domain.boundary.points(piece, s))
    if len(domain.periodic):
        mine, other, at = counterparts(domain.boundary, domain.periodic, piece, s)
        d[mine] = np.minimum(d[mine], spacing(domain.boundary.points(other, at)))
    return d


def across_sides(domain: Domain, ruled: Graded) -> Graded:
    """A spacing that has followed its rules, finer beside periodic sides where their counterparts are, if they are."""
    sources = _finer_opposite(domain, ruled.spacing)
    if len(sources) == 0:
        return ruled
    growth = GROWTH if ruled.growth is None else ruled.growth
    tied = _settled(domain, ruled, sources, lambda ruled, sources: graded(domain, ruled.spacing, growth, sources))
    return tied if ruled.growth is None else replace(tied, steepest=ruled.steepest)


def packable_across(domain: Domain, ruled: Graded, sources: Sources) -> Graded:
    """The spacing, made `packable`, also across periodic sides."""
    return _settled(domain, ruled, sources, partial(packable, domain))


def _settled(domain: Domain, ruled: Graded, sources: Sources, grade: Callable[[Graded, Sources], Graded]) -> Graded:
    """What grading leads to from the sources, and from what they make fine across the sides."""
    result, before = grade(ruled, sources), Sources.none()
    for _ in range(PASSES if result is not ruled else 0):
        more = _finer_opposite(domain, result.spacing)
        if len(more) == 0 or np.array_equal(more.points, before.points):  # told in vain
            break
        sources, before = sources.joined(more), more
        result = grade(ruled, sources)
    return result


def _finer_opposite(domain: Domain, spacing: Spacing) -> Sources:
    """The spacings of periodic sides, at their counterparts where these are coarser."""
    if len(domain.periodic) == 0:
        return Sources.none()
    piece, begin, length = panels(domain, spacing)
    s = begin + length / 2
    mine, other, at = counterparts(domain.boundary, domain.periodic, piece, s)
    d, opposite = spacing(domain.boundary.points(piece[mine], s[mine])), domain.boundary.points(other, at)
    finer = d < (1 - ALIKE) * spacing(opposite)
    return Sources(opposite[finer], d[finer])
