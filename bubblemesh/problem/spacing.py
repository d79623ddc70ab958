"""The spacing that a case asks for: its terms, bound to its domain."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import shapely

from bubblemesh.arrays import Floats
from bubblemesh.case import Case
from bubblemesh.case.data_terms import several
from bubblemesh.case.spacing import NearLabel, NearPoint, NearTerm, SpacingTerms
from bubblemesh.errors import CaseError, Key, at_key
from bubblemesh.geometry.distance.to_labels import Distance, distance_to, distance_to_line
from bubblemesh.geometry.domain import Domain
from bubblemesh.messages import unknown
from bubblemesh.problem.data_terms import data_functions, elsewhere
from bubblemesh.spacing.expression import Expression
from bubblemesh.spacing.rules.rules import Rules
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.terms.combination import Combination, costly, nothing
from bubblemesh.spacing.terms.near import NEAR_GROWTH, Proximities, Proximity
from bubblemesh.spacing.terms.regions import RegionSpacing, RegionTerm, ShapeUnion, by_region

UNLIMITED = (0.0, np.inf)
NO_RULES = Rules()
APART = 1 / 500  # of the domain's size: points of a line that are looked at


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
    warnings : tuple of str
        What may not be meant so.
    """

    at: Callable[[float | None], Spacing]
    rules: Rules = NO_RULES
    nodes: int | None = None
    warnings: tuple[str, ...] = ()


def wanted_of(case: Case, domain: Domain) -> Wanted:
    """The case's spacing.

    Raises
    ------
    CaseError
        If a term names a label or a region that is not there; with the key.
    """
    terms, value = _mapping(case), _value(case, domain)
    limits, near, functions = _limits_within(terms, case, domain), _near(terms, domain), data_functions(terms)
    found = value, *limits, *near, *(Spacing(data, key=_always(key)) for key, data in functions.items())
    spots = np.vstack([*_spots(terms, domain), *(data.spots for data in functions.values())])
    astray = filter(None, (elsewhere(key, data, domain.bounds) for key, data in functions.items()))
    return Wanted(within_limits(case, found, spots, terms.scale), rules_of(case), terms.nodes, tuple(astray))


def within_limits(
    case: Case, terms: tuple[Spacing, ...], spots: Floats, own_scale: float = 1.0
) -> Callable[[float | None], Spacing]:
    """The smallest of terms at a scale, or else their own, within the case's limits; fine near spots (k, 2)."""
    limits = _limits(case)

    def at(scale: float | None) -> Spacing:
        return replace(_combined(terms, own_scale if scale is None else scale, limits), spots=spots)

    return at


def nodes_of(case: Case) -> int | None:
    """How many nodes the case's spacing is to be scaled for."""
    return _mapping(case).nodes


def _limits(case: Case) -> tuple[float, float]:
    """The least and the largest value of the case's spacing."""
    terms = _mapping(case)
    return terms.minimum or 0.0, np.inf if terms.maximum is None else terms.maximum


def rules_of(case: Case) -> Rules:
    """What the case's spacing has to respect."""
    terms = _mapping(case)
    return Rules(terms.growth, terms.per_circle, terms.across, terms.minimum or 0.0)


def _mapping(case: Case) -> SpacingTerms:
    return case.spacing if isinstance(case.spacing, SpacingTerms) else SpacingTerms(value=case.spacing)


def _combined(terms: tuple[Spacing, ...], scale: float, limits: tuple[float, float]) -> Spacing:
    """The terms as one; a single one without limits as it is, since it is evaluated very often."""
    if len(terms) == 1 and (scale, limits) == (1.0, UNLIMITED):
        return terms[0]
    combination = Combination(terms, scale, *limits)
    return Spacing(combination, key=combination.key, costly=combination.costly)


