"""DXF drawings: lines, arcs, circles, ellipses, polylines with bulges and splines; layers become labels."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from ezdxf.filemanagement import readfile
from ezdxf.math import bulge_center

from bubblemesh.errors import CaseError, LimitError
from bubblemesh.geometry import rings
from bubblemesh.geometry.rings import ArcTo, LineTo, Piece, SplineTo
from bubblemesh.messages import place, shown
from bubblemesh.readers.features import (
    NO_HEIGHTS,
    CompoundCurve,
    Feature,
    FeatureCollection,
    finite_points,
    foreign,
    writable_label,
)
from bubblemesh.readers.sampling import splines

FLAT = 3e-8  # bulge that is none but for rounding
MOST_COPIES = 50_000  # entities that blocks draw, which takes a second for a few thousand
POINTS = 4  # of an entity, that count as one more
FULL_TURN = 2 * np.pi * (1 - 1e-9)
DEEPEST = 16  # blocks within blocks
UNITS = {1: "in", 2: "ft", 4: "mm", 5: "cm", 6: "m", 7: "km", 13: "um"}  # of the header's $INSUNITS


def read_dxf(path: Path) -> FeatureCollection:
    """The curves of a drawing's model space, blocks resolved; other entities are named in the notes.

    FileError or CaseError with the entity.
    """
    with foreign("not a valid DXF drawing", "save it anew as DXF, text or binary, without anything before it"):
        return _features(readfile(path))


def _features(drawing: Any) -> FeatureCollection:
    features: list[Feature] = []
    unused: dict[str, list[Any]] = {}
    heights: set[float] = set()
    for entity in _entities(drawing.modelspace(), 0, Counter()):
        kind = entity.dxftype()
        if kind in CURVES and _is_plane(entity):
            features.append(_feature(entity))
            ends = (entity.dxf.start, entity.dxf.end) if kind == "LINE" else ()  # which may be at different heights
            heights |= {round(float(end[2]), 9) for end in ends}
        else:
            unused.setdefault(kind, []).append(entity)
    notes = tuple(_unused(kind, entities) for kind, entities in unused.items())
    if not features:
        raise CaseError(f"there are no curves in its model space{''.join(f'; {note}' for note in notes)}")
    if len(heights) > 1:
        notes = (*notes, NO_HEIGHTS)
    return FeatureCollection(tuple(features), notes, unit=UNITS.get(drawing.header.get("$INSUNITS", 0)))


def _entities(layout: Iterable[Any], depth: int, drawn: Counter[str]) -> Iterator[Any]:
    """Entities with those of blocks in their places; ``drawn`` counts the size of the latter."""
    if depth > DEEPEST:
        raise CaseError(f"blocks are nested more than {DEEPEST} deep: explode them")
    for entity in layout:
        if depth > 0:
            drawn["copies"] += _size(entity)
            if drawn["copies"] > MOST_COPIES:
                what = f"more than {MOST_COPIES:,} entities, or as much in long ones"
                raise LimitError(f"its blocks draw {what}: explode them, or simplify it")
        if entity.dxftype() != "INSERT":
            yield entity
        elif entity.block() is None:
            raise CaseError(f"{_name(entity)}: there is no block {shown(entity.dxf.name, 40)!r}: purge the drawing")
        else:
            yield from _entities(entity.virtual_entities(), depth + 1, drawn)


def _size(entity: Any) -> int:
    """Number of plain entities that take as long to be copied: by the lists of points, knots, letters that it has."""
    parts = [value for part in (entity, *getattr(entity, "paths", ())) for value in vars(part).values()]
    return 1 + sum(len(value) for value in parts if hasattr(value, "__len__")) // POINTS


def _is_plane(entity: Any) -> bool:
    """Whether an entity lies in the plane of the drawing or one parallel to it."""
    direction = entity.dxf.get("extrusion", (0, 0, 1))
    flat = abs(direction[0]) + abs(direction[1]) < 1e-9
    return flat and (entity.dxftype() != "POLYLINE" or entity.is_2d_polyline)


def _name(entity: Any) -> str:
    handle = entity.dxf.get("handle")
    return f"{entity.dxftype()}{f' #{handle}' if handle else ''} on layer {shown(entity.dxf.layer, 40)}"


def _unused(kind: str, entities: list[Any]) -> str:
    """Note on entities that make no ring."""
    first = entities[0]
    keys = [key for key in ("insert", "location", "start", "center", "defpoint") if first.dxf.hasattr(key)]
    at = first.dxf.get(keys[0]) if keys else None
    where = f" at {place((at[0], at[1]))}" if at is not None else ""
    return f"{len(entities)} {kind} not used, the first on layer {shown(first.dxf.layer, 40)}{where}"


def _feature(entity: Any) -> Feature:
    name, layer = _name(entity), str(entity.dxf.layer)
    label, notes = writable_label(None if layer == "0" else layer, "a layer")
    with foreign(f"{name}: not a valid curve", "draw it anew"):
        made = CURVES[entity.dxftype()](entity, name, label)
    properties = {"type": entity.dxftype(), "handle": entity.dxf.get("handle")}
    if isinstance(made, CompoundCurve):
        return Feature(name, layer, properties, curves=(made,), notes=notes)
    return Feature(name, layer, properties, rings=(replace(made, origin=name),), notes=notes)


def _mirrored(entity: Any) -> float:
    """-1 if the entity is drawn as seen from below, where x is turned round."""
    return -1.0 if entity.dxf.get("extrusion", (0, 0, 1))[2] < 0 else 1.0


def _line(entity: Any, name: str, label: str | None) -> CompoundCurve:
    start, end = finite_points([entity.dxf.start, entity.dxf.end], name)
    return CompoundCurve(start, (LineTo(end, label),), name)


def _arc(entity: Any, name: str, label: str | None) -> CompoundCurve:
    center = entity.ocs().to_wcs(entity.dxf.center)
    start, end, middle = finite_points([entity.start_point, entity.end_point, center], name)
    return CompoundCurve(start, (ArcTo(end, middle, _mirrored(entity) > 0, label),), name)


def _circle(entity: Any, name: str, label: str | None) -> rings.Ring:
    center, (radius, _) = finite_points([entity.ocs().to_wcs(entity.dxf.center), (entity.dxf.radius, 0)], name)
    if radius <= 0:
        raise CaseError(f"{name} at {place(center)}: its radius is {radius:g}")
    return rings.circle(center, radius, label)


def _ellipse(entity: Any, name: str, label: str | None) -> CompoundCurve | rings.Ring:
    begin, sweep = entity.dxf.start_param, (entity.dxf.end_param - entity.dxf.start_param) % (2 * np.pi)
    if sweep == 0 or sweep > FULL_TURN:
        center, (x, y) = finite_points([entity.dxf.center, entity.dxf.major_axis], name)
        long = float(np.hypot(x, y))
        return rings.ellipse(center, (long, long * entity.dxf.ratio), float(np.degrees(np.arctan2(y, x))), label)

    def curve(t: Any) -> Any:
        return np.array(finite_points(list(entity.vertices((begin + sweep * t).tolist())), name))

    return _sampled([curve], name, label)


def _spline(entity: Any, name: str, label: str | None) -> CompoundCurve:
    """B-splines are sampled between the knots at which they may have a corner."""
    tool = entity.construction_tool()
    knots, degree = np.array(tool.knots(), float), tool.degree
    inner, count = np.unique(knots[(knots > 0) & (knots < tool.max_t)], return_counts=True)
    breaks = [0.0, *inner[count >= degree].tolist(), float(tool.max_t)]

    def part(begin: float, end: float) -> Callable[[Any], Any]:
        return lambda t: np.array(finite_points(list(tool.points((begin + (end - begin) * t).tolist())), name))

    return _sampled([part(begin, end) for begin, end in pairwise(breaks)], name, label)


def _sampled(curves: list[Callable[[Any], Any]], name: str, label: str | None) -> CompoundCurve:
    parts = [[(x, y) for x, y in points.tolist()] for curve in curves for points in splines(curve)]
    return CompoundCurve(parts[0][0], tuple(SplineTo(points[1:], label) for points in parts), name)


def _lwpolyline(entity: Any, name: str, label: str | None) -> CompoundCurve:
    return _bulged([tuple(point) for point in entity.get_points("xyb")], entity, name, label)


def _polyline(entity: Any, name: str, label: str | None) -> CompoundCurve:
    corners = [(*vertex.dxf.location.vec2, vertex.dxf.get("bulge", 0.0)) for vertex in entity.vertices]
    return _bulged(corners, entity, name, label)


def _bulged(corners: list[tuple[float, float, float]], entity: Any, name: str, label: str | None) -> CompoundCurve:
    """Polyline with arcs: a bulge is the tangent of a quarter of the arc's angle."""
    turn = _mirrored(entity)
    points = finite_points([(turn * x, y) for x, y, _ in corners], name)
    bulges = [turn * bulge for _, _, bulge in corners]
    if entity.is_closed:
        points, bulges = [*points, points[0]], [*bulges, 0.0]
    pieces: list[Piece] = []
    for (begin, end), bulge in zip(pairwise(points), bulges, strict=False):
        if begin != end and abs(bulge) < FLAT:
            pieces.append(LineTo(end, label))
        elif begin != end:
            x, y = bulge_center(begin, end, bulge)
            pieces.append(ArcTo(end, (float(x), float(y)), bulge > 0, label))
    if not pieces:
        raise CaseError(f"{name}: it has fewer than two different points")
    return CompoundCurve(points[0], tuple(pieces), name)


CURVES: dict[str, Callable[[Any, str, str | None], CompoundCurve | rings.Ring]] = {
    "LINE": _line,
    "ARC": _arc,
    "CIRCLE": _circle,
    "ELLIPSE": _ellipse,
    "SPLINE": _spline,
    "LWPOLYLINE": _lwpolyline,
    "POLYLINE": _polyline,
}
