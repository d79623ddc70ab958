"""DXF drawings: the curves and fills of the model space, blocks resolved; layers become labels."""

import logging
import struct
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from ezdxf import recover
from ezdxf.filemanagement import readfile
from ezdxf.lldxf.const import DXFError
from ezdxf.lldxf.types import DOUBLE
from ezdxf.xclip import XClip

from bubblemesh.errors import CaseError, LimitError
from bubblemesh.files import read_bytes
from bubblemesh.geometry.paths import Area, Ring, as_point
from bubblemesh.messages import counted, place, shown
from bubblemesh.readers.dxf_curves import CURVES, FILLS, Curves, polyline_corners
from bubblemesh.readers.features import (
    FILL,
    HIDDEN,
    NO_HEIGHTS,
    Clip,
    CompoundCurve,
    Feature,
    FeatureCollection,
    finite_points,
    foreign,
    polygon_ring,
    writable_label,
)
from bubblemesh.readers.slips import Slips
from bubblemesh.records import record

logging.getLogger("ezdxf").addHandler(logging.NullHandler())  # else its lines go to the terminal

MOST_COPIES = 50_000  # entities that blocks draw; a few thousand take a second
POINTS = 4  # so many points of an entity count as one more entity
DEEPEST_BLOCKS = 16  # blocks within blocks
UNITS = {1: "in", 2: "ft", 4: "mm", 5: "cm", 6: "m", 7: "km", 9: "mil", 12: "nm", 13: "um"}  # $INSUNITS of the header
DWG = b"AC10"  # how the binary form of AutoCAD's drawings begins
END = b"EOF"  # at the end of a complete file
DAMAGES = ValueError, KeyError, TypeError, IndexError, AttributeError, StopIteration, struct.error  # of damaged files
PLACES = ("insert", "location", "start", "center", "defpoint")  # keys of an entity that may hold its place
BODIES = ("REGION", "3DSOLID", "BODY", "SURFACE", "MESH", "3DFACE", "MLINE")


@record
class _Drawn:
    """An entity of the model space, or one drawn there by a block; whether it is hidden, and its clips."""

    entity: Any
    hidden: bool
    clips: tuple[Clip, ...]


@dataclass
class _Walk:
    """State of a walk through a drawing and its blocks: what was found on the way."""

    drawing: Any
    drawn: int = 0  # size of what blocks draw
    unused: dict[str, list[Any]] = field(default_factory=dict)  # entities without curves, by their kind
    unclipped: int = 0  # blocks with clips that bound no area
    flat: int = 0  # blocks with a scale of 0


def read_dxf(path: Path) -> FeatureCollection:
    """The curves, fills and points of a drawing's model space; other entities are named in the notes.

    FileError if the file cannot be read, CaseError with the entity if it cannot be used.
    """
    content = read_bytes(path)
    if content.startswith(DWG):
        raise CaseError("it is a DWG drawing: save it as DXF")
    with foreign("not a valid DXF drawing", "save it anew as DXF, text or binary"):
        drawing, notes = _drawing(path, content)
        return _features(drawing, notes)


def _drawing(path: Path, content: bytes) -> tuple[Any, tuple[str, ...]]:
    """The drawing; faults are mended by the library if it can, with a note, unless the file is cut off."""
    try:
        return readfile(path), ()
    except (DXFError, *DAMAGES) as error:
        if not content.rstrip(b"\0\x1a \t\r\n").endswith(END):
            raise EOFError("it is cut off: EOF, the last word of a drawing, is missing") from error
    _require_numbers(content)
    drawing, audit = recover.readfile(path)
    faults = len(audit.fixes) + len(audit.errors)
    return drawing, (f"its structure has faults, and is read as far as it can be ({counted(faults, 'fault')} found)",)


def _require_numbers(content: bytes) -> None:
    """CaseError with the line of an invalid number: the library would cut it to the digits with which it begins."""
    lines = content.split(b"\n")
    for number, (code, value) in enumerate(zip(lines[::2], lines[1::2], strict=False)):
        if not code.strip().isdigit():  # damaged in another way, which the library reports
            return
        try:
            float(b"".join(value.split()) if int(code) in DOUBLE else 0)
        except ValueError:
            text = shown(value.decode(errors="replace"), 40)
            raise CaseError(
                f"line {2 * number + 2}: {text!r} is no number: save it with decimal points, or correct it there"
            ) from None


