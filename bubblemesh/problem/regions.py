"""Spacings of regions, and limits of the spacing and of areas within them."""

from collections.abc import Iterator, Mapping

import numpy as np

from bubblemesh.case import Case
from bubblemesh.case.spacing import Value
from bubblemesh.errors import CaseError, Key, at_key
from bubblemesh.geometry.domain import Domain
from bubblemesh.messages import unknown
from bubblemesh.problem.values import bound_value
from bubblemesh.spacing.expression import Rasters
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.terms.regions import Located, RegionLimit, RegionLimits, RegionSpacing, by_region

USUAL = 0.75  # of the largest area: mean one of triangles few of which are larger
OwnValues = Mapping[str, tuple[Value, Key]]  # of regions, by their names


def own_values(case: Case, domain: Domain) -> OwnValues:
    """The regions' own values in a case, with their keys."""
    return {
        region.name: (value, Key([*region.key, "spacing"]))
        for region in domain.parts.regions
        if (value := case.domain.regions[region.entry].spacing) is not None
    }


def with_regions(rest: Spacing, domain: Domain, own: OwnValues, rasters: Rasters) -> Spacing:
    """A spacing, with those of the regions that have one of their own in its place."""
    made: dict[Value, Spacing] = {}
    for value, key in own.values():
        if value not in made:
            made[value] = bound_value(value, domain, *key, rasters=rasters)
    finer = [region for region in domain.parts.regions if region.name in own]
    return by_region(rest, [RegionSpacing(region, made[own[region.name][0]], own[region.name][1]) for region in finer])


def region_limits(regions: Mapping[str, Value], domain: Domain, rasters: Rasters) -> Iterator[Spacing]:
    """Limits of the spacing in regions, as one spacing, if there are any."""
    limits = {name: (value, Key(["spacing", "regions", name])) for name, value in regions.items()}
    return limits_within(limits, domain, rasters)


def limits_within(largest: Mapping[str, tuple[Value, Key]], domain: Domain, rasters: Rasters) -> Iterator[Spacing]:
    """The largest spacings within regions, by name with their keys, as one spacing, if there are any."""
    regions, rest = domain.parts.regions, domain.parts.rest
    known = list(dict.fromkeys([*(region.name for region in regions), rest]))
    made: dict[Value, Spacing] = {}
    limits = list[RegionLimit]()
    for name, (value, key) in largest.items():
        if value not in made:
            made[value] = bound_value(value, domain, *key, rasters=rasters)
        if name not in known:
            with at_key(*key):
                raise CaseError(unknown("region", name, known))
        limits.append(RegionLimit(name, made[value], key))
    if limits:
        within = RegionLimits(Located(regions), tuple(limits))
        yield Spacing(within, keys=within.keys, costly=within.costly)


def largest_areas(case: Case, domain: Domain) -> dict[str, float]:
    """Largest areas of triangles in regions, by name; of several of one name the smallest.

    What the case says of a region counts, else what its file says.
    """
    areas: dict[str, float] = {}
    for region in domain.parts.regions:
        largest = case.domain.regions[region.entry].largest or region.area.largest
        if largest is not None:
            areas[region.name] = min(largest, areas.get(region.name, np.inf))
    return areas


def area_limits(domain: Domain, largest: float | None, within: Mapping[str, float]) -> list[Spacing]:
    """Spacings at which hardly a triangle is larger than ``largest``, or within regions larger than there, by name."""
    limits = [] if largest is None else [bound_value(_side(largest), domain, "largest", rasters={})]
    areas = {name: (_side(area), Key(["domain", "regions", name, "largest"])) for name, area in within.items()}
    return [*limits, *limits_within(areas, domain, {})]


def _side(area: float) -> float:
    """Spacing at which triangles are hardly ever larger than the area."""
    return float(np.sqrt(4 / np.sqrt(3) * USUAL * area))
