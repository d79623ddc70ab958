"""Rings and lines of a case as geometry."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from bubblemesh import readers
from bubblemesh.case.geometry_files import FollowedKeys, GeometryFile
from bubblemesh.case.shapes import (
    RINGS,
    ArcPiece,
    CircleRing,
    EllipseRing,
    FileRing,
    IntersectionRing,
    LinePiece,
    MinusRing,
    OverlaidKeys,
    PathLine,
    PathRing,
    PlainKeys,
    PolygonRing,
    RectangleRing,
    RingKeys,
    SplinePiece,
    UnionRing,
)
from bubblemesh.errors import CaseError, GeometryError, prefixed
from bubblemesh.geometry import rings
from bubblemesh.geometry.arrangement.overlay import Rule, overlaid
from bubblemesh.geometry.following import Following
from bubblemesh.geometry.map_projection import UNPROJECTED, MapProjection
from bubblemesh.geometry.nesting import nested
from bubblemesh.geometry.paths import Area, Point, Ring, as_point
from bubblemesh.geometry.rings import ArcTo, LineTo, Piece, SplineTo
from bubblemesh.messages import given_coordinates
from bubblemesh.problem.drawing import drawn
from bubblemesh.problem.repair import repair_of
from bubblemesh.readers.selection import METRES, Selection


def outer_areas_of(keys: RingKeys, projection: MapProjection) -> list[Area]:
    """Areas that the ring that some keys describe encloses, or the parts of a file that they take, with their holes."""
    if not isinstance(keys, FileRing):
        return areas_of(keys, projection)
    return _finished(readers.read_areas(Path(keys.file), selection_of(keys), projection), keys)


def hole_areas_of(keys: RingKeys, projection: MapProjection) -> list[Area]:
    """Areas that some keys leave out of the mesh: within all rings that they describe, as these nest."""
    if not isinstance(keys, FileRing):
        return areas_of(keys, projection)
    if keys.repair:
        return _finished(readers.read_shapes(Path(keys.file), selection_of(keys), projection, united=True), keys)
    found = areas_of(keys, projection)
    return nested(found) if len(found) > 1 else found


def region_areas_of(keys: RingKeys, projection: MapProjection) -> list[Area]:
    """Areas of a region, within any of the rings that some keys describe; a repair of a file unites those that meet."""
    if not isinstance(keys, FileRing):
        return areas_of(keys, projection)
    return _finished(
        readers.read_shapes(Path(keys.file), selection_of(keys), projection, united=True, nested=False), keys
    )


def areas_of(keys: RingKeys, projection: MapProjection = UNPROJECTED) -> list[Area]:
    """Areas within the rings that some keys describe, or all areas of the file that they name, with all copies."""
    match keys:
        case RectangleRing():
            return _plain(projection.ring(given_ring(keys)), keys)
        case CircleRing():
            center = projection.point(keys.circle.center)
            radius = projection.length(keys.circle.radius, keys.circle.center)
            return _plain(rings.circle(center, radius, keys.label), keys)
        case EllipseRing():
            center, given = projection.point(keys.ellipse.center), keys.ellipse
            radii = as_point([projection.length(radius, given.center) for radius in given.radii])
            return _plain(rings.ellipse(center, radii, given.angle, keys.label), keys)
        case PathRing():
            return _plain(rings.path(*pieces_of(keys, projection), keys.label), keys)
        case PolygonRing():
            return _finished(repair_of(keys)([Area(projection.ring(given_ring(keys)))]), keys)
        case FileRing():
            return _finished(readers.read_shapes(Path(keys.file), selection_of(keys), projection), keys)
        case UnionRing():
            return _finished(_overlaid("union", keys.union, projection), keys)
        case MinusRing():
            return _finished(_overlaid("minus", keys.minus, projection), keys)
        case IntersectionRing():
            return _finished(_overlaid("intersection", keys.intersection, projection), keys)


def given_ring(keys: RectangleRing | PolygonRing) -> Ring:
    """A rectangle or a polygon, as given."""
    with given_coordinates():
        if isinstance(keys, RectangleRing):
            return rings.rectangle(*keys.rectangle, labels=keys.labels, label=keys.label)
        return rings.polygon(keys.polygon, keys.labels, keys.label)


def _plain(ring: Ring, keys: PlainKeys) -> list[Area]:
    """The areas within a ring and its copies."""
    return list(map(Area, drawn([ring], keys)))


def _finished(areas: Sequence[Area], keys: FileRing | PolygonRing | OverlaidKeys) -> list[Area]:
    """The areas with the label that the keys give, where they take them, and followed as they say."""
    labelled = [area.mapped(lambda ring: ring.labelled(keys.label)) for area in areas]
    return [area.mapped(lambda ring: followed(ring, keys)) for area in drawn(labelled, keys)]


def require_needed(areas: Sequence[Area]) -> None:
    """Check that areas are no copies that may be left out; else it is a CaseError."""
    if any(area.outer.optional for area in areas):
        raise CaseError(
            "repeat: outside: skip is for holes, regions, lines and points, which lie in the domain: leave it out here"
        )


def _overlaid(rule: Rule, operands: Sequence[RingKeys], projection: MapProjection) -> list[Area]:
    """Areas that other rings give by a rule; GeometryError with what they are if there is none."""
    areas = []
    for number, operand in enumerate(operands, start=1):
        with prefixed(f"{rule}, ring {number}"):
            areas.append(_operand(operand, projection))
            require_needed(areas[-1])
    found = overlaid(rule, areas)
    if not found:
        advice = "they do not overlap" if rule == "intersection" else "the others cover all of the first"
        raise GeometryError(
            f"nothing is left of {rule}: [{', '.join(map(_name, operands))}]: {advice}: move or remove one"
        )
    return found


def _operand(keys: RingKeys, projection: MapProjection) -> list[Area]:
    """Areas of a ring that others are overlaid with: of a file all of them, with their holes."""
    if not isinstance(keys, FileRing):
        return areas_of(keys, projection)
    selection = selection_of(keys)
    return _finished(
        readers.read_areas(Path(keys.file), replace(selection, part=selection.part or "all"), projection), keys
    )


def _name(keys: RingKeys) -> str:
    """Name of a ring among others in messages: its kind and its label, or its file."""
    name = keys.file if isinstance(keys, FileRing) else keys.label
    kind = next(key for key in RINGS.keys if key in type(keys).model_fields)
    return f"{kind} {name!r}" if name else kind


def pieces_of(keys: PathLine, projection: MapProjection) -> tuple[Point, list[Piece]]:
    """The first point of a path, and the geometry of the pieces from there."""
    start, *entries = keys.path
    assert isinstance(start, tuple)
    first = projection.point(start)
    at, pieces = start, list[Piece]()
    for entry in entries:
        match entry:
            case ArcPiece() if projection.system is not None:
                raise CaseError("crs: an arc cannot be projected: give a spline, or straight sides")
            case ArcPiece(arc=arc):
                pieces.append(ArcTo(arc.to, arc.center, arc.turn == "left", entry.label))
                at = arc.to
            case SplinePiece():
                *inner, at = entry.spline.through
                pieces.append(SplineTo((*map(projection.point, inner), projection.point(at)), entry.label))
            case LinePiece(to=to, label=label):
                pieces += [LineTo(place, label) for place in projection.side(at, to)]
                at = to
            case to:
                pieces += map(LineTo, projection.side(at, to))
                at = to
    if isinstance(keys, PathRing):
        pieces += [LineTo(place, keys.label) for place in projection.side(at, start)[:-1]]
    return first, pieces


def selection_of(keys: GeometryFile) -> Selection:
    """Selection of what a file holds."""
    repair = repair_of(keys)
    asked = repair if repair.asked else None
    return Selection(keys.layer, keys.feature, keys.scale or 1.0, keys.units, keys.part, keys.join, keys.open, asked)


def length_in_file(keys: GeometryFile) -> float | None:
    """Length in the case that a length of 1 in a file is; None if the file itself says so."""
    if keys.units and Path(keys.file).suffix.lower() == ".svg":
        return None
    return METRES[keys.units] if keys.units else keys.scale or 1.0


def followed(ring: Ring, keys: FollowedKeys) -> Ring:
    """The ring, followed as a curve if the keys say so; errors name the file and place that it comes from."""
    if keys.corners is None:
        return ring
    follow = Following(keys.corners, keys.smooth, keys.tolerance)
    if ring.origin is None:
        return follow(ring)
    with prefixed(ring.origin):
        return replace(follow(ring), origin=ring.origin)
