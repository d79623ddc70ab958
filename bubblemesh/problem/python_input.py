"""Input of Python programs: polygons of shapely and spacings of their own, checked."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import shapely

from bubblemesh.arrays import Floats
from bubblemesh.case.spacing import checked_terms
from bubblemesh.errors import CaseError, GeometryError
from bubblemesh.files import FORBIDDEN, is_writable
from bubblemesh.geometry import rings
from bubblemesh.geometry.distance.distances import distance_to_labels
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.paths import Area, Ring
from bubblemesh.problem.spacing import SpacingRequest, spacing_request
from bubblemesh.spacing.expression import Expression
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.terms.combination import Combination, Term, costly


def polygon_domain(geometry: shapely.Polygon | shapely.MultiPolygon | Domain, labels: Sequence[str] | None) -> Domain:
    """The domain that polygons are, with names for their rings: first for the outer ones, then for the holes.

    It is a CaseError if the geometry is none or the labels do not fit its rings, a GeometryError if the polygons are
    empty or invalid.
    """
    if isinstance(geometry, Domain):
        if labels is not None:
            raise CaseError("labels: a Domain has labels of its own: name its rings where they are made")
        return geometry
    polygons = _polygons(geometry)
    if not np.isfinite(shapely.get_coordinates(polygons)).all():
        raise CaseError("geometry: has a coordinate that is no number")
    holes = [len(polygon.interiors) for polygon in polygons]
    names = _names(labels, len(polygons) + sum(holes))
    hole_names = iter(names[len(polygons) :])
    return Domain.of_areas(
        [
            Area(_ring(polygon.exterior, name), tuple(_ring(hole, next(hole_names)) for hole in polygon.interiors))
            for polygon, name in zip(polygons, names[: len(polygons)], strict=True)
        ]
    )


def _ring(loop: shapely.LinearRing, label: str | None) -> Ring:
    return rings.polygon(shapely.get_coordinates(loop).tolist(), label=label)


def _polygons(geometry: Any) -> list[shapely.Polygon]:
    """Polygons that a shape consists of."""
    if not isinstance(geometry, shapely.Polygon | shapely.MultiPolygon):
        kind = type(geometry).__name__
        raise CaseError(
            "geometry: must be a shapely.Polygon, a MultiPolygon or a Domain "
            f"(found {kind}): shapely.Polygon(points) makes one"
        )
    polygons = [polygon for polygon in shapely.get_parts(geometry).tolist() if not polygon.is_empty]
    if not polygons:
        raise GeometryError("the polygon is empty")
    return polygons


def _names(labels: Sequence[str] | None, count: int) -> Sequence[str | None]:
    """A name for each ring, or None where the usual one is meant."""
    if labels is None:
        return [None] * count
    if isinstance(labels, str):
        raise CaseError(f"labels: must be a list of names, one for each ring (found {labels!r}): use [{labels!r}]")
    if len(labels) != count:
        raise CaseError(f"labels: must be one for each ring: {len(labels)} labels for {count} rings")
    for name in labels:
        if not isinstance(name, str) or not is_writable(name):
            raise CaseError(f"labels: {name!r} is no name: use short texts without {FORBIDDEN}")
    return labels


def spacing_of(
    spacing: float | str | Mapping[str, Any] | Callable[[Floats, Floats], Any], domain: Domain
) -> SpacingRequest:
    """The spacing, whose values are checked, and its rules; CaseError where it is none of the four."""
    if isinstance(spacing, Mapping):
        return spacing_request(checked_terms(spacing), domain)
    term: Term = _Checked(spacing) if callable(spacing) else _expression(spacing, domain)
    return SpacingRequest(partial(_scaled, term))


def _scaled(term: Term, scale: float | None) -> Spacing:
    scaled = term if scale is None else Combination((Spacing(term),), scale)
    return Spacing(scaled, costly=costly(scaled))


def _expression(spacing: float | str, domain: Domain) -> Expression:
    if not isinstance(spacing, str):
        value = np.asarray(spacing)
        if value.ndim > 0 or value.dtype.kind not in "iuf":
            raise CaseError(
                "spacing: must be a number, an expression in x and y, a mapping of terms, or a function of x and y"
            )
        if not np.isfinite(value):
            raise CaseError(f"spacing: is {value}: it has to be positive and finite")
        spacing = repr(float(value))
    try:
        return Expression.parse(spacing, distance_to=partial(distance_to_labels, domain))
    except CaseError as error:
        raise CaseError(f"spacing: {error}") from None


class _Checked:
    """A function of the user's that has to take and return arrays."""

    def __init__(self, function: Callable[[Floats, Floats], Any]) -> None:
        self.function = function

    def __call__(self, x: Floats, y: Floats) -> Floats:
        if len(x) == 0:  # which many functions do not expect
            return np.zeros(0)
        try:
            with np.errstate(all="ignore"):
                values = np.asarray(self.function(x, y))
        except (TypeError, ValueError) as error:
            raise CaseError(
                f"spacing: the function fails for arrays of coordinates ({error}): it has to take many points at once, "
                "by NumPy's functions, with np.where in place of if, or by np.vectorize, which is slow"
            ) from error
        if values.dtype.kind not in "iuf":
            raise CaseError(f"spacing: the function gives values of type {values.dtype}: they have to be real numbers")
        if values.shape not in ((), x.shape):
            raise CaseError(
                f"spacing: the function gives an array of shape {values.shape} for {len(x)} points: it has to give one "
                "value for each"
            )
        return np.broadcast_to(values, x.shape).astype(float)
