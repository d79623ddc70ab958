"""The spacing request: the terms of a case's spacing, bound to its domain."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field, replace
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
import shapely

from bubblemesh.arrays import Floats
from bubblemesh.case import Case
from bubblemesh.case.data_terms import several
from bubblemesh.case.depth import DepthKeys, NodeDepthKeys
from bubblemesh.case.metric import AnyMetric
from bubblemesh.case.spacing import NearLabel, NearPoint, NearTerm, SpacingTerms, Value, as_terms
from bubblemesh.errors import CaseError, Key, at_key
from bubblemesh.geometry.distance.distances import (
    MOST_FORMULAS,
    FromPoints,
    distance_to_labels,
    distance_to_line,
    require_labels,
)
from bubblemesh.geometry.domain import Domain
from bubblemesh.messages import unknown
from bubblemesh.problem.crs import (
    GivenPlaces,
    bound_in,
    given_bounds,
    given_system,
    on_the_ground,
    require_given,
    terms_in,
)
from bubblemesh.problem.files import own_files
from bubblemesh.records import record
from bubblemesh.spacing.expression import Expression, Rasters
from bubblemesh.spacing.rules.rules import Rules
from bubblemesh.spacing.spacing import OneKey, Spacing
from bubblemesh.spacing.terms.combination import Combination, Term, costly, nothing
from bubblemesh.spacing.terms.depth import Deep, NodeDepth, NotBelow, Slope, Waves
from bubblemesh.spacing.terms.near import NEAR_GROWTH, Proximities, Proximity
from bubblemesh.spacing.terms.regions import Located, RegionLimit, RegionLimits, RegionSpacing, by_region

if TYPE_CHECKING:
    from bubblemesh.problem.data_terms import DataFunction, Variables
    from bubblemesh.problem.metric import MetricRequest

UNLIMITED = (0.0, np.inf)
NO_SPOTS = np.zeros((0, 2))
USUAL = 0.75  # of the largest area: mean one of triangles few of which are larger
NO_RULES, NOT_GIVEN = Rules(), NodeDepthKeys()
OwnValues = Mapping[str, tuple[Value, Key]]  # of regions, by their names
MOST_TERMS = 64  # near something: of more of them, only those in question are evaluated
SLOPE_ACROSS = 1 / 200  # of the domain's size: length over which depths are compared
APART = 1 / 500  # of the domain's size: points of a line that are looked at


@record
class SpacingRequest:
    """Request for a spacing in a domain."""

    at: Callable[[float | None], Spacing]  # before its rules, at a scale, or at its own if None is given
    rules: Rules = NO_RULES
    nodes: int | None = None  # that it is to be scaled for
    warnings: tuple[str, ...] = ()
    metrics: "tuple[MetricRequest, ...]" = ()  # below the spacing
    depth: NodeDepth | None = None  # that the mesh is written with
    rasters: Rasters = field(default_factory=dict)  # that expressions may name


def case_spacing(case: Case, domain: Domain) -> SpacingRequest:
    """The spacing request of a case; errors as of `spacing_request`."""
    own = {
        region.name: (value, Key([*region.key, "spacing"]))
        for region in domain.parts.regions
        if (value := case.domain.regions[int(region.key[2])].spacing) is not None
    }
    with own_files(case.spacing_terms, case.root):
        request = spacing_request(case.spacing, domain, own, case.output.node_depth, values_of(several(case.metric)))
    request = with_areas_below(request, domain, case.largest, largest_areas(case, domain))
    if domain.plane is not None:
        request = replace(request, at=on_the_ground(request.at, domain.plane))
    request = replace(request, warnings=(*case.warnings, *request.warnings))
    return with_metrics(request, several(case.metric), domain, case.root)


def held_request(case: Case, domain: Domain, at: Callable[[float | None], Spacing]) -> SpacingRequest:
    """Request for a spacing, at a scale, in place of that of a case, with what of the case holds for any; errors alike.

    That are its rules, the limits in regions and of areas, the Courant number, and the depth that is written.
    """
    terms, depth = case.spacing_terms, case.output.node_depth
    with own_files(terms, case.root):
        rasters, told = _variables(terms, domain, [depth.of])
        deep = _depth_of_nodes(terms, domain, rasters, depth)
        held = _held(at, terms, domain, rasters)
    if terms.regions and terms.nodes is not None:
        told = (*told, "spacing.regions: does not hold, since with spacing.nodes its values are no lengths")
    told = (*case.warnings, *told)
    request = SpacingRequest(held, rules_of(terms), terms.nodes, told, depth=deep, rasters=rasters)
    return with_areas_below(request, domain, case.largest, largest_areas(case, domain))


def _held(
    at: Callable[[float | None], Spacing], terms: SpacingTerms, domain: Domain, rasters: Rasters
) -> Callable[[float | None], Spacing]:
    """A spacing in the plane, within limits of regions, which do not go with its scale, and of the Courant number."""
    regions = terms.regions if terms.nodes is None else {}
    if not regions and terms.courant is None:
        return at
    plane = domain.plane
    if plane is not None:
        at = on_the_ground(at, plane, -1)
    if regions:
        limits = within_limits(terms, tuple(_in_regions(regions, domain, rasters)), NO_SPOTS, terms.scale)
        at = _below(at, [limits(None)])
    at = _not_below_courant(at, terms, domain, rasters)
    return at if plane is None else on_the_ground(at, plane)


def _in_regions(regions: Mapping[str, Value], domain: Domain, rasters: Rasters) -> Iterator[Spacing]:
    """Limits of the spacing in regions, as one spacing, if there are any."""
    limits = {name: (value, Key(["spacing", "regions", name])) for name, value in regions.items()}
    return _limits_within(limits, domain, rasters)


def values_of(metrics: Sequence[AnyMetric]) -> list[Value]:
    """Expressions in metrics, which may name rasters."""
    return [value for model in metrics for value in vars(model).values() if isinstance(value, Expression)]


def with_metrics(
    request: SpacingRequest, metrics: Sequence[AnyMetric], domain: Domain, root: Path | None
) -> SpacingRequest:
    """The request in metrics, if there are any, with notes on their files; errors as of `metric_requests`."""
    if not metrics:
        return request
    # Imported here since few cases have a metric.
    from bubblemesh.problem.metric import metric_requests

    found = metric_requests(metrics, domain, root, request.rasters)
    notes = (note for metric in found for note in metric.notes)
    return replace(request, warnings=(*request.warnings, *notes), metrics=found)


def largest_areas(case: Case, domain: Domain) -> dict[str, float]:
    """Largest areas of triangles in regions, by name; of several of one name the smallest.

    What the case says of a region counts, else what its file says.
    """
    areas: dict[str, float] = {}
    for region in domain.parts.regions:
        largest = case.domain.regions[int(region.key[2])].largest or region.area.largest
        if largest is not None:
            areas[region.name] = min(largest, areas.get(region.name, np.inf))
    return areas


def with_areas_below(
    request: SpacingRequest, domain: Domain, largest: float | None, within: Mapping[str, float]
) -> SpacingRequest:
    """The request at which hardly a triangle is larger than ``largest``, or within regions larger than there.

    These areas do not go with the scale of the spacing.
    """
    limits = [] if largest is None else [_bound(_side(largest), domain, "largest")]
    areas = {name: (_side(area), Key(["domain", "regions", name, "largest"])) for name, area in within.items()}
    limits += _limits_within(areas, domain)
    return replace(request, at=_below(request.at, limits)) if limits else request


def _below(at: Callable[[float | None], Spacing], limits: Sequence[Spacing]) -> Callable[[float | None], Spacing]:
    """A spacing, at a scale, below limits that do not go with it."""

    def limited(scale: float | None) -> Spacing:
        given = at(scale)
        both = Combination((given, *limits))
        return Spacing(both, keys=both.keys, costly=both.costly, spots=given.spots)

    return limited


def _side(area: float) -> float:
    """Spacing at which triangles are hardly ever larger than the area."""
    return float(np.sqrt(4 / np.sqrt(3) * USUAL * area))


def spacing_request(
    spacing: Value | SpacingTerms,
    domain: Domain,
    own: OwnValues | None = None,
    depth: NodeDepthKeys = NOT_GIVEN,
    others: Sequence[Value] = (),
) -> SpacingRequest:
    """Spacing request of a value, or of terms, and of the regions' own values in a domain; errors have the key.

    ``depth`` is that which the mesh is written with, if a case says so; ``others`` may name rasters as well.
    """
    given, plane = as_terms(spacing), domain.plane
    rasters, told = _variables(given, domain, [depth.of, *others, *(value for value, _ in (own or {}).values())])
    terms = given if plane is None else terms_in(plane, given)
    key, value = terms.basis
    path = ("spacing", key) if spacing is given else ("spacing",)
    rest = Spacing(nothing) if value is None else _bound(value, domain, *path, rasters=rasters)
    bound = (
        _by_region(rest, domain, own or {}, rasters),
        *_in_regions(terms.regions, domain, rasters),
        *_of_depth(terms, domain, rasters),
    )
    deep = _depth_of_nodes(terms, domain, rasters, depth)
    # After all that names rasters: one whose name is misspelt there would be taken as a spacing.
    functions, astray = _data(terms, domain, rasters)
    found = (
        *bound,
        *_near(terms, domain),
        *(Spacing(_in_plane(data, domain), keys=OneKey(key)) for key, data in functions.items()),
    )
    of_data = [data.spots for data in functions.values()]
    spots = np.vstack([*_spots(terms, domain), *(of_data if plane is None else map(plane.near, of_data))])
    at = _not_below_courant(within_limits(terms, found, spots, terms.scale), terms, domain, rasters)
    return SpacingRequest(at, rules_of(terms), terms.nodes, (*told, *astray), depth=deep, rasters=rasters)


def _variables(
    terms: SpacingTerms, domain: Domain, others: Sequence[Value | None]
) -> "tuple[Variables, tuple[str, ...]]":
    """The rasters that expressions name, and notes on them."""
    keys = [each.depth for each in (terms.waves, terms.slope, terms.courant) if each is not None]
    values = [terms.value, *terms.regions.values(), *keys, *others]
    names = {name for value in values if isinstance(value, Expression) for name in value.rasters}
    if not names:
        return {}, ()
    from bubblemesh.problem.data_terms import raster_variables

    return raster_variables(terms, given_bounds(domain), names, given_system(domain))


def _deep(keys: DepthKeys, domain: Domain, rasters: Rasters, name: str) -> Deep:
    """The depth that some keys of the spacing tell."""
    return Deep(_bound(keys.depth, domain, "spacing", name, "depth", rasters=rasters).function, keys.shallowest)


def _of_depth(terms: SpacingTerms, domain: Domain, rasters: Rasters) -> Iterator[Spacing]:
    """Spacings by the length of waves and by the slope of the bed."""
    if terms.waves is not None:
        deep = _deep(terms.waves, domain, rasters, "waves")
        waves = Waves(deep, terms.waves.period, terms.waves.per_length)
        yield Spacing(waves, keys=OneKey(Key(["spacing", "waves"])))
    if terms.slope is not None:
        across = terms.slope.filter or domain.size * SLOPE_ACROSS
        slope = Slope(_deep(terms.slope, domain, rasters, "slope"), terms.slope.per_slope, across)
        yield Spacing(slope, keys=OneKey(Key(["spacing", "slope"])))


def _not_below_courant(
    at: Callable[[float | None], Spacing], terms: SpacingTerms, domain: Domain, rasters: Rasters
) -> Callable[[float | None], Spacing]:
    """A spacing that is nowhere finer than its time step allows."""
    keys = terms.courant
    if keys is None:
        return at
    deep = _deep(keys, domain, rasters, "courant")

    def bounded(scale: float | None) -> Spacing:
        given = at(scale)
        raised = NotBelow(given, deep, keys.dt, keys.largest)
        return replace(given, function=raised, keys=raised.keys)

    return bounded


def _depth_of_nodes(
    terms: SpacingTerms, domain: Domain, rasters: "Variables", depth: NodeDepthKeys
) -> NodeDepth | None:
    """The depth that the mesh is written with: that given, or that of a term of the spacing."""
    told = {("output", "depth"): depth.of}
    for name, keys in (("waves", terms.waves), ("slope", terms.slope), ("courant", terms.courant)):
        told["spacing", name] = None if keys is None else keys.depth
    path, value = next(((path, value) for path, value in told.items() if value is not None), ((), None))
    if value is None:
        return None
    function = _bound(value, domain, *path, rasters=rasters).function
    if depth.over == "node":
        return NodeDepth(function)
    if not value.rasters:
        return NodeDepth(function, over=np.inf)
    from bubblemesh.problem.data_terms import raster_step

    steps = (raster_step(rasters[name], domain) for name in value.rasters)
    return NodeDepth(function, over=min(steps))


def _data(
    terms: SpacingTerms, domain: Domain, variables: Rasters
) -> "tuple[Mapping[Key, DataFunction], tuple[str, ...]]":
    """Functions of the data terms, by their keys, with notes on them, also on data that lies outside of the domain."""
    if not terms.data:
        return {}, ()
    # Imported here since few cases have data, and all that reads it takes long to load.
    from bubblemesh.problem.data_terms import data_functions, elsewhere

    box = given_bounds(domain)
    found, notes = data_functions(terms, box, given_system(domain), variables)
    for key, data in found.items():
        with at_key(*key):
            require_given(data.bounds, domain)
    astray = (elsewhere(key, data, box) for key, data in found.items())
    return found, (*notes, *filter(None, astray))


def within_limits(
    terms: SpacingTerms, found: tuple[Spacing, ...], spots: Floats, own_scale: float = 1.0
) -> Callable[[float | None], Spacing]:
    """The smallest of some spacings at a scale, or else their own, within the terms' limits; fine near spots (k, 2)."""
    limits = terms.minimum or 0.0, np.inf if terms.maximum is None else terms.maximum

    def at(scale: float | None) -> Spacing:
        factor = own_scale if scale is None else scale
        if len(found) == 1 and (factor, limits) == (1.0, UNLIMITED):  # as it is, since it is evaluated very often
            return replace(found[0], spots=spots)
        combination = Combination(found, factor, *limits)
        return Spacing(combination, keys=combination.keys, costly=combination.costly, spots=spots)

    return at


