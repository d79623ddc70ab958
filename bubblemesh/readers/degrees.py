"""Coordinates in degrees of longitude and latitude: whether a file has them, and what to advise the user then."""

import math
import re

import numpy as np

from bubblemesh.arrays import ROUNDING, Floats

FARTHEST = np.array([180.0, 90.0])
HUNDREDTHS = 100  # numbers written by hand are mostly multiples of a hundredth
MOST_ROUND = 0.5  # share of such numbers in a drawing
FAR_MAP = 3.0  # distance of a map from the origin, in sizes of the map; drawings are nearer, most countries are not
NEAR_DATE_LINE = 170.0  # longitude that maps across the date line reach on both sides
ZONE, WIDEST = 6.0, 12.0  # degrees: width of a zone of UTM, and of the largest area for which one zone will do
# Codes of WGS 84, ETRS89, NAD83 and NAD27: few files name others.
NAMES = re.compile(r"(?<!\d)(CRS84h?|CRS83|CRS27|4326|4979|4258|4937|4269|4267)$")
GEOGRAPHIC, PROJECTED = re.compile(r"\b(GEOGCS|GEOGCRS|GEODCRS)\b"), re.compile(r"\b(PROJCS|PROJCRS)\b")


def is_geographic(system: str | None) -> bool | None:
    """Whether a coordinate reference system, as well-known text, is in degrees; None if that is unknown."""
    text = system or ""
    return False if PROJECTED.search(text) else True if GEOGRAPHIC.search(text) else None


def is_named_geographic(name: object) -> bool | None:
    """Whether a coordinate reference system, by its name or number, is in degrees; None if unknown."""
    return True if NAMES.search(str(name)) else None


def look_like_degrees(points: Floats, is_map: bool = False) -> bool:
    """Whether points (n, 2) of a file without a coordinate system are degrees rather than a drawing.

    They count as degrees if they are in the range of degrees, not around the origin, which is in the ocean, and mostly
    not round numbers. If the file ``is_map``, that is bounds a domain by itself and is in a format of maps, round
    numbers count as well, if they are far from the origin or on both sides of the date line.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    if (np.abs([low, high]) > FARTHEST).any():
        return False
    if is_map and cross_date_line(points):
        return True
    aside = np.maximum(np.maximum(low, -high), 0)  # of the origin
    if not aside.any():
        return False
    if is_map and np.hypot(*aside) >= FAR_MAP * (high - low).max():
        return True
    parts = points * HUNDREDTHS
    return bool((np.abs(parts - np.rint(parts)) <= ROUNDING * np.abs(parts)).mean() < MOST_ROUND)


def cross_date_line(points: Floats) -> bool:
    """Whether places (n, 2) in degrees are on both sides of the date line, and not on the other half of the earth."""
    x = np.sort(points[:, 0])
    across = 2 * FARTHEST[0] - np.diff(x).max(initial=0.0)
    return bool(x[0] <= -NEAR_DATE_LINE and x[-1] >= NEAR_DATE_LINE and 0 < across < FARTHEST[0])


def degrees_notes(points: Floats, degrees: bool | None, is_map: bool = False) -> tuple[str, ...]:
    """Notes on points (n, 2) that are ``degrees``, or look like degrees if that is None, with what to do.

    ``is_map`` is that of `look_like_degrees`.
    """
    if len(points) == 0 or not (look_like_degrees(points, is_map) if degrees is None else degrees):
        return ()
    notes = list[str]()
    if cross_date_line(points):
        notes.append(
            f"longitudes jump at the date line, and are taken as they are, {np.ptp(points[:, 0]):.0f} degrees apart: "
            "add 360 to those that are negative"
        )
        points = np.column_stack([points[:, 0] % (2 * FARTHEST[0]), points[:, 1]])
    (west, south), (east, north) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    latitude = (south + north) / 2
    stretched = 1 / max(math.cos(math.radians(min(abs(latitude), 89.0))), 1e-3)
    too_long = f"lengths from east to west are {stretched:.2f} times too long at latitude {latitude:.0f}"
    certainly = "are" if degrees else "look like"
    return (
        f"coordinates {certainly} degrees and are taken as they are: the spacing counts in degrees, too, and "
        f"{too_long}; for a true shape add crs: {{from: EPSG:4326}}, with sizes in metres, or project the file to "
        f"metres ({_projection(west, east, latitude)})",
        *notes,
    )


def _projection(west: float, east: float, latitude: float) -> str:
    """Name of a coordinate system in metres that is fit for this part of the earth."""
    if east - west > WIDEST or abs(latitude) > 84:
        return f"such as LAEA, ogr2ogr -t_srs '+proj=laea +lat_0={latitude:.0f} +lon_0={(west + east) / 2:.0f}'"
    zone = int(np.clip((west + east + 360) / 2 // ZONE + 1, 1, 60))
    return f"such as UTM, ogr2ogr -t_srs EPSG:{326 if latitude >= 0 else 327}{zone:02}"
