"""Coordinates of GeoJSON, checked and reduced to the plane."""

from typing import Any

from bubblemesh.errors import CaseError
from bubblemesh.wording import shown

__all__ = ["plane_geometry"]

DEPTHS = {"Point": 0, "MultiPoint": 1, "LineString": 1, "MultiLineString": 2, "Polygon": 2, "MultiPolygon": 3}
COLLECTION = "GeometryCollection"
HEIGHTS = "heights (z) are not used"
DEEPEST = 20  # collections within collections


def plane_geometry(geometry: Any, name: str, notes: dict[str, None], depth: int = 0) -> dict[str, Any]:
    """A GeoJSON geometry with pairs of numbers for positions; heights that are left out are noted.

    Raises
    ------
    CaseError
        If it is no geometry, or a position no list of numbers; the text starts with the ``name``.
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
        notes[HEIGHTS] = None
    return value[0], value[1]


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