def rules_of(terms: SpacingTerms) -> Rules:
    """Rules that the spacing has to respect."""
    return Rules(terms.growth, terms.per_circle, terms.across, terms.minimum or 0.0)


def _by_region(rest: Spacing, domain: Domain, own: OwnValues, rasters: Rasters) -> Spacing:
    """A spacing, with those of the regions that have one of their own in its place."""
    made: dict[Value, Spacing] = {}
    for value, key in own.values():
        if value not in made:
            made[value] = _bound(value, domain, *key, rasters=rasters)
    finer = [region for region in domain.parts.regions if region.name in own]
    return by_region(rest, [RegionSpacing(region, made[own[region.name][0]], own[region.name][1]) for region in finer])


def _in_plane(data: Term, domain: Domain) -> Term:
    """Data, whose places are given ones, as a function of those in the domain."""
    return data if domain.unprojection is None else GivenPlaces(data, domain.unprojection)


def _near(terms: SpacingTerms, domain: Domain) -> Iterator[Spacing]:
    """Spacings that are fine near something, and grow from there: one term for all whose distance takes long."""
    found, key = tuple(_growing(terms, domain)), _key_near(terms, domain)
    fast = tuple(near for near in found if not near.costly)
    if len(fast) > MOST_TERMS:
        yield Spacing(Proximities(fast), keys=key)
    else:
        yield from (Spacing(near, keys=key) for near in fast)
    slow = tuple(near for near in found if near.costly)
    if slow:
        yield Spacing(slow[0] if len(slow) == 1 else Proximities(slow), keys=key, costly=True)


