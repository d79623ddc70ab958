"""Regions, lines and points inside the domains of Python programs, by their names."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np
import shapely
from numpy.typing import ArrayLike

from bubblemesh.arrays import Floats, is_real
from bubblemesh.errors import CaseError, Key, about
from bubblemesh.files import require_name
from bubblemesh.geometry.arrangement.covering import covered
from bubblemesh.geometry.arrangement.regions import InnerParts, Region, Seed
from bubblemesh.geometry.following import Following, all_followed
from bubblemesh.geometry.paths import Area, InnerPoint, OpenPath, as_point
from bubblemesh.geometry.rings import LineTo, open_path
from bubblemesh.problem.python.shapes import Shape, areas_of, lines_of, some_points_of
from bubblemesh.records import record

Regions: TypeAlias = Mapping[str, "Shape | shapely.Point | shapely.MultiPoint"]
Lines: TypeAlias = Mapping[str, "shapely.LineString | shapely.MultiLineString | ArrayLike"]
Points: TypeAlias = Mapping[str, "shapely.Point | shapely.MultiPoint | ArrayLike"]

OVERLAPS = "refused", "later"
POINTS = shapely.Point | shapely.MultiPoint
A_REGION = "a shapely.Polygon, a MultiPolygon, the points (n, 2) of a ring, or a shapely.Point or MultiPoint in it"
A_LINE = "a shapely.LineString, a MultiLineString or the points (n, 2) of a line, n > 1"
SOME_POINTS = "a point (x, y), several of them (n, 2), or those of shapely"


@record(kw_only=True)
class ProgramParts:
    """What a program embeds in a domain; several parts of a shape have one name."""

    regions: Regions | None = None
    lines: Lines | None = None
    points: Points | None = None
    overlaps: str = "refused"
    periodic: Sequence[tuple[str, str]] = ()
    periodic_tolerance: float | None = None

    @property
    def given(self) -> dict[str, bool]:
        """Whether there is anything, by the argument."""
        given = {name: getattr(self, name) is not None for name in ("regions", "lines", "points")}
        return {**given, "overlaps": self.overlaps != OVERLAPS[0], "periodic": len(self.periodic) > 0}

    def within(self, areas: Sequence[Area], follow: Following | None) -> tuple[Sequence[Area], InnerParts]:
        """The areas of a domain, and the inner parts; rings and lines are followed as curves if there is a rule.

        CaseError if an argument is of the wrong kind; GeometryError, about the argument, if it is empty or invalid.
        """
        if self.overlaps not in OVERLAPS:
            raise CaseError(f"overlaps: must be {OVERLAPS[0]!r} or {OVERLAPS[1]!r} (found {self.overlaps!r})")
        regions, lines = self._regions(), self._lines()
        if follow is not None:
            areas, regions, lines = all_followed(follow, areas, regions, lines)
        entry = {name: number for number, name in enumerate(self.regions or ())}
        named = [Region(area, str(area.name), f"{area.name}-rim", entry[str(area.name)]) for area in regions]
        if self.overlaps == "later":
            named = covered(named, [area.outer for area in areas])
        points, seeds = tuple(self._points()), tuple(self._seeds())
        parts = InnerParts(tuple(named), lines=tuple(lines), points=points, seeds=seeds)
        return areas, replace(parts, periodic=self._pairs(), periodic_tolerance=self._tolerance())

    def _pairs(self) -> tuple[tuple[str, str], ...]:
        """Pairs of periodic sides, checked."""
        pairs = list[tuple[str, str]]()
        for pair in self.periodic:
            if isinstance(pair, str) or len(pair) != 2 or not all(isinstance(name, str) for name in pair):
                raise CaseError(f"periodic: must be pairs of labels, as [('left', 'right')] (found {pair!r})")
            pairs.append((pair[0], pair[1]))
        return tuple(pairs)

    def _tolerance(self) -> float:
        """Length by which periodic sides may differ, checked."""
        given = self.periodic_tolerance
        if given is not None and not (is_real(given) and 0 < given < np.inf):
            raise CaseError(f"periodic_tolerance: must be a length greater than 0 (found {given!r})")
        return float(given or 0.0)

    def _regions(self) -> list[Area]:
        areas = list[Area]()
        for name, shape in _named("regions", self.regions):
            if name == InnerParts().rest:
                raise CaseError(f"regions: {name!r} is the name of what regions leave of the domain: rename it")
            if isinstance(shape, POINTS):
                continue
            for outer, *holes in areas_of(shape, f"regions[{name!r}]", A_REGION):
                areas.append(Area(outer.ring(None), tuple(hole.ring(None) for hole in holes), name))
        return areas

    def _seeds(self) -> list[Seed]:
        """Points in regions that lines and rings enclose around them."""
        found = list[Seed]()
        for number, (name, shape) in enumerate(_named("regions", self.regions)):
            if isinstance(shape, POINTS):
                argument = f"regions[{name!r}]"
                points = some_points_of(shapely.get_coordinates(shape), argument, SOME_POINTS, "point").points
                found += [Seed(as_point(point), name, Key([argument]), number) for point in points]
        return found

    def _lines(self) -> list[OpenPath]:
        return [
            _path(part.points, name, part.argument)
            for name, shape in _named("lines", self.lines)
            for part in lines_of(shape, f"lines[{name!r}]", A_LINE)
        ]

    def _points(self) -> list[InnerPoint]:
        found = []
        for name, given in _named("points", self.points):
            argument = f"points[{name!r}]"
            array = shapely.get_coordinates(given) if isinstance(given, shapely.Geometry) else given
            one = np.ndim(array) == 1 and np.size(array) == 2
            places = some_points_of([array] if one else array, argument, SOME_POINTS, "point").points
            found += [InnerPoint(as_point(place), name, Key([argument])) for place in places]
        return found


def _named(argument: str, shapes: Any) -> list[tuple[str, Any]]:
    """Names and shapes; CaseError if they are no mapping, or a name is none."""
    if shapes is None:
        return []
    if not isinstance(shapes, Mapping):
        raise CaseError(f"{argument}: must be a mapping of names to shapes (found {type(shapes).__name__})")
    return [(require_name(name, argument), shape) for name, shape in shapes.items()]


def _path(points: Floats, label: str, argument: str) -> OpenPath:
    """The line through points (n, 2)."""
    start, *ends = map(as_point, points)
    with about(Key([argument])):
        return replace(open_path(start, [LineTo(end) for end in ends], label), key=Key([argument]))
