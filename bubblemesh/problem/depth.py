"""Spacings by the depth of water, and the depth that a mesh is written with."""

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from bubblemesh.case.depth import DepthKeys, NodeDepthKeys
from bubblemesh.case.spacing import SpacingTerms
from bubblemesh.errors import Key
from bubblemesh.geometry.domain import Domain
from bubblemesh.problem.scale import SpacingAtScale
from bubblemesh.problem.values import bound_value
from bubblemesh.spacing.expression import Rasters
from bubblemesh.spacing.spacing import OneKey, Spacing
from bubblemesh.spacing.terms.depth import Deep, NodeDepth, NotBelow, Slope, Waves

if TYPE_CHECKING:
    from bubblemesh.problem.data_terms import RasterNames

SLOPE_ACROSS = 1 / 200  # of the domain's size: length over which depths are compared


def _deep(keys: DepthKeys, domain: Domain, rasters: Rasters, name: str) -> Deep:
    """The depth that some keys of the spacing give."""
    return Deep(bound_value(keys.depth, domain, "spacing", name, "depth", rasters=rasters).function, keys.shallowest)


def depth_spacings(terms: SpacingTerms, domain: Domain, rasters: Rasters) -> Iterator[Spacing]:
    """Spacings by the length of waves and by the slope of the bed."""
    if terms.waves is not None:
        deep = _deep(terms.waves, domain, rasters, "waves")
        waves = Waves(deep, terms.waves.period, terms.waves.per_length)
        yield Spacing(waves, keys=OneKey(Key(["spacing", "waves"])))
    if terms.slope is not None:
        across = terms.slope.filter or domain.size * SLOPE_ACROSS
        slope = Slope(_deep(terms.slope, domain, rasters, "slope"), terms.slope.per_slope, across)
        yield Spacing(slope, keys=OneKey(Key(["spacing", "slope"])))


def not_below_courant(at: SpacingAtScale, terms: SpacingTerms, domain: Domain, rasters: Rasters) -> SpacingAtScale:
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


def node_depth(terms: SpacingTerms, domain: Domain, rasters: "RasterNames", depth: NodeDepthKeys) -> NodeDepth | None:
    """The depth that the mesh is written with: that given, or that of a term of the spacing."""
    depths = {("output", "depth"): depth.of}
    for name, keys in (("waves", terms.waves), ("slope", terms.slope), ("courant", terms.courant)):
        depths["spacing", name] = None if keys is None else keys.depth
    path, value = next(((path, value) for path, value in depths.items() if value is not None), ((), None))
    if value is None:
        return None
    function = bound_value(value, domain, *path, rasters=rasters).function
    if depth.over == "node":
        return NodeDepth(function)
    if not value.rasters:
        return NodeDepth(function, over=np.inf)
    from bubblemesh.problem.data_terms import raster_step

    steps = (raster_step(rasters[name], domain) for name in value.rasters)
    return NodeDepth(function, over=min(steps))