def _key_near(terms: SpacingTerms, domain: Domain) -> Callable[[Floats], Sequence[Key]]:
    """Keys of what is near something: terms of two keys that are alike are one, and told apart where it is asked."""
    if not (terms.near and terms.labels):
        return OneKey(Key(["spacing", "near" if terms.near else "labels"]))
    near, labels = terms.model_copy(update={"labels": {}}), terms.model_copy(update={"near": None})
    return Combination((*_near(near, domain), *_near(labels, domain))).keys


def _growing(terms: SpacingTerms, domain: Domain) -> Iterator[Proximity]:
    growth = NEAR_GROWTH if terms.growth is None else terms.growth
    models: tuple[NearTerm, ...] = several(terms.near)
    points = _alike(models)
    for size, own, until in points:
        nearest = FromPoints(np.array(points[size, own, until]))
        yield Proximity(nearest, size, growth if own is None else own, until)
    labels: dict[tuple[float, float, float], list[str]] = {}  # by size, growth and reach
    for number, near in enumerate(models):
        law = near.size, growth if near.growth is None else near.growth, near.until
        if isinstance(near, NearLabel):
            with at_key("spacing", "near", *([number] if len(models) > 1 else []), "label"):
                require_labels(domain, [near.label])
            labels.setdefault(law, []).append(near.label)
        elif isinstance(near, NearPoint):
            if (near.size, near.growth, near.until) not in points:
                yield Proximity(distance_to_line([near.point]), *law)
        else:
            yield Proximity(distance_to_line(near.line), *law)
    for label, size in terms.labels.items():
        with at_key("spacing", "labels", label):
            require_labels(domain, [label])
        labels.setdefault((size, growth, 0.0), []).append(label)
    for law, alike in labels.items():  # the nearest of those that are alike takes one look, not one for each
        yield Proximity(distance_to_labels(domain, tuple(dict.fromkeys(alike))), *law)


