"""Lines and points embedded in the domain of a case, as geometry."""

from collections.abc import Sequence, Set
from dataclasses import replace
from pathlib import Path

from bubblemesh import readers
from bubblemesh.case.domain import FileDomain, InnerKeys
from bubblemesh.case.geometry_files import SelectedFile
from bubblemesh.case.lines_and_points import LineFile, LineKeys, PointFile, PointKeys
from bubblemesh.errors import Key, about, prefixed
from bubblemesh.geometry.following import SEVERAL, Following
from bubblemesh.geometry.line_detail import simplified_lines
from bubblemesh.geometry.line_ends import joined, shared_vertices
from bubblemesh.geometry.map_projection import MapProjection
from bubblemesh.geometry.paths import InnerPoint, OpenPath, Point, Ring
from bubblemesh.geometry.rings import open_path
from bubblemesh.problem.drawing import drawn
from bubblemesh.problem.shapes import pieces_of
from bubblemesh.readers.selection import METRES, Selection

DOMAIN = Key(["domain"])
SMOOTH = 30.0  # degrees: vertices that turn by less may be those of a curve


def lines_of(keys: InnerKeys, rings: Sequence[Ring], projection: MapProjection) -> list[OpenPath]:
    """Lines that the keys of a domain describe, with those of the file that is the domain; errors name the line.

    Ends of lines may be joined to each other, and to the rings around the domain, its holes and its regions.
    """
    lines, models = list[OpenPath](), list[LineKeys | None]()
    for number, line in enumerate(keys.lines):
        key = Key((*DOMAIN, "lines", number))
        with prefixed(f"line {len(lines) + 1}"), about(key):
            found = drawn(_lines(line, projection), line)
        for path in found:
            label = path.label or f"line-{len(lines) + 1}"
            optional = path.optional or line.outside == "skip"
            lines.append(replace(path, label=label, named=bool(path.label), key=key, optional=optional))
            models.append(line)
    if isinstance(keys, FileDomain):
        for path in drawn(readers.read_inner_lines(Path(keys.file), named_in_file(keys), projection), keys):
            lines.append(replace(path, label=f"line-{len(lines) + 1}", named=False, key=DOMAIN))
            models.append(None)
    return _with_changes(lines, models, rings)


def _with_changes(lines: list[OpenPath], models: Sequence[LineKeys | None], rings: Sequence[Ring]) -> list[OpenPath]:
    """The lines, joined, simplified and followed as curves, if the keys that describe them say so."""
    asked = [(0.0, 0.0, None) if model is None else _changes(model) for model in models]
    joins, tolerances, follow = zip(*asked, strict=True) if asked else ((), (), ())
    if not any(map(any, asked)):
        return lines
    lengths = [line.unit for line in lines]
    joined_lines = joined(lines, [a * b for a, b in zip(joins, lengths, strict=True)], rings)
    stay = shared_vertices(joined_lines, rings)
    sparse = simplified_lines(joined_lines, [a * b for a, b in zip(tolerances, lengths, strict=True)], rings, stay)
    return [line if how is None else _followed(line, how, stay) for line, how in zip(sparse, follow, strict=True)]


def _changes(line: LineKeys) -> tuple[float, float, Following | None]:
    """The lengths up to which the ends of lines are joined and lines are simplified, and how they are followed."""
    if not isinstance(line, LineFile):
        return line.join or 0.0, 0.0, None
    follow = None if line.corners is None else Following(line.corners, line.smooth, line.tolerance)
    return line.join or 0.0, line.simplify or 0.0, follow


def _followed(line: OpenPath, follow: Following, stay: Set[Point]) -> OpenPath:
    with prefixed(line.origin or f"line {line.name}"), about(line.key):
        return follow.along(line, stay)


def _lines(line: LineKeys, projection: MapProjection) -> list[OpenPath]:
    if not isinstance(line, LineFile):
        return [open_path(*pieces_of(line, projection), line.label or "")]
    found = readers.read_lines(Path(line.file), named_in_file(line), projection)
    return [path.labelled(line.label) for path in found]


def has_followable(lines: Sequence[OpenPath]) -> bool:
    """Whether lines of files, which take the key, have several vertices that would be no nodes with some corners."""
    of_files = [line for line in lines if line.origin is not None and line.key != DOMAIN]
    follow = Following(SMOOTH)
    return sum(len(line.vertices) - len(follow.along(line, set()).vertices) for line in of_files) >= SEVERAL


def points_of(keys: InnerKeys, projection: MapProjection) -> tuple[list[InnerPoint], tuple[str, ...]]:
    """Points that the keys of a domain describe, and notes on those of files; errors name the key."""
    made: list[InnerPoint] = []
    notes: list[str] = []
    for number, point in enumerate(keys.points):
        key = Key((*DOMAIN, "points", number))
        with about(key):
            found, more = _points(point, projection)
            notes += more
            for copy in drawn(found, point):
                label = copy.label or f"point-{len(made) + 1}"
                made.append(replace(copy, label=label, key=key, optional=copy.optional or point.outside == "skip"))
    return made, tuple(notes)


def _points(point: PointKeys, projection: MapProjection) -> tuple[list[InnerPoint], tuple[str, ...]]:
    if not isinstance(point, PointFile):
        return [InnerPoint(projection.point(point.at), point.label or "", reach=point.join or 0.0)], ()
    places, notes = readers.read_points(Path(point.file), named_in_file(point), point.name, projection)
    reach = (point.join or 0.0) * (METRES[point.units] if point.units else point.scale or 1.0)
    return [InnerPoint(place.at, (point.label or place.label or ""), reach=reach) for place in places], notes


def named_in_file(keys: SelectedFile) -> Selection:
    """Selection of what a file holds, whatever it is taken as."""
    return Selection(keys.layer, keys.feature, keys.scale or 1.0, keys.units)
