"""Repair of areas: mended, without small parts, or with fewer vertices, if a case asks for it.

Rings without changes stay as they are, with their curves. Changed rings follow their polygonal copies, with the labels
of the original sides; nodes may slide along parts that were curves. The changes are recorded in the rings.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import chain

import numpy as np
import shapely
from numpy.typing import NDArray

from bubblemesh.arrays import Booleans, Floats, ring_area
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.area_detail import (
    changed_areas,
    require_beside_each_other,
    simplified_areas,
    without_small,
    without_small_neighbours,
)
from bubblemesh.geometry.curves import shares_before
from bubblemesh.geometry.gaps import strips_between
from bubblemesh.geometry.near_vertices import blunted
from bubblemesh.geometry.nesting import made_valid, polygons_of, shapes_of, thick, with_holes
from bubblemesh.geometry.paths import Area, Ring, as_point
from bubblemesh.geometry.repair_work import Work, outer_points
from bubblemesh.geometry.validity import fault_place
from bubblemesh.messages import counted
from bubblemesh.records import record

GAP = 1e-4  # of the size of all areas: widest gap that is closed unless another one is given
THIN = 1e-6  # of that size: vertices nearer to each other, and parts that are thinner, are left by cuts only
OVERLAP = 1e-9  # of that size: so far a strip that closes a gap reaches into what is beside it
OFF_LINE = 100  # times that length: a vertex so near to the line between its neighbours is due to such a strip


@record
class Repair:
    """Changes that a case asks for of its areas."""

    mend: bool = False  # rings that cross or touch themselves or each other, areas that overlap or nearly touch
    gap: float | None = None  # widest gap to close, if it is not `GAP` of the size
    smallest: float | None = None  # area below which islands and holes are left out
    simplify: float | None = None  # length below which detail is left out

    @property
    def asked(self) -> bool:
        """Whether there is anything to change."""
        return self.mend or self.smallest is not None or self.simplify is not None

    def gap_of(self, size: float) -> float:
        """Widest gap to close in what has some size."""
        return GAP * size if self.gap is None else self.gap

    def mending(self, size: float) -> "Repair | None":
        """The part of it that mends a few of the areas, which have some size together; None if it does not mend."""
        return Repair(mend=True, gap=self.gap_of(size)) if self.mend else None

    def __call__(self, areas: Sequence[Area], holes: Sequence[Ring] = (), united: bool = True) -> list[Area]:
        """The areas after the repair, with common ``holes`` cut out of them; the first ring has the changes.

        With ``united``, areas that overlap become one. GeometryError if nothing is left.
        """
        work = Work(tuple(ring for area in areas for ring in (*area.rings,)) + tuple(holes))
        shapes = list(shapes_of(areas))
        if self.mend:
            shapes = [
                shape if shape.is_valid else _mended(area, work) for area, shape in zip(areas, shapes, strict=True)
            ]
            parts = [polygons_of(shape) for shape in shapes]
            shapes = _united(parts, self.gap_of(work.size), work) if united else list(chain(*parts))
            shapes = _without(shapes, holes, work)
            shapes = [part for shape in shapes for part in _with_holes_joined(shape, self.gap_of(work.size), work)]
        if self.smallest is not None:
            shapes = without_small(shapes, self.smallest, work)
        if self.simplify is not None and shapes:
            shapes = simplified_areas(shapes, self.simplify, work)
        if not shapes:
            raise GeometryError(f"nothing is left of {counted(len(areas), 'area')} after the repair: keep larger parts")
        if not work.changes:
            return with_holes(areas, holes)
        return work.told([work.area(shape, areas[0].name) for shape in shapes])

    def of_neighbours(self, areas: Sequence[Area]) -> list[Area]:
        """Areas with names and exactly shared borders, without small ones and with fewer vertices.

        What is left out becomes part of a neighbour (see `absorbed`). Nothing is mended here, since that may change
        borders. The first ring has the changes. GeometryError if nothing is left.
        """
        work = Work(tuple(ring for area in areas for ring in area.rings))
        shapes, names = list(shapes_of(areas)), [str(area.name) for area in areas]
        if self.smallest is not None:
            shapes, names = without_small_neighbours(shapes, names, self.smallest, work)
        if self.simplify is not None and shapes:
            require_beside_each_other(shapes, names)
            given, shapes = shapes, simplified_areas(shapes, self.simplify, work)
            work.notes += changed_areas(given, shapes, names)
        if not shapes:
            raise GeometryError(f"nothing is left of {counted(len(areas), 'area')} after the repair: keep larger parts")
        if not work.changes:
            return list(areas)
        labels = _labels(areas)
        return work.told([_labelled(work.area(*row), labels[row[1]]) for row in zip(shapes, names, strict=True)])


def _labels(areas: Sequence[Area]) -> dict[str, set[str | None]]:
    """Labels of the sides of areas, by the names of these."""
    found: dict[str, set[str | None]] = {}
    for area in areas:
        found.setdefault(str(area.name), set()).update(side.label for ring in area.rings for side in ring.sides)
    return found


def _labelled(area: Area, labels: set[str | None]) -> Area:
    """The area with the one label that its sides had before, if it was one: a neighbour's side may be as near."""
    if len(labels) > 1:
        return area
    (label,) = labels
    return area.mapped(lambda ring: replace(ring, sides=tuple(side._replace(label=label) for side in ring.sides)))


