"""Features of a file as regions that share their borders."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import shapely

from bubblemesh.errors import CaseError, GeometryError, prefixed
from bubblemesh.files import FORBIDDEN, is_writable
from bubblemesh.geometry import rings
from bubblemesh.geometry.arrangement import NEARLY, TOUCHING
from bubblemesh.geometry.arrangement.covering import later_ones, require_all_left
from bubblemesh.geometry.borders import matched
from bubblemesh.geometry.coverage import is_coverage
from bubblemesh.geometry.nesting import Shapes, polygons_of, shapes_of, thick
from bubblemesh.geometry.paths import Area, Line, Point, Ring, RingChange
from bubblemesh.geometry.repair import Repair
from bubblemesh.geometry.validity import explained, simple_polygon
from bubblemesh.messages import counted, unknown
from bubblemesh.readers.areas import areas_by_nesting
from bubblemesh.readers.features import REGION, Feature, text_of_number
from bubblemesh.readers.outlines import Bounding, bounding, joining_of
from bubblemesh.readers.selection import Selection

LAYER = "layer"  # as a property, the layer of a feature
OF_ANY_FEATURE = LAYER, "fid"  # what features have beside the properties that a file holds


def named_areas(
    features: Sequence[Feature], key: str, selection: Selection, size: float, ordered: bool = False
) -> tuple[list[Area], list[str]]:
    """Areas of features, named by their property ``key``, whose borders are exactly shared, and notes.

    Areas with the same name that share a border become one. If they are ``ordered``, by the first feature of each name,
    straight-sided ones are left without what later ones cover; curved ones overlap as they did. If the selection asks
    for a repair those of each name are mended first, and gaps up to its gap, of features of that ``size``, are closed
    between all of them. CaseError if there is no such property, or a value of it cannot be a name; GeometryError if
    neighbours overlap by more than the selection's ``join``.
    """
    groups: dict[str, list[Feature]] = {}
    if any(one.spare == REGION for one in features):
        features = [one for one in features if one.spare == REGION]
    for one in features:
        groups.setdefault(_value(one, key), []).append(one)
    nameless = groups.pop("", [])
    if not groups:
        known = dict.fromkeys(
            [LAYER] * any(one.layer for one in features) + [k for one in features for k in one.properties]
        )
        if key in known:
            used = [other for other in known if any(_value(one, other) for one in features)]
            more = f"those with values: {', '.join(used)}" if used else "no property has values"
            raise CaseError(f"no feature has a value of the property {key!r}: name the regions by another one; {more}")
        raise CaseError(unknown("property", key, known) if known else "its features have no properties to name them by")
    notes = [f"left out: {counted(len(nameless), 'feature')} without {key}"] if nameless else []
    void = [name for name, members in groups.items() if all(one.is_empty for one in members)]
    if 0 < len(void) < len(groups):
        notes.append(f"left out: {counted(sum(len(groups.pop(name)) for name in void), 'empty feature')}")
    mend = None if selection.repair is None else selection.repair.mending(size)
    found, changes = list[Area](), list[RingChange]()
    for name, members in groups.items():
        _require_writable(members[0], name)
        with prefixed(f"region {name!r}"):
            bounds = bounding(members, joining_of(selection, size))
            areas = _areas_of(bounds, mend)
            changes += [change for area in areas for ring in area.rings for change in ring.changes]
            found += [replace(area, name=name) for area in areas]
        notes += bounds.notes
    if all(map(is_straight, found)):
        found = _uncovered(found) if ordered else found
        width = mend.gap if mend is not None and selection.join is None else selection.join
        found, notes = _matched(found, notes, width, "join" if selection.join else "repair.gap")
    if not changes:
        return found, notes
    first, *others = [area.mapped(lambda ring: replace(ring, changes=())) for area in found]
    return [replace(first, outer=replace(first.outer, changes=tuple(changes))), *others], notes


def named_points(features: Sequence[Feature], key: str) -> list[tuple[Point, str]]:
    """Points of features with the values of their property ``key``; none if others than points have such values.

    CaseError if a value cannot be a name.
    """
    named = [(one, name) for one in features if (name := _value(one, key))]
    if any(one.bounds or one.spare == REGION for one, _ in named):
        return []
    for one, name in named:
        _require_writable(one, name)
    return [(at, name) for one, name in named for at in one.points]


def _require_writable(feature: Feature, name: str) -> None:
    if not is_writable(name):
        raise CaseError(f"{feature.name}: {name[:40]!r} is no name of a region: it is too long or has {FORBIDDEN}")


def _areas_of(bounds: Bounding, mend: Repair | None) -> list[Area]:
    """Areas of one name by the nesting of its rings, mended if there is something that mends."""
    given = [Area(outer, tuple(holes)) for outer, *holes in bounds.areas]
    if mend is None:
        return areas_by_nesting(given, bounds.loose, None)
    # Of areas that overlap none is a hole of another one; rings within others are.
    return mend([*given, *areas_by_nesting([], bounds.loose, None)])


def largest_by_name(features: Sequence[Feature], key: str) -> dict[str, float]:
    """Largest areas of triangles that a file gives for its regions, by the names of `named_areas`.

    Of several regions with the same name the smallest value is used.
    """
    found: dict[str, float] = {}
    for one in features:
        if one.largest is not None:
            name = _value(one, key)
            found[name] = min(one.largest, found.get(name, one.largest))
    return found


def is_straight(area: Area) -> bool:
    """Whether an area has straight sides only."""
    return all(isinstance(side.curve, Line) for ring in area.rings for side in ring.sides)


def _value(feature: Feature, key: str) -> str:
    """Value of a feature's property as a name, empty if it has none."""
    value: Any = feature.properties.get(key, feature.layer if key == LAYER else None)
    if value is None or isinstance(value, list | dict):
        return ""
    return text_of_number(value) if isinstance(value, float) else str(value).strip()


