"""The domain that a case describes: its rings and lines as geometry, and the files that a case names."""

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from pathlib import Path

from bubblemesh.case import Case
from bubblemesh.case.data_terms import DataTerm
from bubblemesh.case.domain import (
    ArcPiece,
    CircleRing,
    DomainKeys,
    EllipseRing,
    FileDomain,
    FileRing,
    FollowedKeys,
    GeometryFile,
    InnerKeys,
    LinePiece,
    PathLine,
    PathRing,
    PolygonRing,
    RectangleRing,
    RingKeys,
    SplinePiece,
)
from bubblemesh.case.fields import Strict
from bubblemesh.errors import GeometryError, Key, about, prefixed
from bubblemesh.files import confined_to, has_copies, local_copies, read_bytes
from bubblemesh.geometry import rings
from bubblemesh.geometry.arrangement.regions import Parts, Region
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.followed import Following
from bubblemesh.geometry.paths import InnerPoint, OpenPath, Point, Ring
from bubblemesh.geometry.rings import ArcTo, LineTo, Piece, SplineTo
from bubblemesh.messages import ring_name
from bubblemesh.readers.formats import files_of, read_area, read_rings
from bubblemesh.readers.selection import Selection

DOMAIN = Key(["domain"])


def case_domain(case: Case) -> Domain:
    """The domain of a case's rings, with its regions and what is embedded; errors have the place and what to do."""
    with about(DOMAIN), own_files(case.domain, case.root):
        outer, *holes = domain_rings(case.domain)
        return Domain.of(outer, holes, _inner_parts(case.domain))


def domain_rings(keys: DomainKeys) -> list[Ring]:
    """The outer ring and the holes of a domain; errors of geometry, keys and files name the ring."""
    if isinstance(keys, FileDomain):
        return _rings_of_file(keys)
    found: list[Ring] = []
    paths = [("outer",), *(("holes", number) for number in range(len(keys.holes)))]
    for path, ring in zip(paths, (keys.outer, *keys.holes), strict=True):
        key = Key((*DOMAIN, *path))
        with prefixed(ring_name(len(found))), about(key):
            several = [replace(one, key=key) for one in rings_of(ring)]
            if not found and len(several) > 1:
                raise GeometryError(
                    f"{len(several)} rings are in the file: choose one by feature or layer, or give the file as the "
                    "whole domain"
                )
        found += several
    return found


def rings_of(keys: RingKeys) -> list[Ring]:
    """Ring that some keys describe, or all rings of the file that they name."""
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


def contents_of(model: Strict, root: Path | None) -> dict[str, bytes]:
    """Contents of the files that a case, or a part of it, names, by their names; errors have the file.

    CaseError if a file lies elsewhere than below the root of an untrusted case.
    """
    with confined_to(root):
        return {str(path): _content(path) for path in named_files(model)}


def _content(path: Path) -> bytes:
    with prefixed(path):
        return read_bytes(path)


@contextmanager
def own_files(model: Strict, root: Path | None) -> Iterator[None]:
    """Within the block libraries find no other files than copies of those that a part of an untrusted case may read.

    Nothing changes for a trusted one, and copies that are there already stay. Errors as of `contents_of`; FileError
    if there is no place for copies.
    """
    copies = nullcontext() if root is None or has_copies() else local_copies(contents_of(model, root))
    with confined_to(root), copies:
        yield


def _rings_of_file(keys: FileDomain) -> list[Ring]:
    """Outer ring and holes of the area in a file."""
    outer, *holes = read_area(Path(keys.file), _selection(keys))
    labelled = [outer.labelled(keys.label), *(hole.labelled(keys.hole_label) for hole in holes)]
    return [_followed(ring, keys) for ring in labelled]


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


def _inner_parts(keys: InnerKeys) -> Parts:
    """Regions and what is embedded; errors tell which one it is."""
    lines: list[OpenPath] = []
    for number, line in enumerate(keys.lines, start=1):
        key = Key((*DOMAIN, "lines", number - 1))
        with prefixed(f"line {number}"), about(key):
            path = rings.open_path(*_pieces(line), line.label or f"line-{number}")
        lines.append(replace(path, key=key))
    points = (
        InnerPoint(point.at, point.label or f"point-{number}", Key((*DOMAIN, "points", number - 1)))
        for number, point in enumerate(keys.points, start=1)
    )
    return Parts(tuple(_regions(keys)), keys.region, tuple(lines), tuple(points), keys.periodic)


def _regions(keys: InnerKeys) -> Iterator[Region]:
    for number, model in enumerate(keys.regions):
        key = Key((*DOMAIN, "regions", number))
        with prefixed(f"region {model.name!r}"), about(key):
            found = [replace(ring, key=key) for ring in rings_of(model.ring)]
        rim = f"{model.name}-rim"  # also where a file calls the ring as the case calls the region
        yield from (Region(ring.renamed(model.name, rim), model.name, label=rim) for ring in found)