def _enclosed(ring: Ring, work: Work) -> shapely.Geometry:
    """The area that a ring encloses: all places around which it turns, however often."""
    points = ring.outline
    polygon = shapely.Polygon(points)
    if polygon.is_valid:
        return polygon
    given = abs(ring_area(points))
    fixed = _tidy(made_valid(polygon), work)
    work.note("ring that crosses or touches itself", fault_place(polygon), fixed.area - given, [points])
    return fixed


def _tidy(shape: shapely.Geometry, work: Work) -> shapely.Geometry:
    """A shape without thin parts, spikes, and vertices next to others, which cuts may leave."""
    thin = THIN * work.size
    whole = thick(shape, thin)
    sparse = thick(_gathered(shapely.remove_repeated_points(whole, thin), work), thin)
    loops = [
        [blunted(shapely.get_coordinates(ring)[:-1], thin) for ring in shapely.get_rings(part)] for part in sparse.geoms
    ]
    blunt = shapely.MultiPolygon([(outer, holes) for outer, *holes in loops])
    return next((better for better in (blunt, sparse) if better.is_valid), whole)


def _gathered(shape: shapely.Geometry, work: Work) -> shapely.Geometry:
    """A shape with neighbouring vertices moved to one place, that of a vertex of the original rings if there is one.

    Cuts that meet in a point differ there by rounding, and rings that do not quite touch would not bound a domain.
    """
    points, number = np.unique(shapely.get_coordinates(shape), axis=0, return_inverse=True)
    places = shapely.points(points)
    i, j = shapely.STRtree(places).query(places, predicate="dwithin", distance=THIN * work.size)
    if len(i) == len(points):
        return shape
    strange = np.array([as_point(point) not in work.vertices for point in points])
    order = np.lexsort((j, strange[j], i))
    best = j[order][np.flatnonzero(np.diff(i[order], prepend=-1))]
    moved = shapely.transform(shape, lambda _: points[best[number.ravel()]])
    return made_valid(moved)


def _mended(area: Area, work: Work) -> shapely.Geometry:
    """The polygons of an area whose rings are not valid."""
    return _cut(_enclosed(area.outer, work), area.holes, work)


def _without(shapes: Sequence[shapely.Polygon], holes: Sequence[Ring], work: Work) -> list[shapely.Polygon]:
    """The polygons without holes."""
    if not holes or not shapes:
        return list(shapes)
    whole = shapes[0] if len(shapes) == 1 else shapely.MultiPolygon(list(shapes))
    return polygons_of(_cut(whole, holes, work))


def _cut(shape: shapely.Geometry, holes: Sequence[Ring], work: Work) -> shapely.Geometry:
    """A shape without holes; holes outside are left out. All but separate holes inside are noted as changes."""
    if not holes:
        return shape
    solid = np.array([_enclosed(hole, work) for hole in holes], dtype=object)
    shapely.prepare(shape)
    rim = shapely.boundary(shape)
    apart, inside = shapely.disjoint(solid, shape), shapely.contains(shape, solid)
    across = ~apart & (~inside | (shapely.length(shapely.intersection(shapely.boundary(solid), rim)) > 0))
    for k in np.flatnonzero(apart).tolist():
        work.note("hole outside the area left out", holes[k].outline[0], 0.0, [holes[k].outline])
    for k in np.flatnonzero(across).tolist():
        beyond = shapely.difference(solid[k], shape)
        where = shapely.get_coordinates(shapely.intersection(shapely.boundary(solid[k]), rim))
        at = where[0] if len(where) else holes[k].outline[0]
        work.note("hole across the outer ring cut off there", at, beyond.area, [holes[k].outline])
    i, j = shapely.STRtree(solid).query(solid, predicate="intersects")
    for a, b in zip(i[i < j].tolist(), j[i < j].tolist(), strict=True):
        common = shapely.intersection(solid[a], solid[b])
        if common.area > 0 or common.length > 0:
            at = shapely.get_coordinates(shapely.point_on_surface(common))[0]
            what = "holes that overlap united" if common.area > 0 else "holes with a common side united"
            work.note(what, at, common.area, [holes[a].outline, holes[b].outline])
    left = shapely.difference(shape, shapely.union_all(solid[~apart]))
    return _tidy(left, work) if across.any() else left