def _features(drawing: Any, notes: tuple[str, ...]) -> FeatureCollection:
    """Content of a drawing, with the given notes and those on entities that are not used."""
    features: list[Feature] = []
    heights: set[float] = set()
    walk = _Walk(drawing)
    flat: dict[str, list[Any]] = {}
    wide = 0
    for found in _entities(walk, drawing.modelspace()):
        entity = found.entity
        kind = entity.dxftype()
        if kind not in (*CURVES, *FILLS, "POINT") or not _is_plane(entity):
            walk.unused.setdefault(kind, []).append(entity)
            continue
        features.append(_feature(found))
        if features[-1].is_empty:
            flat.setdefault(f"{kind} without an extent", []).append(entity)
        heights |= _heights(entity)
        wide += kind in ("LWPOLYLINE", "POLYLINE") and bool(entity.has_width)
    unused = tuple(_unused(kind, entities) for kind, entities in walk.unused.items())
    if all(one.is_empty for one in features):
        reasons = (*unused, *(_unused(kind, entities) for kind, entities in flat.items()))
        raise CaseError(
            f"there are no curves in its model space{''.join(f'; {note}' for note in reasons)}{_paper(drawing)}"
        )
    if walk.flat:
        notes += (f"{counted(walk.flat, 'block')} with a scale of 0 drawn as with 1",)
    if walk.unclipped:
        notes += (f"{counted(walk.unclipped, 'block')} drawn whole, since the clip (XCLIP) bounds no area",)
    notes += (NO_HEIGHTS,) if len(heights) > 1 else ()
    notes += (f"the width of {counted(wide, 'polyline')} is not used: their middle lines are",) if wide else ()
    return FeatureCollection(tuple(features), unused + notes, unit=UNITS.get(drawing.header.get("$INSUNITS", 0)))


def _paper(drawing: Any) -> str:
    """Advice if there are curves in the paper space; else empty."""
    kinds = (*CURVES, *FILLS)
    layouts = [layout for layout in drawing.layouts if not layout.is_modelspace]
    drawn = [layout.name for layout in layouts if any(entity.dxftype() in kinds for entity in layout)]
    named = ", ".join(shown(name, 40) for name in drawn)
    return f"; there are some in the paper space ({named}): move them to the model space" if drawn else ""


def _entities(
    walk: _Walk, layout: Iterable[Any], depth: int = 0, hidden: bool = False, clips: tuple[Clip, ...] = ()
) -> Iterator[_Drawn]:
    """Entities of a layout, with the entities of blocks in place of inserts."""
    if depth > DEEPEST_BLOCKS:
        raise CaseError(f"blocks are nested more than {DEEPEST_BLOCKS} deep: explode them")
    for entity in layout:
        if depth > 0:
            _count(walk, _size(entity))
        unseen = hidden or _is_hidden(walk.drawing, entity)
        if entity.dxftype() == "INSERT":
            yield from _inserted(walk, entity, depth, unseen, clips)
        elif entity.dxftype() != "VIEWPORT":
            yield _Drawn(entity, unseen, clips)


def _inserted(walk: _Walk, entity: Any, depth: int, hidden: bool, clips: tuple[Clip, ...]) -> Iterator[_Drawn]:
    """Entities drawn by an insert; CaseError if its block is missing."""
    block = entity.block()
    if block is None:
        raise CaseError(f"{_name(entity)}: there is no block {shown(entity.dxf.name, 40)!r}: purge the drawing")
    if block.block.is_xref:
        walk.unused.setdefault("XREF (another drawing: bind it)", []).append(entity)
        return
    _count(walk, entity.mcount)
    walk.flat += _scaled(entity) and not hidden

    def skipped(inner: Any, reason: str) -> None:
        walk.unused.setdefault(f"{inner.dxftype()} of a block that is drawn askew", []).append(inner)

    for one in entity.multi_insert() if entity.mcount > 1 else [entity]:
        clip = _clip(one)
        walk.unclipped += clip is not None and not clip.areas and not hidden
        seen = (*clips, clip) if clip is not None and clip.areas else clips
        drawn = _on_layer(one.dxf.layer, one.virtual_entities(skipped_entity_callback=skipped))
        yield from _entities(walk, drawn, depth + 1, hidden, seen)


def _on_layer(layer: str, copies: Iterable[Any]) -> Iterator[Any]:
    """Copies of the entities of a block; those on layer 0 get the layer on which the block is inserted."""
    for copy in copies:
        if copy.dxf.layer == "0":
            copy.dxf.layer = layer
        yield copy


def _clip(entity: Any) -> Clip | None:
    """The clip of an insert, if it has one that is switched on; it has no areas if its outline bounds none."""
    xclip = XClip(entity)
    if not xclip.is_clipping_enabled:
        return None
    path = xclip.get_wcs_clipping_path()
    points = finite_points(path.inner_polygon(), f"{_name(entity)}: its clip")
    ring, _ = polygon_ring(points, f"{_name(entity)}: its clip")
    if ring is None or not (shape := shapely.Polygon(ring.vertices)).is_valid or shape.area == 0:
        return Clip(())
    return Clip((Area(replace(ring, origin=None)),), path.is_inverted_clip)


