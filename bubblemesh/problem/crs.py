"""Coordinate reference systems of a case, checked, and what they make of its spacing."""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace

import numpy as np

from bubblemesh import readers
from bubblemesh.arrays import Floats
from bubblemesh.case import Case
from bubblemesh.case.crs import CrsKeys
from bubblemesh.case.domain import DomainKeys, ShoreDomain
from bubblemesh.case.fields import several
from bubblemesh.case.spacing import NearLine, NearPoint, SpacingTerms
from bubblemesh.errors import CaseError, at_key, coarsened_by
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.paths import as_point
from bubblemesh.geometry.plane import Plane
from bubblemesh.geometry.systems import known_system
from bubblemesh.geometry.unprojection import Unprojection
from bubblemesh.problem.files import named_files, unit_of_files
from bubblemesh.problem.scale import SpacingAtScale
from bubblemesh.records import record
from bubblemesh.spacing.expression import DistanceTo, Expression, Rasters, names_in
from bubblemesh.spacing.spacing import Spacing

AUTO = "auto"
METRES_OF_DEGREE = 111_200.0  # of latitude
FARTHEST = 540.0, 100.0  # longitude and latitude, in degrees, that data reaches beyond which there are none


def require_known_systems(keys: CrsKeys) -> None:
    """Check the names of systems; CaseError with the key for one that is not known."""
    for key, name in (("from", keys.source), ("to", keys.to)):
        if name != AUTO or key == "from":
            with at_key("crs", key):
                known_system(name)


def on_the_ground(at: SpacingAtScale, plane: Plane, power: int = 1) -> SpacingAtScale:
    """A spacing request in the plane for one in metres on the ground; with a power of -1 the other way round."""

    def in_plane(scale: float | None) -> Spacing:
        given = at(scale)
        return replace(given, function=_Scaled(given.function, plane, power))

    return in_plane


@record
class _Scaled:
    """A function of the place times a power of the plane's scale there."""

    function: Callable[[Floats, Floats], Floats]
    plane: Plane
    power: int

    def __call__(self, x: Floats, y: Floats) -> Floats:
        return self.function(x, y) * self.plane.scale(x, y) ** self.power


def terms_in(plane: Plane, terms: SpacingTerms) -> SpacingTerms:
    """The terms with the places that they name in the plane."""
    if terms.near is None:
        return terms
    near = []
    for one in several(terms.near):
        if isinstance(one, NearPoint):
            one = one.model_copy(update={"point": as_point(plane.to(np.array([one.point], float))[0])})
        elif isinstance(one, NearLine):
            one = one.model_copy(update={"line": tuple(map(as_point, plane.line(np.array(one.line, float))[0]))})
        near.append(one)
    return terms.model_copy(update={"near": tuple(near)})


@record
class GivenPlaces:
    """A function of coordinates as they were given, as one of places in the plane."""

    function: Callable[[Floats, Floats], Floats]
    unprojection: Unprojection

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Values at x and y in the plane, in the arrays' common shape."""
        x, y = np.broadcast_arrays(x, y)
        return self.function(*self.unprojection(x.ravel(), y.ravel())).reshape(x.shape)


def bound_in(
    unprojection: Unprojection | None, expression: Expression, distance_to: DistanceTo, rasters: Rasters
) -> tuple[Callable[[Floats, Floats], Floats], Expression]:
    """An expression as a function of places in the domain, and with its values of distances and rasters.

    Where coordinates have been taken to a plane, its x and y and its rasters are those that were given. CaseError for
    one that has x or y and measures distances too, which are in metres.
    """
    if unprojection is None:
        term = expression.measuring(distance_to, rasters)
        return term, term
    used = names_in(expression.text)
    if not {"x", "y"} & used:
        term = expression.measuring(distance_to, {name: GivenPlaces(f, unprojection) for name, f in rasters.items()})
        return term, term
    if "distance" in used:
        raise CaseError("x and y, in the system of crs.from, and distance, in metres, do not go together: use near")
    term = expression.measuring(distance_to, rasters)
    return GivenPlaces(term, unprojection), term


