"""Regions that cover earlier ones, as what is drawn later covers what is below; curves stay exact."""

from collections.abc import Callable, Sequence, Set
from dataclasses import replace

import numpy as np
import shapely

from bubblemesh.errors import GeometryError, Key, about
from bubblemesh.geometry.arrangement import TOUCHING
from bubblemesh.geometry.arrangement.overlay import overlaid, size_of
from bubblemesh.geometry.arrangement.regions import Region
from bubblemesh.geometry.paths import Area, Ring, outlines
from bubblemesh.geometry.validity import first_place


def covered(regions: Sequence[Region], rings: Sequence[Ring]) -> list[Region]:
    """Regions without what later ones of other names cover of them; if some meet, the last ones first.

    In this order a side that two of them share has the label of the later one. Tolerances are relative to the size of
    the domain within ``rings``, or of all regions if there are none. GeometryError, about the key of a region of which
    nothing is left, or if rings cross themselves or are next to each other.
    """
    if not regions:
        return []
    ordered = [replace(region, order=number) for number, region in enumerate(regions)]
    size = size_of(np.concatenate(outlines(rings or [ring for region in ordered for ring in region.area.rings])))
    # Of curves the chords may be apart where these overlap, so that the overlay has to tell.
    shapes = [region.polygon if region.straight else region.reach for region in ordered]
    if not _meet(shapes, TOUCHING * size):
        return ordered
    names = [region.name for region in ordered]
    over = later_ones(shapes, names, TOUCHING * size)
    found = list[Region]()
    for region, others in zip(ordered, over, strict=True):
        found += _without(region, [ordered[k] for k in others], size) if others else [region]
    left = {region.name for region in found}
    require_all_left(names, left, lambda k: (ordered[k].polygon, names[over[k][-1]], ordered[k].key))
    return found[::-1]


def _meet(shapes: Sequence[shapely.Polygon], tolerance: float) -> bool:
    """Whether any two of the shapes overlap or touch."""
    given = np.array(shapes, dtype=object)
    return shapely.STRtree(given).query(given, predicate="dwithin", distance=tolerance).shape[1] > len(given)


def later_ones(shapes: Sequence[shapely.Polygon], names: Sequence[str], thin: float) -> list[list[int]]:
    """Numbers, for each of the shapes, of later ones of other names that have a part of its area, not only ``thin``."""
    if not shapes:
        return []
    given = np.array(shapes, dtype=object)
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
    names: Sequence[str], left: Set[str], what: Callable[[int], tuple[shapely.Polygon, str, Key]]
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


def _without(region: Region, others: Sequence[Region], size: float) -> list[Region]:
    """The region without others, in several parts if they divide it, in none if they cover it."""
    given = region.area

    def own(ring: Ring) -> Ring:
        return replace(ring, key=region.key, optional=given.outer.optional)

    with about(region.key):
        left: list[Area] = overlaid("minus", [[given], [other.area for other in others]], size)
    parts = [replace(area.mapped(own), name=given.name, largest=given.largest) for area in left]
    changes = tuple(change for ring in given.rings for change in ring.changes)
    return [
        replace(region, area=area if k else replace(area, outer=replace(area.outer, changes=changes)), cut=True)
        for k, area in enumerate(parts)
    ]
