"""Regions that cover earlier ones, as what is drawn later covers what is below; curves stay exact."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import shapely

from bubblemesh.errors import GeometryError, Key, about
from bubblemesh.geometry.arrangement import TOUCHING
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
    names, left = ([region.name for region in some] for some in (regions, found))
    require_all_left(names, left, lambda k: (regions[k].polygon, names[over[k][-1]], regions[k].key))
    return found[::-1]


def later_ones(shapes: Sequence[shapely.Polygon], names: Sequence[str]) -> list[list[int]]:
    """Numbers, for each of the shapes, of later ones of other names that have a part of its area, not by rounding."""
    if not shapes:
        return []
    given = np.array(shapes, dtype=object)
    thin = TOUCHING * float(np.ptp(shapely.total_bounds(given).reshape(2, 2), axis=0).max())
    i, j = shapely.STRtree(given).query(given, predicate="intersects")
    other = np.array([a < b and names[a] != names[b] for a, b in zip(i.tolist(), j.tolist(), strict=True)], bool)
    i, j = i[other], j[other]
    common = shapely.intersection(given[i], given[j])
    wide = shapely.area(common) > thin * shapely.length(common) / 2
    over: list[list[int]] = [[] for _ in shapes]
    for a, b in zip(i[wide].tolist(), j[wide].tolist(), strict=True):
        over[a].append(b)
    return [sorted(some) for some in over]


def require_all_left(
    names: Sequence[str], left: Sequence[str], what: Callable[[int], tuple[shapely.Polygon, str, Key]]
) -> None:
    """Check that some part is left of each name; GeometryError about the first one of a name of which nothing is.

    ``what`` returns, by its number, its shape, the name of the last one that covers it, and its key.
    """
    gone = next((number for number, name in enumerate(names) if name not in left), None)
    if gone is not None:
        shape, other, key = what(gone)
        with about(key):
            raise GeometryError(
                f"nothing is left of region {names[gone]!r} at {first_place(shape)}: {other!r}, which comes later, "
                "covers it: move it behind that, or remove it"
            )


def _without(region: Region, others: Sequence[Region]) -> list[Region]:
    """The region without others, in several parts if they divide it, in none if they cover it."""

    def own(ring: Ring) -> Ring:
        return replace(ring, key=region.key, optional=region.area.outer.optional)

    with about(region.key):
        left: list[Area] = overlaid("minus", [[region.area], [other.area for other in others]])
    return [
        replace(region, area=replace(area.mapped(own), name=region.area.name, largest=region.area.largest))
        for area in left
    ]
