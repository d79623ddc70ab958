"""Coordinate reference systems: what names mean, coordinates of one in another, and whether points are in one."""

from functools import cache
from typing import Any

import numpy as np

from bubblemesh.arrays import Booleans, Floats
from bubblemesh.errors import CaseError, FileError

DEGREES = "EPSG:4326"
NEAREST_POLE = 89.0  # degrees of latitude
WIDEST = 180.0  # degrees of longitude
HALF_TURN = 180.0
LARGEST_PLACE = 1e9  # coordinates of any system, degrees, metres or feet: larger ones are no place on the earth
FARTHEST = 2 * HALF_TURN, 90.0  # degrees of longitude and latitude; maps across the date line go on beyond 180
SAME_PLACE = 5.0  # metres, by which WGS 84, ETRS89 and NAD83 differ at most


def crs_library() -> Any:
    """The library of coordinate reference systems; FileError, with the command that installs it, if it is missing."""
    try:
        import pyproj
    except ModuleNotFoundError:
        raise FileError('crs: pyproj is needed: pip install "bubblemesh[geo]"') from None
    return pyproj


@cache
def known_system(name: str) -> Any:
    """A coordinate reference system by its name, such as EPSG:4326; CaseError if it has no places on the earth."""
    pyproj = crs_library()
    try:
        system = pyproj.CRS.from_user_input(name)
    except pyproj.exceptions.CRSError:
        raise CaseError(f"{name!r} is no known coordinate reference system: give one as EPSG:4326") from None
    if not (system.is_geographic or system.is_projected):
        raise CaseError(f"{name!r} is no system of longitude and latitude, nor a projection of these: give another one")
    return system


def same_system(first: str, second: str) -> bool:
    """Whether two names mean the same system, apart from the order of its axes."""
    return bool(known_system(first).equals(known_system(second), ignore_axis_order=True))


@cache
def _transformer(source: str, target: str) -> Any:
    return crs_library().Transformer.from_crs(known_system(source), known_system(target), always_xy=True)


def transformed(source: str, target: str, points: Floats) -> Floats:
    """Coordinates (n, 2) in the target system of points (n, 2) in the source system; infinite where there are none."""
    if source == target:
        return points
    return np.column_stack(_transformer(source, target).transform(points[:, 0], points[:, 1]))


def same_places(first: str, second: str, points: Floats) -> bool:
    """Whether points (n, 2) are the same places in two systems, within the differences of variants of a system."""
    if same_system(first, second):
        return True
    low, high = points.min(axis=0), points.max(axis=0)
    some = np.array([low, (low + high) / 2, high])
    places = [transformed(each, DEGREES, some) for each in (first, second)]
    _, _, apart = crs_library().Geod(ellps="WGS84").inv(*places[0].T, *places[1].T)
    return bool((np.asarray(apart) <= SAME_PLACE).all())


def full_turn(system: str | None) -> float | None:
    """A full turn in degrees, if coordinates in a system are longitudes and latitudes; else None."""
    return 2 * HALF_TURN if system is not None and known_system(system).is_geographic else None


def are_off_the_earth(points: Floats) -> Booleans:
    """Mask (n,) of the points (n, 2) that are no longitudes and latitudes, in degrees, of any map."""
    x, y = np.abs(points).T
    return ~((x <= FARTHEST[0]) & (y <= FARTHEST[1]))


def require_degrees(points: Floats) -> None:
    """Check that points (n, 2) are longitudes and latitudes of one part of the earth; CaseError if not."""
    x, y = points.T
    bad = np.flatnonzero(are_off_the_earth(points))
    if len(bad):
        px, py = points[bad[0]].tolist()
        raise CaseError(f"({px:g}, {py:g}) is no longitude and latitude: correct it, or crs.from")
    if np.abs(y).max() > NEAREST_POLE:
        raise CaseError(
            f"reaches within {90 - NEAREST_POLE:g} degree of a pole, where no box and no coast is: cut it off"
        )
    if np.ptp(x) > WIDEST:
        raise CaseError(
            f"spans {np.ptp(x):.0f} degrees of longitude: if it crosses the date line, add 360 to those that are "
            "negative; else choose a part of it"
        )


def require_system(source: str, named: str | None, degrees: bool | None, points: Floats) -> None:
    """Check that points (n, 2) of a file are in the system of the case; CaseError if they are in another one.

    The file may have ``named`` its system, as a name or as well-known text, and its coordinates may be ``degrees``;
    None if unknown. A name that the library does not know is ignored.
    """
    if len(points) == 0:
        return
    if degrees and not known_system(source).is_geographic:
        raise CaseError(f"crs.from: {source} is in metres, and the file says that its coordinates are degrees")
    try:
        other = named and known_system(named)
    except CaseError:
        return
    if named and other and not same_places(source, named, points):
        code = ":".join(other.to_authority() or ())
        system = other.name if code in ("", other.name) else f"{other.name} ({code})"
        raise CaseError(
            f"its coordinates are in {system}, and crs.from is {source}: give that of the file, or take the file to "
            f"the other by ogr2ogr -t_srs {source}"
        )
    if degrees is None and not named and _are_surely_degrees(source, points):
        raise CaseError(
            f"crs.from: {source} is in metres, and all coordinates of the file are in the range of degrees: say "
            "crs: {from: EPSG:4326} if they are, else write their system into the file"
        )


def _are_surely_degrees(source: str, points: Floats) -> bool:
    """Whether points (n, 2) of a map are degrees, though the system, a public one and not local to them, has metres."""
    system = known_system(source)
    return bool(
        not system.is_geographic and system.area_of_use is not None and (np.abs(points) <= [2 * HALF_TURN, 90.0]).all()
    )
