"""Rings and lines of a case as geometry."""

from dataclasses import replace
from pathlib import Path

from bubblemesh.case.geometry_files import FollowedKeys, GeometryFile
from bubblemesh.case.shapes import (
    ArcPiece,
    CircleRing,
    EllipseRing,
    FileRing,
    LinePiece,
    PathLine,
    PathRing,
    PolygonRing,
    RectangleRing,
    RingKeys,
    SplinePiece,
)
from bubblemesh.errors import prefixed
from bubblemesh.geometry import rings
from bubblemesh.geometry.followed import Following
from bubblemesh.geometry.paths import Area, Point, Ring
from bubblemesh.geometry.rings import ArcTo, LineTo, Piece, SplineTo
from bubblemesh.problem.drawing import drawn
from bubblemesh.readers.formats import read_areas, read_rings, read_shapes, require_ring
from bubblemesh.readers.selection import Selection


def rings_of(keys: RingKeys) -> list[Ring]:
    """Ring that some keys describe, or all rings of the file that they name, with all copies."""
    found = drawn(_rings(keys), keys)
    return [followed(ring, keys) for ring in found] if isinstance(keys, FollowedKeys) else found


def _rings(keys: RingKeys) -> list[Ring]:
    """Rings before they are moved."""
    match keys:
        case PolygonRing():
            return [rings.polygon(keys.polygon, keys.labels, keys.label)]
        case RectangleRing():
            return [rings.rectangle(*keys.rectangle, labels=keys.labels, label=keys.label)]
        case CircleRing():
            return [rings.circle(keys.circle.center, keys.circle.radius, keys.label)]
        case EllipseRing():
            return [rings.ellipse(keys.ellipse.center, keys.ellipse.radii, keys.ellipse.angle, keys.label)]
        case PathRing():
            return [rings.path(*pieces_of(keys), keys.label)]
        case FileRing():
            return [ring.labelled(keys.label) for ring in read_rings(Path(keys.file), selection_of(keys))]


def outer_rings_of(keys: RingKeys) -> list[Ring]:
    """Ring that some keys describe, or the rings around the parts of a file that they take, with all copies."""
    if not isinstance(keys, FileRing):
        return rings_of(keys)
    path = Path(keys.file)
    found = [require_ring(path, area).labelled(keys.label) for area in read_areas(path, selection_of(keys))]
    return [followed(ring, keys) for ring in drawn(found, keys)]


def areas_of(keys: RingKeys) -> list[Area]:
    """What the ring that some keys describe encloses, or all areas of the file that they name, with all copies."""
    if not isinstance(keys, FileRing):
        return [Area(ring) for ring in rings_of(keys)]
    found = read_shapes(Path(keys.file), selection_of(keys))
    labelled = [area.mapped(lambda ring: ring.labelled(keys.label)) for area in found]
    return [area.mapped(lambda ring: followed(ring, keys)) for area in drawn(labelled, keys)]


def pieces_of(keys: PathLine) -> tuple[Point, list[Piece]]:
    """The first point of a path, and the geometry of the pieces from there."""
    start, *entries = keys.path
    assert isinstance(start, tuple)
    pieces: list[Piece] = []
    for entry in entries:
        match entry:
            case LinePiece():
                pieces.append(LineTo(entry.to, entry.label))
            case ArcPiece(arc=arc):
                pieces.append(ArcTo(arc.to, arc.center, arc.turn == "left", entry.label))
            case SplinePiece():
                pieces.append(SplineTo(entry.spline.through, entry.label))
            case point:
                pieces.append(LineTo(point))
    return start, pieces


def selection_of(keys: GeometryFile) -> Selection:
    """Selection of what a file holds."""
    return Selection(keys.layer, keys.feature, keys.scale or 1.0, keys.units, keys.part, keys.join)


def followed(ring: Ring, keys: FollowedKeys) -> Ring:
    """The ring, followed as a curve if the keys say so; errors tell the file and place that it comes from."""
    if keys.corners is None:
        return ring
    follow = Following(keys.corners, keys.smooth, keys.tolerance)
    if ring.origin is None:
        return follow(ring)
    with prefixed(ring.origin):
        return replace(follow(ring), origin=ring.origin)
