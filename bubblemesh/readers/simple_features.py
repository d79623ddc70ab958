"""GeoJSON and WKT, whose coordinates are checked and reduced to the plane."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from shapely.geometry import shape

from bubblemesh.errors import CaseError
from bubblemesh.files import read_text
from bubblemesh.messages import shown
from bubblemesh.readers.features import NO_HEIGHTS, Feature, FeatureCollection, feature_name, feature_of

DEPTHS = {"Point": 0, "MultiPoint": 1, "LineString": 1, "MultiLineString": 2, "Polygon": 2, "MultiPolygon": 3}
COLLECTION = "GeometryCollection"
DEEPEST = 20  # collections within collections


def plane_geometry(geometry: Any, name: str, notes: dict[str, None], depth: int = 0) -> dict[str, Any]:
    """A GeoJSON geometry with pairs of numbers for positions; heights that are left out are noted.

    CaseError, starting with the ``name``, if it is no geometry, or a position no list of numbers.
    """
    kind = geometry.get("type") if isinstance(geometry, dict) else None
    if not isinstance(geometry, dict) or not isinstance(kind, str) or kind not in (*DEPTHS, COLLECTION):
        raise CaseError(
            f"{name}: no geometry of a kind that GeoJSON knows (found {shown(repr(kind))}): give polygons or lines"
        )
    if kind == COLLECTION:
        parts = geometry.get("geometries")
        if not isinstance(parts, list) or depth > DEEPEST:
            raise CaseError(f"{name}: the collection has no list of geometries, or is nested more than {DEEPEST} deep")
        return {"type": kind, "geometries": [plane_geometry(part, name, notes, depth + 1) for part in parts]}
    return {"type": kind, "coordinates": _plane(geometry.get("coordinates"), DEPTHS[kind], (), name, notes)}


def _plane(value: Any, depth: int, path: tuple[int, ...], name: str, notes: dict[str, None]) -> Any:
    """Nested lists of positions, the positions as pairs."""
    if depth > 0:
        if not isinstance(value, list):
            raise CaseError(f"{name}: no list of positions at coordinates{list(path)} (found {shown(repr(value))})")
        return [_plane(part, depth - 1, (*path, k), name, notes) for k, part in enumerate(value)]
    if not isinstance(value, list) or len(value) < 2 or not all(_is_number(part) for part in value[:2]):
        raise CaseError(
            f"{name}: no pair of numbers at coordinates{list(path)}: give [x, y] there (found {shown(repr(value))})"
        )
    if len(value) > 2:
        notes[NO_HEIGHTS] = None
    return value[0], value[1]


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


SYSTEM = re.compile(r"\s*SRID\s*=\s*\d+\s*;", re.IGNORECASE)
MOST_DIGITS = 300  # of a whole number: longer ones exceed the floats


def read_geojson(path: Path) -> FeatureCollection:
    """The features of a GeoJSON file; FileError, CaseError or GeometryError with the feature."""
    try:
        data = json.loads(read_text(path), object_pairs_hook=_once, parse_int=_whole)
    except json.JSONDecodeError as error:
        raise CaseError(
            f"line {error.lineno}: not valid JSON: {shown(error.msg)}: the file may be cut off, or be no GeoJSON"
        ) from None
    except RecursionError:
        raise CaseError("nested too deep: GeoJSON needs far less") from None
    entries = data.get("features") if isinstance(data, dict) and data.get("type") == "FeatureCollection" else [data]
    if not isinstance(entries, list):
        raise CaseError("the FeatureCollection has no list of features: give it one")
    notes: dict[str, None] = {}
    found = tuple(_feature(entry, k, notes) for k, entry in enumerate(entries))
    if not found:
        raise CaseError("there are no features in it: give a Polygon, or lines that meet")
    return FeatureCollection(found, tuple(notes))


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """A mapping of which no key is given twice."""
    mapping = dict(pairs)
    if len(mapping) < len(pairs):
        seen: set[str] = set()
        twice = next(key for key, _ in pairs if key in seen or seen.add(key))  # type: ignore[func-returns-value]
        raise CaseError(f"the key {shown(repr(twice))} is given twice in one object: remove one of them")
    return mapping


def _whole(digits: str) -> int | float:
    return int(digits) if len(digits) <= MOST_DIGITS else float(digits)


def _feature(entry: Any, number: int, notes: dict[str, None]) -> Feature:
    """The feature of one entry; what is left out of it is added to the notes."""
    if not isinstance(entry, dict):
        raise CaseError(f"feature {number}: not a GeoJSON object (found {shown(json.dumps(entry))})")
    properties: dict[str, Any] = {}
    geometry: Any = entry
    if entry.get("type") == "Feature":
        given, geometry = entry.get("properties"), entry.get("geometry", {})
        properties = ({"id": entry["id"]} if "id" in entry else {}) | (given if isinstance(given, dict) else {})
    name = feature_name(number, properties, "name", "id")
    plane = plane_geometry(geometry, name, notes)
    try:
        with np.errstate(invalid="ignore"):  # numbers that are none are told by `feature_of`, with their place
            made = shape(plane)
    except (shapely.errors.GEOSException, ValueError, TypeError):
        raise CaseError(
            f"{name}: its coordinates are no valid {plane['type']}: give each ring at least four positions, the last "
            "equal to the first, and each line two"
        ) from None
    layer = properties.get("layer", properties.get("Layer"))
    return feature_of(made, name, None if layer is None else str(layer), properties)


def read_wkt(path: Path) -> FeatureCollection:
    """The geometries of a WKT file, one after the other.

    FileError, CaseError or GeometryError with the number of the geometry and its line.
    """
    found = []
    solid = False
    for number, (line, text) in enumerate(_statements(read_text(path))):
        name = f"feature {number} (line {line})"
        try:
            with np.errstate(invalid="ignore"):
                geometry = shapely.from_wkt(SYSTEM.sub("", text, count=1))
        except (shapely.errors.GEOSException, NotImplementedError) as error:
            reason = shown(str(error).partition("Exception: ")[2] or error)
            raise CaseError(
                f"{name}: not valid WKT: {reason}: give polygons or lines of straight parts, with all brackets closed "
                "and the last point of a ring equal to the first"
            ) from None
        solid = solid or bool(shapely.has_z(geometry))
        found.append(feature_of(geometry, name))
    if not found:
        raise CaseError("there is no geometry in it: give a POLYGON, or lines that meet")
    return FeatureCollection(tuple(found), (NO_HEIGHTS,) if solid else ())


def _statements(text: str) -> Iterator[tuple[int, str]]:
    """First line and text of each geometry: it ends where its brackets are closed."""
    depth = start = counted = 0
    line = 1
    for bracket in re.finditer("[()]", text):
        depth += 1 if bracket.group() == "(" else -1
        if depth > DEEPEST:  # at thousands the library's stack would end
            at = line + text.count("\n", counted, bracket.start())
            raise CaseError(f"line {at}: brackets are nested more than {DEEPEST} deep: give the geometries one by one")
        if depth <= 0:
            begin = start + len(text[start : bracket.end()]) - len(text[start : bracket.end()].lstrip(" \n\r\t;"))
            line += text.count("\n", counted, begin)
            yield line, text[begin : bracket.end()]
            depth, start, counted = 0, bracket.end(), begin
    rest = text[start:].lstrip(" \n\r\t;")
    if rest.strip():
        yield line + text.count("\n", counted, len(text) - len(rest)), rest.strip()
