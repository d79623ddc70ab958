"""The spacing that a case asks for: its terms, bound to its domain."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bubblemesh.case import Case
from bubblemesh.case.spacing import SpacingTerms
from bubblemesh.geometry.domain import Domain
from bubblemesh.sampled import sampled_terms
from bubblemesh.spacing.combination import Combination, Term
from bubblemesh.spacing.expression import Expression
from bubblemesh.spacing.regional import OwnSpacing, by_region
from bubblemesh.spacing.rules import Rules
from bubblemesh.spacing.spacing import Spacing

__all__ = ["Wanted", "limits_of", "nodes_of", "rules_of", "wanted_of"]

UNLIMITED = (0.0, np.inf)
NO_RULES = Rules()


@dataclass(frozen=True)
class Wanted:
    """What is asked of a spacing.

    Attributes
    ----------
    at : callable
        The spacing at a scale, or at its own if None is given; before its rules.
    rules : Rules
    nodes : int or None
        How many nodes it is to be scaled for.
    """

    at: Callable[[float | None], Spacing]
    rules: Rules = NO_RULES
    nodes: int | None = None


def wanted_of(case: Case, domain: Domain) -> Wanted:
    """The case's spacing, those of its regions within these."""
    terms = _mapping(case)
    found = tuple(_terms(terms, case, domain))
    made: dict[float | str, Term] = {}
    finer = {
        model.name: (made.setdefault(model.spacing, _value(model.spacing, case)), f"domain.regions.{number}.spacing")
        for number, model in enumerate(case.domain.regions)
        if model.spacing is not None
    }
    own = [(region, *finer[region.name]) for region in domain.parts.regions if region.name in finer]

    def at(scale: float | None) -> Spacing:
        factor = 1.0 if scale is None else scale / terms.scale
        base = Spacing(_combined(found, factor * terms.scale, limits_of(case)))
        scaled = {value: Spacing(_combined((value,), factor)) for value in made.values()}
        return by_region(base, [OwnSpacing(region, scaled[value], key) for region, value, key in own])

    return Wanted(at, rules_of(case), terms.nodes)


def nodes_of(case: Case) -> int | None:
    """How many nodes the case's spacing is to be scaled for."""
    return _mapping(case).nodes


def limits_of(case: Case) -> tuple[float, float]:
    """The least and the largest value of the case's spacing."""
    terms = _mapping(case)
    return terms.minimum or 0.0, np.inf if terms.maximum is None else terms.maximum


def rules_of(case: Case) -> Rules:
    """What the case's spacing has to respect."""
    terms = _mapping(case)
    return Rules(terms.growth, terms.per_circle, terms.across, terms.minimum or 0.0)


def _mapping(case: Case) -> SpacingTerms:
    return case.spacing if isinstance(case.spacing, SpacingTerms) else SpacingTerms(value=case.spacing)


def _combined(terms: tuple[Term, ...], scale: float, limits: tuple[float, float] = UNLIMITED) -> Term:
    """The terms as one; a single one without limits as it is, since it is evaluated very often."""
    plain = len(terms) == 1 and (scale, limits) == (1.0, UNLIMITED)
    return terms[0] if plain else Combination(terms, scale, *limits)


def _terms(terms: SpacingTerms, case: Case, domain: Domain) -> list[Term]:
    found: list[Term] = []
    if terms.value is not None:
        found.append(_value(terms.value, case))
    return [*found, *sampled_terms(terms)]


def _value(value: float | str, case: Case) -> Term:
    return Expression.parse(str(value), case.parameters)
