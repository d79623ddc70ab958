"""GeoJSON, TopoJSON, WKT and WKB, whose coordinates are checked and reduced to the plane."""

import json
import re
import struct
from collections.abc import Callable, Iterator
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from bubblemesh.errors import CaseError, prefixed
from bubblemesh.files import read_bytes, read_text
from bubblemesh.messages import shown
from bubblemesh.readers.degrees import is_named_geographic
from bubblemesh.readers.features import (
    NO_HEIGHTS,
    NO_PARTS,
    Feature,
    FeatureCollection,
    SimpleParts,
    feature_name,
    feature_of,
    parts_of,
)
from bubblemesh.readers.selection import Selection
from bubblemesh.readers.topojson import entries_of

DEPTHS = {"Point": 0, "MultiPoint": 1, "LineString": 1, "MultiLineString": 2, "Polygon": 2, "MultiPolygon": 3}
# Other formats in JSON, by a key that they have.
OTHER_JSON = {
    "elements": ("OpenStreetMap's Overpass", "export it as GeoJSON, as overpass turbo does"),
    "features": ("ArcGIS", "ask its server for f=geojson, or convert it by ogr2ogr"),
    "rings": ("ArcGIS", "ask its server for f=geojson, or convert it by ogr2ogr"),
    "shapes": ("labelme", "write its polygons as GeoJSON or lists of points"),
}
COLLECTION = "GeometryCollection"
DEEPEST = 20  # collections within collections
MOST_DIGITS = 300  # of a whole number: longer ones exceed all floats
SYSTEM = re.compile(r"\s*SRID\s*=\s*(\d+)\s*;", re.IGNORECASE)
WITH_SYSTEM = 0x20000000  # flag of EWKB: a number of a reference system follows
CURVED = "its curves (arcs) are not read: turn them into lines first, as ST_CurveToLine does"


def read_geojson(path: Path, selection: Selection) -> FeatureCollection:
    """The features of a GeoJSON or TopoJSON file; FileError, or CaseError with the feature."""
    advice = "the file may be cut off, or be no GeoJSON (one with an object in each line is called .geojsonl)"
    data = _parsed(read_text(path), advice)
    if isinstance(data, dict) and data.get("type") == "Topology":
        return _collection(entries_of(data), selection)
    entries = data.get("features") if isinstance(data, dict) and data.get("type") == "FeatureCollection" else [data]
    if isinstance(data, dict) and "type" not in data:
        for key, (program, way) in OTHER_JSON.items():
            if isinstance(data.get(key), list):
                raise CaseError(f"it is what {program} writes, no GeoJSON: {way}")
    if not isinstance(entries, list):
        raise CaseError("the FeatureCollection has no list of features: give it one")
    return _collection(entries, selection, _system_of(data))


def _system_of(data: Any) -> str | None:
    """The coordinate system that GeoJSON from before 2016 may name."""
    named = data.get("crs") if isinstance(data, dict) else None
    properties = named.get("properties") if isinstance(named, dict) else None
    name = properties.get("name") if isinstance(properties, dict) else None
    return name if isinstance(name, str) else None


def read_geojson_lines(path: Path, selection: Selection) -> FeatureCollection:
    """The features of a file with a GeoJSON object in each line; FileError, or CaseError with the feature or line."""
    entries: list[Any] = []
    for number, line in enumerate(read_text(path).split("\n"), start=1):
        text = line.strip(" \t\r\x1e")  # a record separator may begin each
        if text:
            try:
                with prefixed(f"line {number}"):
                    entry = _loaded(text)
            except json.JSONDecodeError as error:
                raise _no_json(error, number, "give one GeoJSON object in each line") from None
            whole = isinstance(entry, dict) and entry.get("type") == "FeatureCollection"
            some = entry.get("features") if whole else [entry]
            entries += some if isinstance(some, list) else [entry]
    return _collection(entries, selection)


def _parsed(text: str, advice: str) -> Any:
    try:
        return _loaded(text)
    except json.JSONDecodeError as error:
        raise _no_json(error, error.lineno, advice) from None


def _loaded(text: str) -> Any:
    """Data of a text; JSONDecodeError if it is not JSON, CaseError if it is nested too deep or has a key twice."""
    try:
        return json.loads(text, object_pairs_hook=_once, parse_int=_whole)
    except RecursionError:
        raise CaseError("nested too deep: GeoJSON needs far less") from None