def _alike(models: Sequence[NearTerm]) -> dict[tuple[float, float | None, float], list[tuple[float, float]]]:
    """Points with the same size, growth and reach, by these, where they are so many that the nearest is looked for."""
    found: dict[tuple[float, float | None, float], list[tuple[float, float]]] = {}
    for near in models:
        if isinstance(near, NearPoint):
            found.setdefault((near.size, near.growth, near.until), []).append(near.point)
    return {key: points for key, points in found.items() if len(points) > MOST_FORMULAS}


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
    yield np.array([point.at for point in domain.parts.points if point.label in labels]).reshape(-1, 2)


def _limits_within(
    largest: Mapping[str, tuple[Value, Key]], domain: Domain, rasters: Rasters = MappingProxyType({})
) -> Iterator[Spacing]:
    """The largest spacings within regions, by name with their keys, as one spacing, if there are any."""
    regions, rest = domain.parts.regions, domain.parts.rest
    known = list(dict.fromkeys([*(region.name for region in regions), rest]))
    made: dict[Value, Spacing] = {}
    limits = list[RegionLimit]()
    for name, (value, key) in largest.items():
        if value not in made:
            made[value] = _bound(value, domain, *key, rasters=rasters)
        if name not in known:
            with at_key(*key):
                raise CaseError(unknown("region", name, known))
        limits.append(RegionLimit(name, made[value], key))
    if limits:
        within = RegionLimits(Located(regions), tuple(limits))
        yield Spacing(within, keys=within.keys, costly=within.costly)


def _bound(value: Value, domain: Domain, *path: str | int, rasters: Rasters = MappingProxyType({})) -> Spacing:
    """The value of a key: a number, or an expression that may measure distances in the domain, and name rasters."""
    with at_key(*path):
        bound = value if isinstance(value, Expression) else Expression.parse(str(value))
        distance_to = partial(distance_to_labels, domain)
        function, term = bound_in(domain.unprojection, bound, distance_to, rasters)
    return Spacing(function, keys=OneKey(Key(path)), costly=costly(term))
