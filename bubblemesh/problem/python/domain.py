"""Domains of Python programs: polygons of shapely, and rings as arrays of points."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np
import shapely
from numpy.typing import ArrayLike

from bubblemesh.arrays import Floats, is_real, unmasked
from bubblemesh.errors import CaseError, GeometryError, Key, about
from bubblemesh.files import require_name
from bubblemesh.geometry import rings
from bubblemesh.geometry.boundary import default_label
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.following import Following
from bubblemesh.geometry.paths import Area, Ring
from bubblemesh.messages import counted, meant
from bubblemesh.records import record

Geometry: TypeAlias = "shapely.Polygon | shapely.MultiPolygon | Domain | ArrayLike"
Labels: TypeAlias = Sequence[str] | Mapping[str, str]


ANY_GEOMETRY = "geometry: must be a shapely.Polygon, a MultiPolygon, a Domain or the points (n, 2) of a ring"


@record
class ProgramRings:
    """Rings as a program gives them, what they are called, and whether they are followed as curves."""

    geometry: Geometry
    holes: Sequence[ArrayLike] = ()
    labels: Labels | None = None
    corners: float | None = None  # degrees
    smooth: bool = False
    tolerance: float | None = None

    def domain(self) -> Domain:
        """The domain that the rings bound.

        CaseError if an argument is of the wrong kind or does not fit the others; GeometryError, about the argument, if
        the rings are empty or invalid.
        """
        following = self._following()
        if isinstance(self.geometry, Domain):
            self._require_nothing_else()
            return self.geometry
        areas = _areas(self.geometry, self.holes)
        names = iter(_names(self.labels, len(areas), sum(len(area) - 1 for area in areas)))
        outer = [next(names) for _ in areas]
        found = []
        for (first, *others), name in zip(areas, outer, strict=True):
            found.append(Area(first.ring(name, following), tuple(o.ring(next(names), following) for o in others)))
        return Domain.of_areas(found)

    def _following(self) -> Following | None:
        """Rule by which rings are followed as curves, if they are."""
        if not isinstance(self.smooth, bool | np.bool_):
            raise CaseError(f"smooth: must be true or false (found {self.smooth!r})")
        if self.corners is None:
            for name, given in (("smooth", self.smooth), ("tolerance", self.tolerance is not None)):
                if given:
                    raise CaseError(f"{name}: needs corners: give the angle above which vertices stay nodes")
            return None
        if not is_real(self.corners) or not 0 <= self.corners <= 180:
            raise CaseError(f"corners: must be an angle from 0 to 180 degrees (found {self.corners!r})")
        if self.tolerance is not None and not (is_real(self.tolerance) and 0 < self.tolerance < np.inf):
            raise CaseError(f"tolerance: must be a length greater than 0 (found {self.tolerance!r})")
        return Following(float(self.corners), bool(self.smooth), self.tolerance)

    def _require_nothing_else(self) -> None:
        """Refuse arguments on rings beside a domain, which has all of that."""
        given = {
            "labels": self.labels is not None,
            "holes": len(_sequence(self.holes)) > 0,
            "corners": self.corners is not None,
        }
        for name in (name for name, is_there in given.items() if is_there):
            raise CaseError(f"{name}: a Domain has {name} of its own: give them where its rings are made")


@record
class _Points:
    """Points (m, 2) of a ring, and the argument that has it."""

    points: Floats
    argument: str

    def ring(self, label: str | None, following: Following | None) -> Ring:
        """The ring through the points, followed as a curve if there is a rule."""
        with about(Key([self.argument])):
            ring = replace(rings.polygon(self.points.tolist(), label=label), key=Key([self.argument]))
            return ring if following is None else following(ring)


def _areas(geometry: Geometry, holes: Sequence[ArrayLike]) -> list[list[_Points]]:
    """Rings of each area, the outer one first."""
    if not isinstance(geometry, shapely.Geometry):
        outer = _array(geometry, "geometry")
        return [[outer, *(_array(hole, f"holes[{k}]") for k, hole in enumerate(_sequence(holes)))]]
    if len(_sequence(holes)):
        raise CaseError("holes: a shapely.Polygon has holes of its own: geometry.difference(hole) cuts another one")
    single = isinstance(geometry, shapely.Polygon)
    return [_rings(part, "geometry" if single else f"geometry.geoms[{k}]") for k, part in _polygons(geometry)]


def _sequence(holes: Any) -> "Sequence[Any] | Floats":
    """Holes, one after the other; CaseError if they are not a list of rings."""
    if not isinstance(holes, Sequence | np.ndarray):
        raise CaseError(f"holes: must be a list of rings, arrays (n, 2) of points (found {type(holes).__name__})")
    return holes


def _rings(polygon: shapely.Polygon, argument: str) -> list[_Points]:
    named = [(polygon.exterior, f"{argument}.exterior")]
    named += [(hole, f"{argument}.interiors[{k}]") for k, hole in enumerate(polygon.interiors)]
    return [_array(shapely.get_coordinates(ring), name) for ring, name in named]


def _polygons(geometry: shapely.Geometry) -> list[tuple[int, shapely.Polygon]]:
    """Polygons that a shape consists of, with their numbers in it."""
    if not isinstance(geometry, shapely.Polygon | shapely.MultiPolygon):
        raise CaseError(f"{ANY_GEOMETRY} (found {type(geometry).__name__})")
    parts: Iterable[tuple[int, Any]] = enumerate(shapely.get_parts(geometry).tolist())
    polygons = [(k, polygon) for k, polygon in parts if not polygon.is_empty]
    if not polygons:
        raise GeometryError("the polygon is empty")
    return polygons


def _array(points: Any, argument: str) -> _Points:
    """Points of a ring; CaseError if they are no finite numbers (n, 2)."""
    expected = ANY_GEOMETRY if argument == "geometry" else f"{argument}: must be the points (n, 2) of a ring"
    try:
        given = np.asarray(unmasked(points))
    except ValueError:  # rows of unequal length
        raise CaseError(f"{expected} (found rows of unequal length)") from None
    if given.dtype.kind not in "iuf":
        is_array = given.ndim > 0 and isinstance(points, np.ndarray)
        found = f"an array of {given.dtype}: astype(float) makes numbers of it" if is_array else type(points).__name__
        raise CaseError(f"{expected} (found {found})")
    if given.ndim != 2 or given.shape[1] != 2:
        raise CaseError(f"{expected} (found the shape {given.shape})")
    given = given.astype(float)  # the limit is no number of smaller types
    rings.require_numbers(given, argument)
    return _Points(given, argument)


def _names(labels: Labels | None, areas: int, holes: int) -> Sequence[str | None]:
    """A name for each ring, those of the outer ones first, or None where the usual one is meant."""
    if labels is None:
        return [None] * (areas + holes)
    if isinstance(labels, Mapping):
        usual = [default_label(ring, areas) for ring in range(areas + holes)]
        for name in labels:
            if name not in usual:
                raise CaseError(f"labels: there is no ring {name!r}: {meant(str(name), usual)}")
        return [require_name(labels[name], "labels") if name in labels else None for name in usual]
    if not isinstance(labels, Sequence | np.ndarray) or isinstance(labels, str):  # a set has no order
        raise CaseError(
            f"labels: must be a list of names, one for each ring, or a mapping such as {{'hole-1': 'bore'}} "
            f"(found {labels!r})"
        )
    names = list(labels)
    if len(names) != areas + holes:
        given = counted(len(names), "label")
        raise CaseError(f"labels: must be one for each ring: {given} for {counted(areas + holes, 'ring')}")
    return [require_name(name, "labels") for name in names]