def _scaled(entity: Any) -> bool:
    """Replace scales of 0 of an insert by 1, and return whether one of them was a scale in the plane."""
    zero = [key for key in ("xscale", "yscale", "zscale") if entity.dxf.get(key, 1.0) == 0]
    for key in zero:
        entity.dxf.set(key, 1.0)
    return any(key != "zscale" for key in zero)


def _count(walk: _Walk, size: int) -> None:
    walk.drawn += size
    if walk.drawn > MOST_COPIES:
        what = f"more than {MOST_COPIES:,} entities, or as much in long ones"
        raise LimitError(f"its blocks draw {what}: explode them, or simplify it")


def _size(entity: Any) -> int:
    """Number of simple entities that take as long to copy, by the lists of points, knots and letters of this one."""
    parts = [value for part in (entity, *getattr(entity, "paths", ())) for value in vars(part).values()]
    return 1 + sum(len(value) for value in parts if hasattr(value, "__len__")) // POINTS


def _is_hidden(drawing: Any, entity: Any) -> bool:
    """Whether an entity is invisible, or its layer off or frozen."""
    name = entity.dxf.get("layer", "0")
    layer = drawing.layers.get(name) if name in drawing.layers else None
    return bool(entity.dxf.get("invisible", 0)) or (layer is not None and (layer.is_off() or layer.is_frozen()))


def _is_plane(entity: Any) -> bool:
    """Whether an entity lies in the plane of the drawing or in a parallel one."""
    if entity.dxftype() == "POLYLINE":
        if entity.is_3d_polyline:
            return True
        if not entity.is_2d_polyline:
            return False
    return not _is_turned(entity)


def _is_turned(entity: Any) -> bool:
    """Whether an entity is turned out of the plane of the drawing, by its extrusion."""
    direction = entity.dxf.get("extrusion", (0, 0, 1))
    return bool(abs(direction[0]) + abs(direction[1]) >= 1e-9)


def _heights(entity: Any) -> set[float]:
    """Heights of the ends of lines and polylines in space."""
    if entity.dxftype() == "LINE":
        ends = [entity.dxf.start, entity.dxf.end]
    elif entity.dxftype() == "POLYLINE" and entity.is_3d_polyline:
        ends = [vertex.dxf.location for vertex in entity.vertices]
    else:
        return set()
    return {round(float(end[2]), 9) for end in ends}


def _name(entity: Any) -> str:
    handle = entity.dxf.get("handle")
    return f"{entity.dxftype()}{f' #{handle}' if handle else ''} on layer {shown(entity.dxf.layer, 40)}"


def _unused(kind: str, entities: list[Any]) -> str:
    """Note on entities of a kind that make no ring."""
    first = entities[0]
    keys = [key for key in PLACES if first.dxf.hasattr(key)]
    at = first.dxf.get(keys[0]) if keys else None
    where = f" at {place((at[0], at[1]))}" if at is not None else ""
    turned = ": it is turned out of the plane of the drawing" if kind in CURVES and _is_turned(first) else ""
    advice = ": explode them to lines and arcs" if kind in BODIES else turned
    return f"{len(entities)} {kind} not used, the first on layer {shown(first.dxf.layer, 40)}{where}{advice}"


def _feature(found: _Drawn) -> Feature:
    """Feature with the curves and the point of an entity, its layer and its properties."""
    entity = found.entity
    kind = entity.dxftype()
    name = _name(entity)
    layer = str(entity.dxf.layer)
    label, notes = writable_label(None if layer == "0" else layer, "a layer")
    properties = {"type": kind, "handle": entity.dxf.get("handle"), "layer": layer}
    spare = HIDDEN if found.hidden else FILL if kind in FILLS else None
    feature = Feature(name, layer, properties, notes=notes, spare=spare, clips=found.clips)
    with foreign(f"{name}: not a valid curve", "draw it anew"):
        if kind == "POINT":
            return replace(feature, points=tuple(finite_points([entity.dxf.location], name)))
        made: Curves = (CURVES | FILLS)[kind](entity, name, label)
    if not made:
        return replace(feature, slips=Slips(flat=1) if kind in FILLS else Slips(doubles=1))
    rings = tuple(replace(one, origin=name) for one in made if isinstance(one, Ring))
    curves = tuple(one for one in made if isinstance(one, CompoundCurve))
    return replace(feature, rings=rings, curves=curves, slips=_doubles(kind, entity))


def _doubles(kind: str, entity: Any) -> Slips:
    """Vertices of a polyline that are given twice in a row, without one that only closes it."""
    if kind not in ("LWPOLYLINE", "POLYLINE"):
        return Slips()
    points = np.array(polyline_corners(entity), float)[:, :2]
    same = (np.diff(points, axis=0) == 0).all(axis=1)
    return Slips(doubles=int(same.sum()), first=as_point(points[:-1][same][0])) if same.any() else Slips()
