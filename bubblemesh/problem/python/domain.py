"""Domains of Python programs, by their rings."""

from collections.abc import Mapping, Sequence
from typing import TypeAlias

import numpy as np
import shapely
from numpy.typing import ArrayLike

from bubblemesh.arrays import is_real
from bubblemesh.errors import CaseError
from bubblemesh.files import require_name
from bubblemesh.geometry.boundary import default_label
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.following import Following
from bubblemesh.geometry.paths import Area
from bubblemesh.messages import counted, meant
from bubblemesh.problem.python.inside import ProgramParts
from bubblemesh.problem.python.shapes import A_RING, ProgramPoints, Shape, areas_of, list_of, points_of
from bubblemesh.records import record

Geometry: TypeAlias = "Shape | Domain"
Labels: TypeAlias = Sequence[str] | Mapping[str, str]

A_GEOMETRY = f"a shapely.Polygon, a MultiPolygon, a Domain or {A_RING}"


@record(kw_only=True)
class ProgramRings:
    """Rings as a program gives them, what they are called, and whether they are followed as curves."""

    geometry: Geometry
    holes: Sequence[ArrayLike] = ()
    labels: Labels | None = None
    corners: float | None = None  # degrees
    smooth: bool = False
    tolerance: float | None = None
    inside: ProgramParts = ProgramParts()

    def domain(self) -> Domain:
        """The domain that the rings bound.

        CaseError if an argument is of the wrong kind or does not fit the others; GeometryError, about the argument, if
        the rings are empty or invalid.
        """
        following = self._following()
        if isinstance(self.geometry, Domain):
            self._require_nothing_else()
            return self.geometry
        areas = self._areas()
        names = iter(_names(self.labels, len(areas), sum(len(area) - 1 for area in areas)))
        outer = [next(names) for _ in areas]
        found = []
        for (first, *others), name in zip(areas, outer, strict=True):
            found.append(Area(first.ring(name), tuple(other.ring(next(names)) for other in others)))
        return Domain.with_matched_sides(*self.inside.within(found, following))

    def _areas(self) -> list[list[ProgramPoints]]:
        """Rings of each area, the outer one first."""
        holes = list_of(self.holes, "holes")
        areas = areas_of(self.geometry, "geometry", A_GEOMETRY)
        if not isinstance(self.geometry, shapely.Geometry):
            return [[*areas[0], *(points_of(hole, f"holes[{k}]") for k, hole in enumerate(holes))]]
        if len(holes):
            raise CaseError("holes: a shapely.Polygon has holes of its own: geometry.difference(hole) cuts another one")
        return areas

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
            "holes": len(list_of(self.holes, "holes")) > 0,
            "corners": self.corners is not None,
            **self.inside.given,
        }
        for name in (name for name, is_there in given.items() if is_there):
            raise CaseError(f"{name}: a Domain has {name} of its own: give them where its rings are made")


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
