"""TopoJSON: geometries whose sides are shared arcs, converted to entries of GeoJSON."""

from collections.abc import Mapping
from itertools import accumulate
from typing import Any

from bubblemesh.errors import CaseError, LimitError

Positions = list[list[float]]
MOST_POSITIONS = 10_000_000  # of all lines: arcs may be used again and again
DEPTHS = {"LineString": 0, "MultiLineString": 1, "Polygon": 1, "MultiPolygon": 2}  # of lists of arcs


def entries_of(topology: Mapping[str, Any]) -> list[Any]:
    """The objects of a topology as features of GeoJSON, each with its object's name as its layer.

    CaseError if it is not valid TopoJSON.
    """
    try:
        arcs = [_unpacked(arc, topology.get("transform")) for arc in topology["arcs"]]
        if sum(map(len, arcs)) + _positions(topology["objects"], arcs) > MOST_POSITIONS:
            raise LimitError(f"its arcs make more than {MOST_POSITIONS:,} positions: simplify it")
        entries: list[Any] = []
        for layer, thing in topology["objects"].items():
            is_collection = thing["type"] == "GeometryCollection"
            for one in thing["geometries"] if is_collection else [thing]:
                properties = {"layer": layer} | {key: one[key] for key in ("id",) if key in one}
                properties |= one.get("properties") or {}
                geometry = _geometry(one, arcs, topology.get("transform"))
                entries.append({"type": "Feature", "properties": properties, "geometry": geometry})
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, RecursionError):
        advice = "write it anew, or as GeoJSON"
        raise CaseError(
            f"not valid TopoJSON: something is missing or of a wrong kind in its objects or arcs: {advice}"
        ) from None
    return entries


def _positions(thing: Any, arcs: list[Positions]) -> int:
    """Number of positions of all arcs that objects use."""
    if isinstance(thing, int) and not isinstance(thing, bool):
        return len(arcs[thing if thing >= 0 else ~thing])
    if isinstance(thing, list):
        return sum(_positions(part, arcs) for part in thing)
    if "arcs" in thing:
        return _positions(thing["arcs"], arcs)
    if "geometries" in thing:
        return _positions(thing["geometries"], arcs)
    return sum(_positions(part, arcs) for part in thing.values()) if "type" not in thing else 0


def _unpacked(arc: Positions, transform: Mapping[str, Any] | None) -> Positions:
    """Positions of an arc; with a transform it is given by steps in whole numbers."""
    if transform is None:
        return [[x, y] for x, y, *_ in arc]
    along = [accumulate(values) for values in zip(*((x, y) for x, y, *_ in arc), strict=True)]
    return [_placed(position, transform) for position in zip(*along, strict=True)]


def _placed(position: Any, transform: Mapping[str, Any] | None) -> list[float]:
    if transform is None:
        return list(position)
    (sx, sy), (tx, ty) = transform["scale"], transform["translate"]
    return [position[0] * sx + tx, position[1] * sy + ty]


def _geometry(
    thing: Mapping[str, Any], arcs: list[Positions], transform: Mapping[str, Any] | None
) -> dict[str, Any] | None:
    """The GeoJSON geometry of an object; None if it has none."""
    kind = thing["type"]
    if kind is None:
        return None
    if kind == "GeometryCollection":
        return {"type": kind, "geometries": [_geometry(part, arcs, transform) for part in thing["geometries"]]}
    if kind in ("Point", "MultiPoint"):
        given = thing["coordinates"]
        several = given if kind == "MultiPoint" else [given]
        placed = [_placed(position, transform) for position in several]
        return {"type": kind, "coordinates": placed if kind == "MultiPoint" else placed[0]}
    return {"type": kind, "coordinates": _lines(thing["arcs"], DEPTHS[kind], arcs)}


def _lines(numbers: Any, depth: int, arcs: list[Positions]) -> Any:
    """Lines, or nested lists of them, along arcs by their numbers: k, or ~k for the reversed arc."""
    if depth > 0:
        return [_lines(some, depth - 1, arcs) for some in numbers]
    line: Positions = []
    for number in numbers:
        arc = arcs[number] if number >= 0 else arcs[~number][::-1]
        line += arc[1:] if line else arc
    return line
