"""The spacing request: the terms of a case's spacing, bound to its domain."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from bubblemesh.case import Case
from bubblemesh.case.depth import NodeDepthKeys
from bubblemesh.case.fields import several
from bubblemesh.case.metric import AnyMetric
from bubblemesh.case.spacing import SpacingTerms, Value, as_terms
from bubblemesh.errors import Key, at_key
from bubblemesh.geometry.domain import Domain
from bubblemesh.problem.crs import (
    GivenPlaces,
    given_bounds,
    given_system,
    on_the_ground,
    require_given,
    terms_in,
)
from bubblemesh.problem.depth import depth_spacings, node_depth, not_below_courant
from bubblemesh.problem.files import own_files
from bubblemesh.problem.proximity import near_spacings, near_spots
from bubblemesh.problem.regions import (
    OwnValues,
    area_limits,
    largest_areas,
    limits_within,
    own_values,
    region_limits,
    with_regions,
)
from bubblemesh.problem.scale import SpacingAtScale, below_limits, bounded
from bubblemesh.problem.values import bound_value, named_rasters, values_of
from bubblemesh.records import record
from bubblemesh.spacing.expression import Rasters
from bubblemesh.spacing.rules.rules import Rules
from bubblemesh.spacing.spacing import OneKey, Spacing
from bubblemesh.spacing.terms.combination import Term, nothing
from bubblemesh.spacing.terms.depth import NodeDepth

if TYPE_CHECKING:
    from bubblemesh.problem.data_terms import DataFunction
    from bubblemesh.problem.metric import MetricRequest

NODES = Key(["spacing", "nodes"])
NO_SPOTS = np.zeros((0, 2))
NO_RULES, NOT_GIVEN = Rules(), NodeDepthKeys()


@record
class SpacingRequest:
    """Request for a spacing in a domain."""

    at: SpacingAtScale  # before its rules
    rules: Rules = NO_RULES
    nodes: int | None = None  # that it is to be scaled for
    warnings: tuple[str, ...] = ()
    metrics: "tuple[MetricRequest, ...]" = ()  # below the spacing
    depth: NodeDepth | None = None  # that the mesh is written with
    rasters: Rasters = field(default_factory=dict)  # that expressions may name
    nodes_key: Key = NODES  # of the number of nodes, or of what it follows from
    nearest: Callable[[int], str] | None = None  # if the nearest number of nodes will do, the warning of another one


def case_spacing(case: Case, domain: Domain) -> SpacingRequest:
    """The spacing request of a case; the same errors as `spacing_request`."""
    own = own_values(case, domain)
    with own_files(case.spacing_terms, case.root):
        request = spacing_request(case.spacing, domain, own, case.output.node_depth, values_of(several(case.metric)))
    request = with_areas_below(request, domain, case.largest, largest_areas(case, domain))
    if domain.plane is not None:
        request = replace(request, at=on_the_ground(request.at, domain.plane))
    request = replace(request, warnings=(*case.warnings, *request.warnings))
    return with_metrics(request, several(case.metric), domain, case.root)


def held_request(case: Case, domain: Domain, at: SpacingAtScale) -> SpacingRequest:
    """Spacing request with a given spacing in place of the case's own; the same errors as `case_spacing`.

    Of the case, these still apply: its rules, the spacings of regions as limits from above, limits of areas, the
    Courant number, and the depth to write. Spacings of regions that go with a number of nodes do not apply, and a
    warning says so.
    """
    terms = case.spacing_terms
    depth = case.output.node_depth
    own = own_values(case, domain)
    with own_files(terms, case.root):
        rasters, notes = named_rasters(terms, domain, [depth.of, *(value for value, _ in own.values())])
        deep = node_depth(terms, domain, rasters, depth)
        held = _held(at, terms, own, domain, rasters)
    if terms.nodes is not None:
        keys = (*(["spacing.regions"] if terms.regions else []), *(key for _, key in own.values()))
        notes = (*notes, *(f"{key}: does not hold, since with spacing.nodes its values are no lengths" for key in keys))
    notes = (*case.warnings, *notes)
    request = SpacingRequest(held, rules_of(terms), terms.nodes, notes, depth=deep, rasters=rasters)
    return with_areas_below(request, domain, case.largest, largest_areas(case, domain))


def _held(at: SpacingAtScale, terms: SpacingTerms, own: OwnValues, domain: Domain, rasters: Rasters) -> SpacingAtScale:
    """A spacing in the plane, within limits of regions, which do not go with its scale, and of the Courant number.

    The regions' own values are such limits too.
    """
    lengths = terms.nodes is None and bool(terms.regions or own)
    if not lengths and terms.courant is None:
        return at
    plane = domain.plane
    if plane is not None:
        at = on_the_ground(at, plane, -1)
    if lengths:
        regions = *region_limits(terms.regions, domain, rasters), *limits_within(own, domain, rasters)
        at = below_limits(at, [bounded(terms, regions, NO_SPOTS, terms.scale)(None)])
    at = not_below_courant(at, terms, domain, rasters)
    return at if plane is None else on_the_ground(at, plane)


def with_metrics(
    request: SpacingRequest, metrics: Sequence[AnyMetric], domain: Domain, root: Path | None
) -> SpacingRequest:
    """The request in metrics, if there are any, with notes on their files; the same errors as `metric_requests`."""
    if not metrics:
        return request
    # Imported here since few cases have a metric.
    from bubblemesh.problem.metric import metric_requests

    found = metric_requests(metrics, domain, root, request.rasters)
    notes = (note for metric in found for note in metric.notes)
    return replace(request, warnings=(*request.warnings, *notes), metrics=found)


def with_areas_below(
    request: SpacingRequest, domain: Domain, largest: float | None, within: Mapping[str, float]
) -> SpacingRequest:
    """The request, limited so that few triangles exceed the area ``largest``, or a region's own limit inside it.

    These limits do not go with the scale of the spacing.
    """
    limits = area_limits(domain, largest, within)
    return replace(request, at=below_limits(request.at, limits)) if limits else request


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
    values = [depth.of, *others, *(value for value, _ in (own or {}).values())]
    rasters, raster_notes = named_rasters(given, domain, values)
    terms = given if plane is None else terms_in(plane, given)
    key, value = terms.basis
    path = ("spacing", key) if spacing is given else ("spacing",)
    rest = Spacing(nothing) if value is None else bound_value(value, domain, *path, rasters=rasters)
    bound = (
        with_regions(rest, domain, own or {}, rasters),
        *region_limits(terms.regions, domain, rasters),
        *depth_spacings(terms, domain, rasters),
    )
    deep = node_depth(terms, domain, rasters, depth)
    # After all that names rasters: one whose name is misspelt there would be taken as a spacing.
    functions, notes = _data(terms, domain, rasters)
    found = (
        *bound,
        *near_spacings(terms, domain),
        *(Spacing(_in_plane(data, domain), keys=OneKey(key)) for key, data in functions.items()),
    )
    of_data = [data.spots for data in functions.values()]
    spots = np.vstack([*near_spots(terms, domain), *(of_data if plane is None else map(plane.near, of_data))])
    at = not_below_courant(bounded(terms, found, spots, terms.scale), terms, domain, rasters)
    return SpacingRequest(at, rules_of(terms), terms.nodes, (*raster_notes, *notes), depth=deep, rasters=rasters)


def _data(
    terms: SpacingTerms, domain: Domain, variables: Rasters
) -> "tuple[Mapping[Key, DataFunction], tuple[str, ...]]":
    """Functions of the data terms, by their keys, and notes on them, as on data that lies outside of the domain."""
    if not terms.data:
        return {}, ()
    # Imported here since few cases have data, and all that reads it takes long to load.
    from bubblemesh.problem.data_terms import coverage_notes, data_functions

    box = given_bounds(domain)
    found, notes = data_functions(terms, box, given_system(domain), variables)
    for key, data in found.items():
        with at_key(*key):
            require_given(data.bounds, domain)
    coverage = (note for key, data in found.items() for note in coverage_notes(key, data, domain))
    return found, (*notes, *coverage)


def rules_of(terms: SpacingTerms) -> Rules:
    """Rules that the spacing has to respect."""
    return Rules(terms.growth, terms.per_circle, terms.across, terms.minimum or 0.0)


def _in_plane(data: Term, domain: Domain) -> Term:
    """Data, whose places are given ones, as a function of those in the domain."""
    return data if domain.unprojection is None else GivenPlaces(data, domain.unprojection)