def _united(areas: Sequence[Sequence[shapely.Polygon]], gap: float, work: Work) -> list[shapely.Polygon]:
    """Polygons of several areas, with those united that overlap, have a common side, or leave a narrow gap.

    The pieces of one area stay separate: they touch where its ring crosses itself, and there is no gap.
    """
    found = np.array(list(chain(*areas)), dtype=object)
    area = np.repeat(np.arange(len(areas)), list(map(len, areas)))
    if len(found) < 2:
        return list(found)
    i, j = shapely.STRtree(found).query(found, predicate="intersects")
    i, j = i[i < j], j[i < j]
    common = shapely.intersection(found[i], found[j])
    meeting = (shapely.area(common) > 0) | (shapely.length(common) > 0)
    for k in np.flatnonzero(meeting):
        what = "areas that overlap united" if common[k].area > 0 else "areas with a common side united"
        at = shapely.get_coordinates(shapely.point_on_surface(common[k]))[0]
        work.note(what, at, -common[k].area, map(outer_points, (found[i[k]], found[j[k]])))
    owners = [{number} for number in area.tolist()]
    if meeting.any():
        inside = shapely.point_on_surface(found)
        found = np.array(polygons_of(_tidy(shapely.union_all(found), work)), dtype=object)
        part, whole = shapely.STRtree(found).query(inside, predicate="intersects")
        owners = [set(area[part[whole == number]].tolist()) for number in range(len(found))]
    closing = _closing(found, owners, gap, work)
    if not closing:
        return list(found)
    return _without_steps(polygons_of(_tidy(shapely.union_all([*found, *closing]), work)), closing, gap, work)


def _closing(
    polygons: "NDArray[np.object_]", owners: Sequence[set[int]], gap: float, work: Work, holes: bool = False
) -> list[shapely.Polygon]:
    """The strips that close gaps between polygons (n,), areas or holes, which are noted as changes."""
    what = "gap between holes closed" if holes else "gap between areas closed"
    closing = []
    for strip, reaching in strips_between(polygons, owners, gap, OVERLAP * work.size):
        at = shapely.get_coordinates(shapely.point_on_surface(strip))[0]
        work.note(what, at, -strip.area if holes else strip.area, [outer_points(strip)])
        closing.append(reaching)
    return closing


def _with_holes_joined(shape: shapely.Polygon, gap: float, work: Work) -> list[shapely.Polygon]:
    """The polygon with gaps between its holes closed; several if holes come to lie around a part of it."""
    holes = np.array([shapely.Polygon(ring) for ring in shape.interiors], dtype=object)
    closing = _closing(holes, [{k} for k in range(len(holes))], gap, work, holes=True)
    if not closing:
        return [shape]
    solid = polygons_of(_tidy(shapely.union_all([*holes, *closing]), work))
    joined = shapely.union_all(_without_steps(solid, closing, gap, work))
    return polygons_of(shapely.difference(shapely.Polygon(shape.exterior), joined))


def _without_steps(
    shapes: Sequence[shapely.Polygon], closing: Sequence[shapely.Polygon], gap: float, work: Work
) -> list[shapely.Polygon]:
    """The polygons without edges as short as the gaps that strips have closed, which their ends leave."""
    counts = Counter(chain(*(map(as_point, outer_points(shapely.Polygon(ring))) for ring in shapely.get_rings(shapes))))
    strips = shapely.union_all(closing)
    found = []
    for shape in shapes:
        loops = []
        for ring in (shape.exterior, *shape.interiors):
            points = shapely.get_coordinates(ring)[:-1]
            alone = np.array([counts[as_point(point)] == 1 for point in points])
            loose = alone & shapely.dwithin(shapely.points(points), strips, gap)
            loops.append(_smoothed(points, loose, gap, work) if loose.any() else points)
        smooth = shapely.Polygon(loops[0], loops[1:])
        found.append(smooth if smooth.is_valid else shape)
    return found


def _smoothed(points: Floats, loose: Booleans, gap: float, work: Work) -> Floats:
    """Points (m, 2) of a ring without those of the ``loose`` ones that sides nearly pass, or beside which one is short.

    None of them is farther than a gap from the side that is left, and labels of longer sides stay.
    """
    labels = np.array(work.labels(points), dtype=object)  # of the sides from the points
    while len(points) > 3:
        before, after = np.roll(points, 1, axis=0), np.roll(points, -1, axis=0)
        off = np.hypot(*(points - before - shares_before(points, before, after)[:, None] * (after - before)).T)
        to_next = np.hypot(*(after - points).T)
        to_last = np.roll(to_next, 1)
        straight = (off <= OFF_LINE * OVERLAP * work.size) & (labels == np.roll(labels, 1))
        short = (np.minimum(to_next, to_last) <= gap) & (off <= gap)
        spare = loose & (straight | short)
        if not spare.any():
            break
        k = int(np.argmin(np.where(spare, off, np.inf)))
        labels[k - 1] = labels[k - 1] if to_last[k] > to_next[k] else labels[k]
        points, loose, labels = np.delete(points, k, axis=0), np.delete(loose, k), np.delete(labels, k)
    return points