def _value(case: Case, domain: Domain) -> Spacing:
    """The value that the case gives, with those of the regions that have one of their own in its place."""
    made: dict[float | str, Spacing] = {}
    finer = {}
    for number, model in enumerate(case.domain.regions):
        if model.spacing is not None:
            path = "domain", "regions", number, "spacing"
            if model.spacing not in made:
                made[model.spacing] = _bound(model.spacing, case, domain, *path)
            finer[model.name] = made[model.spacing], Key(path)
    own = [RegionSpacing(region, *finer[region.name]) for region in domain.parts.regions if region.name in finer]
    return by_region(_rest(case, domain), own)


def _rest(case: Case, domain: Domain) -> Spacing:
    """The value where no region has one of its own."""
    if not isinstance(case.spacing, SpacingTerms):
        return _bound(case.spacing, case, domain, "spacing")
    key, value = case.spacing.basis
    return Spacing(nothing) if value is None else _bound(value, case, domain, "spacing", key)


def _near(terms: SpacingTerms, domain: Domain) -> Iterator[Spacing]:
    """What is fine near something, and grows from there: one term for all whose distance takes long."""
    found = tuple(_growing(terms, domain))
    yield from (Spacing(near) for near in found if not near.costly)
    slow = tuple(near for near in found if near.costly)
    if slow:
        yield Spacing(slow[0] if len(slow) == 1 else Proximities(slow), costly=True)


def _growing(terms: SpacingTerms, domain: Domain) -> Iterator[Proximity]:
    growth = NEAR_GROWTH if terms.growth is None else terms.growth
    models: tuple[NearTerm, ...] = several(terms.near)
    for number, near in enumerate(models):
        with at_key("spacing", "near", *([number] if len(models) > 1 else []), "label"):
            distance = _distance(near, domain)
        yield Proximity(distance, near.size, growth if near.growth is None else near.growth, near.until)
    for label, size in terms.labels.items():
        with at_key("spacing", "labels", label):
            distance = distance_to(domain, [label])
        yield Proximity(distance, size, growth)


def _spots(terms: SpacingTerms, domain: Domain) -> Iterator[Floats]:
    """Points (k, 2) near which the spacing is fine; the boundary and what is embedded are looked at anyhow."""
    labels, models = set(terms.labels), tuple[NearTerm, ...](several(terms.near))
    for near in models:
        if isinstance(near, NearLabel):
            labels.add(near.label)
        elif isinstance(near, NearPoint):
            yield np.array([near.point])
        else:
            line = shapely.segmentize(shapely.linestrings(near.line), APART * domain.size)
            yield shapely.get_coordinates(line)
    yield np.array([at for at, label in domain.parts.points if label in labels]).reshape(-1, 2)


def _distance(near: NearTerm, domain: Domain) -> Distance:
    if isinstance(near, NearLabel):
        return distance_to(domain, [near.label])
    return distance_to_line([near.point] if isinstance(near, NearPoint) else near.line)


def _limits_within(terms: SpacingTerms, case: Case, domain: Domain) -> Iterator[Spacing]:
    """The largest spacings within regions."""
    regions, rest = domain.parts.regions, domain.parts.rest
    for name, value in terms.regions.items():
        key = Key(["spacing", "regions", name])
        term = _bound(value, case, domain, *key)
        mine, others = ([r for r in regions if (r.name == name) is same] for same in (True, False))
        if name != rest:
            if not mine:
                known = dict.fromkeys([*(region.name for region in regions), rest])
                with at_key(*key):
                    raise CaseError(unknown("region", name, known))
            largest = max(region.polygon.area for region in mine)
            others = [region for region in others if region.polygon.area < largest]
        reach = ShapeUnion(tuple(region.reach for region in mine)) if mine else None
        within = RegionTerm(term.function, reach, ShapeUnion(tuple(region.core for region in others)))
        yield replace(term, function=within)


def _bound(value: float | str, case: Case, domain: Domain, *path: str | int) -> Spacing:
    """The value of a key: a number, or an expression that may measure distances in the domain."""
    with at_key(*path):
        term = Expression.parse(str(value), case.parameters, partial(distance_to, domain))
    return Spacing(term, key=_always(Key(path)), costly=costly(term))


def _always(key: Key) -> Callable[[Floats], Key]:
    """The key of a term, at any point."""
    return lambda point: key