def _no_json(error: json.JSONDecodeError, line: int, advice: str) -> CaseError:
    return CaseError(f"line {line}: not valid JSON: {shown(error.msg)}: {advice}")


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Mapping of pairs; CaseError if a key is there twice."""
    mapping = dict(pairs)
    if len(mapping) < len(pairs):
        seen: set[str] = set()
        twice = next(key for key, _ in pairs if key in seen or seen.add(key))  # type: ignore[func-returns-value]
        raise CaseError(f"the key {shown(repr(twice))} is given twice in one object: remove one of them")
    return mapping


def _whole(digits: str) -> int | float:
    return int(digits) if len(digits) <= MOST_DIGITS else float(digits)


def _collection(entries: list[Any], selection: Selection, system: str | None = None) -> FeatureCollection:
    if not entries:
        raise CaseError("there are no features in it: give a Polygon, or lines that meet")
    notes: dict[str, None] = {}
    bare = [_bare(entry, k) for k, entry in enumerate(entries)]
    found = selection.converted(bare, lambda number, one: _with_geometry(one, entries[number], notes))
    return FeatureCollection(found, tuple(notes), system=system, degrees=is_named_geographic(system))


def _bare(entry: Any, number: int) -> Feature:
    """The feature of an entry, without its geometry."""
    if not isinstance(entry, dict):
        raise CaseError(f"feature {number}: not a GeoJSON object (found {shown(json.dumps(entry))})")
    properties: dict[str, Any] = {}
    if entry.get("type") == "Feature":
        given = entry.get("properties")
        properties = ({"id": entry["id"]} if "id" in entry else {}) | (given if isinstance(given, dict) else {})
    layer = properties.get("layer", properties.get("Layer"))
    name = feature_name(number, properties, "name", "id")
    return Feature(name, None if layer is None else str(layer), properties)


def _with_geometry(bare: Feature, entry: dict[str, Any], notes: dict[str, None]) -> Feature:
    """The feature with the geometry of its entry; notes are added on what is left out."""
    geometry = entry.get("geometry") if entry.get("type") == "Feature" else entry
    parts = NO_PARTS if geometry is None else _parts(geometry, bare.name, notes)
    return feature_of(parts, bare.name, bare.layer, bare.properties)


def _parts(geometry: Any, name: str, notes: dict[str, None], depth: int = 0) -> SimpleParts:
    """Parts of a GeoJSON geometry; a note is added if heights are left out.

    CaseError, beginning with the ``name``, if it is not a geometry, or a position is not a list of numbers.
    """
    kind = geometry.get("type") if isinstance(geometry, dict) else None
    if not isinstance(geometry, dict) or not isinstance(kind, str) or kind not in (*DEPTHS, COLLECTION):
        found = shown(repr(kind))
        raise CaseError(f"{name}: no geometry of a kind that GeoJSON knows (found {found}): give polygons or lines")
    if kind == COLLECTION:
        members = geometry.get("geometries")
        if not isinstance(members, list) or depth > DEEPEST:
            raise CaseError(f"{name}: the collection has no list of geometries, or is nested more than {DEEPEST} deep")
        whole = SimpleParts([], [], [])
        for member in members:
            if member is not None:
                some = _parts(member, name, notes, depth + 1)
                whole.polygons.extend(some.polygons)
                whole.lines.extend(some.lines)
                whole.points.extend(some.points)
        return whole
    given = geometry.get("coordinates")
    if given == []:  # an empty geometry, which any kind may be
        return NO_PARTS
    value = _plane(given, DEPTHS[kind], (), name, notes)
    several = value if kind.startswith("Multi") else [value]
    columns = {"Polygon": (several, [], []), "LineString": ([], several, []), "Point": ([], [], several)}
    return SimpleParts(*columns[kind.removeprefix("Multi")])


def _plane(value: Any, depth: int, path: tuple[int, ...], name: str, notes: dict[str, None]) -> Any:
    """Nested lists of positions, with the positions as pairs."""
    if depth > 0:
        if not isinstance(value, list):
            raise CaseError(f"{name}: no list of positions at coordinates{list(path)} (found {shown(repr(value))})")
        if depth == 1 and _are_pairs(value):
            return value
        return [_plane(part, depth - 1, (*path, k), name, notes) for k, part in enumerate(value)]
    if not isinstance(value, list) or len(value) < 2 or not all(_is_number(part) for part in value[:2]):
        raise CaseError(
            f"{name}: no pair of numbers at coordinates{list(path)}: give [x, y] there (found {shown(repr(value))})"
        )
    if len(value) > 2:
        notes[NO_HEIGHTS] = None
    return value[0], value[1]


def _are_pairs(values: list[Any]) -> bool:
    """Whether all values, which may be very many, are lists of two numbers."""
    if not set(map(type, values)) <= {list} or not set(map(len, values)) <= {2}:
        return False
    return set(map(type, chain.from_iterable(values))) <= {int, float}


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def read_wkt(path: Path) -> FeatureCollection:
    """The geometries of a WKT file, one after the other.

    FileError, or CaseError with the number of the geometry and its line.
    """
    advice = "give polygons or lines, with all brackets closed and the last point of a ring equal to the first"
    shapes, systems = {}, set[str]()
    for number, (line, text) in enumerate(_statements(read_text(path))):
        name = f"feature {number} (line {line})"
        shapes[name] = _shape(shapely.from_wkt, SYSTEM.sub("", text, count=1), f"{name}: not valid WKT", advice)
        systems.update(found[1] for found in [SYSTEM.match(text)] if found)
    return _of_shapes(shapes, systems)


def read_wkb(path: Path) -> FeatureCollection:
    """The geometries of a WKB or EWKB file, one after the other, or as hexadecimal digits in a line each.

    FileError, or CaseError with the number of the geometry.
    """
    content = read_bytes(path)
    try:
        blobs = [bytes.fromhex(line) for line in content.decode("ascii").split()]
    except (UnicodeDecodeError, ValueError):
        blobs = list(_parted(content))
    names = [f"feature {number}" for number in range(len(blobs))]
    shapes = {name: shape_of_wkb(blob, name) for name, blob in zip(names, blobs, strict=True)}
    return _of_shapes(shapes, {str(shapely.get_srid(shape)) for shape in shapes.values()} - {"0"})


def _parted(content: bytes) -> Iterator[bytes]:
    """The bytes of each geometry; bytes that cannot be understood are in the last one, whose reader reports them."""
    start = 0
    while start < len(content):
        try:
            end = _end_of_wkb(content, start)
        except (struct.error, RecursionError):
            end = len(content)
        yield content[start:end]
        start = end


def _end_of_wkb(content: bytes, start: int) -> int:
    """End of the geometry that begins at ``start``; struct.error if it cannot be found."""
    order = "<" if content[start : start + 1] == b"\1" else ">"

    def number(at: int) -> int:
        (found,) = struct.unpack_from(f"{order}I", content, at)
        return int(found)

    code = number(start + 1)
    kind, more = code % 1000 if code < 4000 else code & 0xFF, code // 1000 if code < 4000 else code >> 30
    place = 8 * (2 + (more & 1) + (more >> 1))  # bytes of a place with its height and measure
    at = start + (9 if code & WITH_SYSTEM else 5)
    if kind == 1:
        return at + place
    if kind not in (2, 3, 4, 5, 6, 7):
        raise struct.error(f"no geometry of straight parts: {kind}")
    count, at = number(at), at + 4
    if kind == 2:
        return at + count * place
    for _ in range(count):
        at = at + 4 + number(at) * place if kind == 3 else _end_of_wkb(content, at)
    return at


def _of_shapes(shapes: dict[str, shapely.Geometry], systems: set[str]) -> FeatureCollection:
    """A feature for each shape, by its name; the file has the coordinate ``systems``, EPSG numbers."""
    if not shapes:
        raise CaseError("there is no geometry in it: give a POLYGON, or lines that meet")
    solid = any(shapely.has_z(shape) for shape in shapes.values())
    features = tuple(feature_of(parts_of(shape), name) for name, shape in shapes.items())
    system = f"EPSG:{next(iter(systems))}" if len(systems) == 1 else None
    degrees = True if any(map(is_named_geographic, systems)) else None
    return FeatureCollection(features, (NO_HEIGHTS,) if solid else (), system=system, degrees=degrees)


def shape_of_wkb(wkb: bytes, name: str) -> shapely.Geometry:
    """The shape of the binary form of a geometry; CaseError, with its name, if that is not valid."""
    return _shape(shapely.from_wkb, wkb, f"{name}: not a valid geometry", "give polygons or lines of straight parts")


def _shape(read: Callable[[Any], shapely.Geometry], given: str | bytes, problem: str, advice: str) -> shapely.Geometry:
    """Geometry that shapely reads; CaseError with the problem and the advice."""
    try:
        with np.errstate(invalid="ignore"):  # `feature_of` reports invalid numbers, with their place
            return read(given)
    except NotImplementedError:
        raise CaseError(f"{problem.partition(': not')[0]}: {CURVED}") from None
    except (shapely.errors.GEOSException, ValueError, TypeError) as error:
        reason = shown(str(error).partition("Exception: ")[2] or error)
        raise CaseError(f"{problem}: {reason}: {advice}") from None


END = re.compile(r"[()]|\bEMPTY\b", re.IGNORECASE)


def _statements(text: str) -> Iterator[tuple[int, str]]:
    """First line and text of each geometry, which ends where its brackets are closed, or with EMPTY."""
    depth = start = counted = 0
    line = 1
    for end in END.finditer(text):
        depth += {"(": 1, ")": -1}.get(end.group(), 0)
        if depth > DEEPEST:  # thousands would overflow the stack of the library
            at = line + text.count("\n", counted, end.start())
            raise CaseError(f"line {at}: brackets are nested more than {DEEPEST} deep: give the geometries one by one")
        if depth <= 0:
            begin = start + len(text[start : end.end()]) - len(text[start : end.end()].lstrip(" \n\r\t;"))
            line += text.count("\n", counted, begin)
            yield line, text[begin : end.end()]
            depth, start, counted = 0, end.end(), begin
    rest = text[start:].lstrip(" \n\r\t;")
    if rest.strip():
        yield line + text.count("\n", counted, len(text) - len(rest)), rest.strip()