def _matched(areas: list[Area], notes: list[str], join: float | None, key: str) -> tuple[list[Area], list[str]]:
    """Straight-sided areas with exactly shared borders; areas with the same name that share a border are united."""
    _require_valid(areas)
    areas = _wide(areas)
    names = [str(area.name) for area in areas]
    shapes, changed, told = matched(shapes_of(areas), names, join, key)
    members: dict[str, list[int]] = {}
    for number, name in enumerate(names):
        members.setdefault(name, []).append(number)
    found = list[Area]()
    for numbers in members.values():
        whole = shapes[numbers[0]] if len(numbers) == 1 else shapely.union_all(shapes[numbers])
        parts = shapely.get_parts(whole).tolist()
        if len(parts) == len(numbers) and not changed[numbers].any():
            found += [areas[number] for number in numbers]
        else:
            found += [_like(areas[numbers[0]], part) for part in parts]
    return found, [*notes, *told]


def _require_valid(areas: Sequence[Area]) -> None:
    """Check that rings are simple, and holes within them; GeometryError with the name of the region and the place."""
    for area in areas:
        for ring in area.rings:
            with prefixed(f"region {area.name!r}"):
                simple_polygon(ring.outline, ring.origin or "its ring")
    shapes = shapes_of(areas)
    for number in np.flatnonzero(~shapely.is_valid(shapes)).tolist():
        where = explained(shapes[number])[1]
        raise GeometryError(
            f"holes of region {areas[number].name!r} cross its ring or each other at {where}: move them"
        )


def _like(area: Area, shape: shapely.Polygon) -> Area:
    """The area of a polygon, with the name and the origin of another one, and its label if it has one only."""
    labels = {side.label for ring in area.rings for side in ring.sides}
    label = next(iter(labels)) if len(labels) == 1 else None
    return replace(_area(shape, label, area.outer.origin), name=area.name)


def _uncovered(areas: list[Area]) -> list[Area]:
    """Straight-sided areas without what later ones of other names cover of them."""
    _require_valid(areas)
    shapes, names = shapes_of(areas), [str(area.name) for area in areas]
    thin = TOUCHING * float(np.ptp(shapely.total_bounds(shapes).reshape(2, 2), axis=0).max())
    found, over = list[Area](), later_ones(shapes.tolist(), names, thin)
    for number, later in enumerate(over):
        left = polygons_of(shapely.difference(shapes[number], shapely.union_all(shapes[later]))) if later else []
        found += [_like(areas[number], part) for part in left] if later else [areas[number]]
    kept = {str(area.name) for area in found}
    require_all_left(names, kept, lambda k: (shapes[k], names[over[k][-1]], areas[k].outer.key))
    return found


def _wide(areas: list[Area]) -> list[Area]:
    """The areas but for parts of regions that are thinner than what a domain can have, if other parts are not."""
    shapes = shapes_of(areas)
    size = float(np.ptp(shapely.total_bounds(shapes).reshape(2, 2), axis=0).max())
    wide = shapely.area(shapes) > NEARLY * size * shapely.length(shapes) / 2
    named = {area.name for area, is_wide in zip(areas, wide.tolist(), strict=True) if is_wide}
    return [area for area, is_wide in zip(areas, wide.tolist(), strict=True) if is_wide or area.name not in named]


def _area(shape: shapely.Polygon, label: str | None = None, origin: str | None = None) -> Area:
    """The area of a polygon whose sides have one label, if any."""

    def ring(loop: shapely.LinearRing) -> Ring:
        return replace(rings.polygon(shapely.get_coordinates(loop).tolist(), label=label), origin=origin)

    return Area(ring(shape.exterior), tuple(map(ring, shape.interiors)))


def united(areas: Sequence[Area]) -> list[Area]:
    """The union of straight-sided areas, as areas."""
    shapes = shapes_of(areas)
    size = float(np.ptp(shapely.total_bounds(shapes).reshape(2, 2), axis=0).max())
    parts = _united(shapes, size)
    if shapely.STRtree(parts).query(parts, predicate="intersects").shape[1] > len(parts):
        rounded = _united(shapes, size, TOUCHING * size)
        parts = rounded if len(rounded) < len(parts) else parts  # some have a common side but for rounding
    order = np.argsort(-shapely.area(parts), kind="stable")
    return [_area(part) for part in parts[order]]


def _united(shapes: Shapes, size: float, grid: float | None = None) -> Shapes:
    """The parts of the union of polygons of a ``size`` together, by coordinates that are multiples of a ``grid``."""
    exact = grid is None and is_coverage(shapes)
    whole = shapely.coverage_union_all(shapes) if exact else shapely.union_all(shapes, grid_size=grid)
    return np.array(thick(whole, TOUCHING * size).geoms)  # where areas do not meet exactly there are flat holes
