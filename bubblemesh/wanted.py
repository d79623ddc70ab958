"""The spacing that a case asks for: its terms, bound to its domain."""

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

__all__ = ["rules_of", "wanted_of"]


def wanted_of(case: Case, domain: Domain) -> Spacing:
    """The case's spacing, those of its regions within these, before its rules."""
    terms = case.spacing if isinstance(case.spacing, SpacingTerms) else SpacingTerms(value=case.spacing)
    base = Spacing(_combined(terms, case, domain))
    made: dict[float | str, Spacing] = {}
    finer = {
        model.name: (made.setdefault(model.spacing, Spacing(_value(model.spacing, case))), number)
        for number, model in enumerate(case.domain.regions)
        if model.spacing is not None
    }
    own = [
        OwnSpacing(region, finer[region.name][0], f"domain.regions.{finer[region.name][1]}.spacing")
        for region in domain.parts.regions
        if region.name in finer
    ]
    return by_region(base, own)


def rules_of(case: Case) -> Rules:
    """What the case's spacing has to respect."""
    if not isinstance(case.spacing, SpacingTerms):
        return Rules()
    terms = case.spacing
    return Rules(terms.growth, terms.per_circle, terms.across, terms.minimum or 0.0)


def _combined(terms: SpacingTerms, case: Case, domain: Domain) -> Term:
    """The terms as one; a single one without limits as it is, since it is evaluated very often."""
    found = tuple(_terms(terms, case, domain))
    limits = terms.scale, terms.minimum or 0.0, np.inf if terms.maximum is None else terms.maximum
    return found[0] if len(found) == 1 and limits == (1.0, 0.0, np.inf) else Combination(found, *limits)


def _terms(terms: SpacingTerms, case: Case, domain: Domain) -> list[Term]:
    found: list[Term] = []
    if terms.value is not None:
        found.append(_value(terms.value, case))
    return [*found, *sampled_terms(terms)]


def _value(value: float | str, case: Case) -> Term:
    return Expression.parse(str(value), case.parameters)
