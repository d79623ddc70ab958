"""GeoJSON and WKT."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from shapely.geometry import shape

from bubblemesh.errors import CaseError
from bubblemesh.readers.features import Content, Feature, feature_name
from bubblemesh.readers.shapes import feature_of
from bubblemesh.readers.text import read_text

__all__ = ["read_geojson", "read_wkt"]

KINDS = ("Polygon", "MultiPolygon", "LineString", "MultiLineString", "Point", "MultiPoint", "GeometryCollection")


def read_geojson(path: Path) -> Content:
    """The features of a GeoJSON file.

    Raises
    ------
    FileError, CaseError, GeometryError
        With the feature.
    """
    try:
        data = json.loads(read_text(path))
    except json.JSONDecodeError as error:
        raise CaseError(f"line {error.lineno}: not valid JSON: {error.msg}") from None
    except RecursionError:
        raise CaseError("nested too deep: GeoJSON needs far less") from None
    entries = data.get("features") if isinstance(data, dict) and data.get("type") == "FeatureCollection" else [data]
    if not isinstance(entries, list):
        raise CaseError("the FeatureCollection has no list of features")
    found = tuple(_feature(entry, k) for k, entry in enumerate(entries))
    if not found:
        raise CaseError("there are no features in it")
    return Content(found)


def _feature(entry: Any, number: int) -> Feature:
    if not isinstance(entry, dict):
        raise CaseError(f"feature {number}: not a GeoJSON object")
    properties: dict[str, Any] = {}
    geometry: Any = entry
    if entry.get("type") == "Feature":
        given, geometry = entry.get("properties"), entry.get("geometry", {})
        properties = ({"id": entry["id"]} if "id" in entry else {}) | (given if isinstance(given, dict) else {})
    name = feature_name(number, properties, "name", "id")
    kind = geometry.get("type") if isinstance(geometry, dict) else None
    if not isinstance(geometry, dict) or kind not in KINDS:
        raise CaseError(f"{name}: no geometry of a kind that GeoJSON knows (found {kind!r})")
    try:
        with np.errstate(invalid="ignore"):  # numbers that are none are told below, with their place
            made = shape(geometry)
    except (shapely.errors.GEOSException, ValueError, TypeError, KeyError, IndexError, AttributeError):
        raise CaseError(f"{name}: its coordinates are no valid {kind}: {_first_fault(geometry)}") from None
    layer = properties.get("layer", properties.get("Layer"))
    return feature_of(made, name, None if layer is None else str(layer), properties)


def _first_fault(geometry: Any) -> str:
    """What is wrong with nested coordinates, as far as that can be said."""
    for path, position in _positions(geometry.get("coordinates"), ()):
        if not isinstance(position, list) or len(position) < 2:
            return f"no pair of numbers at coordinates{list(path)}: {str(position)[:40]}"
        if any(isinstance(value, bool) or not isinstance(value, int | float) for value in position):
            return f"no pair of numbers at coordinates{list(path)}: {str(position)[:40]}"
    return "give each ring at least four positions, the last equal to the first"


def _positions(value: Any, path: tuple[int, ...]) -> Iterator[tuple[tuple[int, ...], Any]]:
    if isinstance(value, list) and any(isinstance(part, list) for part in value):
        for k, part in enumerate(value):
            yield from _positions(part, (*path, k))
    else:
        yield path, value


def read_wkt(path: Path) -> Content:
    """The geometries of a WKT file, one after the other.

    Raises
    ------
    FileError, CaseError, GeometryError
        With the number of the geometry and its line.
    """
    found = []
    for number, (line, text) in enumerate(_statements(read_text(path))):
        name = f"feature {number} (line {line})"
        try:
            with np.errstate(invalid="ignore"):
                geometry = shapely.from_wkt(text)
        except shapely.errors.GEOSException as error:
            reason = str(error).partition(": ")[2] or str(error)
            raise CaseError(f"{name}: not valid WKT: {reason.strip()}") from None
        found.append(feature_of(geometry, name))
    if not found:
        raise CaseError("there is no geometry in it")
    return Content(tuple(found))


def _statements(text: str) -> Iterator[tuple[int, str]]:
    """First line and text of each geometry: it ends where its brackets are closed."""
    depth, start, line, begun = 0, 0, 1, 1
    opened = False
    for k, letter in enumerate(text):
        line += letter == "\n"
        if letter.isspace() and not text[start:k].strip():
            begun = line
        depth += (letter == "(") - (letter == ")")
        opened = opened or letter == "("
        if opened and depth == 0:
            yield begun, text[start : k + 1].strip(" \n\r\t;")
            start, opened, begun = k + 1, False, line
    if text[start:].strip(" \n\r\t;"):
        yield begun, text[start:].strip()
