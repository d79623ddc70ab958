"""Rings and lines of a case as geometry, and the files that they, and the data of the spacing, are in."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from bubblemesh.case.data_terms import DataTerm
from bubblemesh.case.domain import EmbeddedLine, FileDomain
from bubblemesh.case.fields import Strict
from bubblemesh.case.paths import ArcPiece, LinePiece, PathLine, PathRing, SplinePiece
from bubblemesh.case.rings import (
    CircleRing,
    EllipseRing,
    FileRing,
    FollowedKeys,
    GeometryFile,
    PolygonRing,
    RectangleRing,
    RingKeys,
)
from bubblemesh.errors import prefixed
from bubblemesh.geometry import rings
from bubblemesh.geometry.followed import Following
from bubblemesh.geometry.paths import OpenPath, Point, Ring
from bubblemesh.geometry.rings import ArcTo, LineTo, Piece, SplineTo
from bubblemesh.readers.formats import files_of, read_area, read_rings
from bubblemesh.readers.selection import Selection


def rings_of(keys: RingKeys) -> list[Ring]:
    """Ring that some keys describe, or all rings of the file that they name.

    Raises
    ------
    GeometryError, CaseError, FileError
    """
    match keys:
        case PolygonRing():
            return [_followed(rings.polygon(keys.polygon, keys.labels, keys.label), keys)]
        case RectangleRing():
            return [rings.rectangle(*keys.rectangle, labels=keys.labels, label=keys.label)]
        case CircleRing():
            return [rings.circle(keys.circle.center, keys.circle.radius, keys.label)]
        case EllipseRing():
            return [rings.ellipse(keys.ellipse.center, keys.ellipse.radii, keys.ellipse.angle, keys.label)]
        case PathRing():
            return [rings.path(*_pieces(keys), keys.label)]
        case FileRing():
            found = read_rings(Path(keys.file), _selection(keys))
            return [_followed(ring.labelled(keys.label), keys) for ring in found]


def rings_of_file(keys: FileDomain) -> list[Ring]:
    """Outer ring and holes of the area in a file; errors as of `rings_of`."""
    outer, *holes = read_area(Path(keys.file), _selection(keys))
    labelled = [outer.labelled(keys.label), *(hole.labelled(keys.hole_label) for hole in holes)]
    return [_followed(ring, keys) for ring in labelled]


def open_path(keys: EmbeddedLine, default: str) -> OpenPath:
    """The line that some keys describe, with a label if they give none; errors as of `rings_of`."""
    return rings.open_path(*_pieces(keys), keys.label or default)


def named_files(model: Strict) -> Iterator[Path]:
    """The files that a case, or a part of it, names, with those that belong to them."""
    if isinstance(model, GeometryFile):
        yield from files_of(Path(model.file))
    if isinstance(model, DataTerm):
        yield from model.files()
    for _, value in model:
        for part in value if isinstance(value, tuple) else [value]:
            if isinstance(part, Strict):
                yield from named_files(part)


def _pieces(keys: PathLine) -> tuple[Point, list[Piece]]:
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


def _selection(keys: GeometryFile) -> Selection:
    """Selection of what a file holds."""
    return Selection(keys.layer, keys.feature, keys.scale or 1.0, keys.units, keys.join)


def _followed(ring: Ring, keys: FollowedKeys) -> Ring:
    """The ring, followed as a curve if the keys say so; errors tell the file and place that it comes from."""
    if keys.corners is None:
        return ring
    follow = Following(keys.corners, keys.smooth, keys.tolerance)
    if ring.origin is None:
        return follow(ring)
    with prefixed(ring.origin):
        return replace(follow(ring), origin=ring.origin)
