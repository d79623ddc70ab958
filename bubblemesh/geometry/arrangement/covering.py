"""Regions that cover earlier ones, as what is drawn later covers what is below; curves stay exact."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely

from bubblemesh.errors import GeometryError, about
from bubblemesh.geometry.arrangement.overlay import overlaid
from bubblemesh.geometry.arrangement.regions import Region
from bubblemesh.geometry.paths import Area, Ring
from bubblemesh.geometry.validity import first_place


def covered(regions: Sequence[Region]) -> list[Region]:
    """Regions without what later ones of other names cover of them; if there is such, the last ones first.

    In this order a side that two of them share has the label of the later one. GeometryError, about the key of a region
    of which nothing is left, or if rings cross themselves or are next to each other.
    """
    over = later_ones([region.polygon for region in regions], [region.name for region in regions])
    if not any(over):
        return list(regions)
    found = list[Region]()
    for number, region in enumerate(regions):
        found += _without(region, [regions[k] for k in over[number]]) if over[number] else [region]
    return found[::-1]


def later_ones(shapes: Sequence[shapely.Polygon], names: Sequence[str]) -> list[list[int]]:
    """Numbers, for each of the shapes, of later ones of other names that have a part of its area."""
    given = np.array(shapes, dtype=object)
    i, j = shapely.STRtree(given).query(given, predicate="intersects")
    other = np.array([a < b and names[a] != names[b] for a, b in zip(i.tolist(), j.tolist(), strict=True)], bool)
    i, j = i[other], j[other]
    common = shapely.area(shapely.intersection(given[i], given[j])) > 0
    over: list[list[int]] = [[] for _ in shapes]
    for a, b in zip(i[common].tolist(), j[common].tolist(), strict=True):
        over[a].append(b)
    return [sorted(some) for some in over]


def nothing_left(name: str, shape: shapely.Polygon, other: str) -> GeometryError:
    """The error of a region, and its shape, of which others, the last of which is ``other``, leave nothing."""
    return GeometryError(
        f"nothing is left of region {name!r} at {first_place(shape)}: {other!r}, which comes later, covers it: move it "
        "behind that, or remove it"
    )


def _without(region: Region, others: Sequence[Region]) -> list[Region]:
    """The region without others, in several parts if they divide it."""

    def own(ring: Ring) -> Ring:
        return replace(ring, key=region.key, optional=region.area.outer.optional)

    with about(region.key):
        left: list[Area] = overlaid("minus", [[region.area], [other.area for other in others]])
        if not left:
            raise nothing_left(region.name, region.polygon, others[-1].name)
    return [
        replace(region, area=replace(area.mapped(own), name=region.area.name, largest=region.area.largest))
        for area in left
    ]