def given_bounds(domain: Domain) -> tuple[float, float, float, float]:
    """Box (x0, y0, x1, y1) of a domain in the coordinates that were given."""
    if domain.plane is None:
        return domain.bounds
    points = domain.plane.given(domain.polygonal_copy.points)
    (x0, y0), (x1, y1) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    return x0, y0, x1, y1


def given_system(domain: Domain) -> str | None:
    """System of the coordinates that were given, if they were taken to a plane."""
    return None if domain.plane is None else domain.plane.source


def require_given(bounds: Sequence[float], domain: Domain) -> None:
    """Check that the box (x0, y0, x1, y1) of data can be one of longitudes and latitudes, if those were given.

    CaseError if not: data on a mesh of the case itself may be where this was written, in the plane.
    """
    plane = domain.plane
    if plane is None or not known_system(plane.source).is_geographic:
        return
    far = np.abs([each if np.isfinite(each) else 0.0 for each in bounds]).reshape(2, 2).max(axis=0)
    if (far > FARTHEST).any():
        x0, y0, x1, y1 = bounds
        raise CaseError(
            f"its data is in [{x0:.6g}, {x1:.6g}] x [{y0:.6g}, {y1:.6g}], which are no longitudes and latitudes: files "
            f"have the coordinates of crs.from, {plane.source}, and meshes are written in those of crs.to"
        )


def require_one_unit(keys: DomainKeys, domain: Domain, finest: float) -> None:
    """Check that a domain of maps without a system is no coast in degrees with sizes in metres; CaseError if it is.

    That is sure where all coordinates are in the range of degrees, and nowhere is the spacing as fine as twice the size
    of the domain. A file whose unit the case names is in no degrees.
    """
    if unit_of_files(keys) is None:
        _require_one_unit(keys, domain.bounds, finest)


def require_one_unit_in_box(keys: ShoreDomain, terms: SpacingTerms) -> None:
    """Check the same of a box in the sea before the shore is read, by the sizes that the spacing names."""
    if sizes := _plain_sizes(terms):
        _require_one_unit(keys, keys.box, min(sizes))


def sizes_in_metres(case: Case, box: Sequence[float]) -> AbstractContextManager[None]:
    """Have messages on too many nodes say that sizes are in metres, where the finest could be meant in degrees.

    That is if coordinates are degrees and the size is below the width of the domain's box (x0, y0, x1, y1) in these.
    """
    x0, y0, x1, y1 = box
    sizes = _plain_sizes(case.spacing_terms)
    if case.crs is None or not sizes or not known_system(case.crs.source).is_geographic:
        return nullcontext()
    if min(sizes) >= max(x1 - x0, y1 - y0):
        return nullcontext()
    metres = min(sizes) * METRES_OF_DEGREE
    length = f"{metres:.2g} m" if metres < 1000 else f"{metres / 1000:.2g} km"
    return coarsened_by(f"sizes are in metres ({min(sizes):g} degrees are about {length}): coarsen the spacing")


def _plain_sizes(terms: SpacingTerms) -> list[float]:
    """Sizes that the terms of a spacing give as numbers."""
    sizes = [near.size for near in several(terms.near)]
    return sizes + [value for value in (terms.value, terms.maximum) if isinstance(value, float)]


def _require_one_unit(keys: DomainKeys, bounds: tuple[float, float, float, float], finest: float) -> None:
    x0, y0, x1, y1 = bounds
    size = max(x1 - x0, y1 - y0)
    degrees = x0 >= -180 and x1 <= 360 and y0 >= -90 and y1 <= 90
    if not degrees or finest < 2 * size or not any(map(readers.is_of_maps, named_files(keys))):
        return
    with at_key("spacing"):
        raise CaseError(
            f"is {finest:g} where it is finest, and the whole domain {size:.4g} long: these are sizes in metres "
            "and coordinates in degrees: add crs: {from: EPSG:4326}"
        )
