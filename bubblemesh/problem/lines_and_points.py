"""Lines and points embedded in the domain of a case, as geometry."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from bubblemesh import readers
from bubblemesh.case.domain import FileDomain, InnerKeys
from bubblemesh.case.geometry_files import SelectedFile
from bubblemesh.case.lines_and_points import LineFile, LineKeys, PointFile, PointKeys
from bubblemesh.errors import Key, about, prefixed
from bubblemesh.geometry import rings
from bubblemesh.geometry.geography import projected_vertex
from bubblemesh.geometry.paths import InnerPoint, OpenPath
from bubblemesh.problem.drawing import drawn
from bubblemesh.problem.shapes import pieces_of
from bubblemesh.readers.selection import Selection

DOMAIN = Key(["domain"])


def lines_of(keys: InnerKeys) -> Iterator[OpenPath]:
    """Lines that the keys of a domain describe, with those of the file that is the domain; errors name the line."""
    made = 0
    for number, line in enumerate(keys.lines):
        key = Key((*DOMAIN, "lines", number))
        with prefixed(f"line {made + 1}"), about(key):
            found = drawn(_lines(line), line)
        for path in found:
            made += 1
            yield replace(path, label=path.label or f"line-{made}", key=key, optional=line.outside == "skip")
    if isinstance(keys, FileDomain):
        for path in drawn(readers.read_inner_lines(Path(keys.file), named_in_file(keys)), keys):
            made += 1
            yield replace(path, label=f"line-{made}", key=DOMAIN)


def _lines(line: LineKeys) -> list[OpenPath]:
    if not isinstance(line, LineFile):
        return [rings.open_path(*pieces_of(line), line.label or "")]
    found = readers.read_lines(Path(line.file), named_in_file(line))
    return [path.labelled(line.label) for path in found]


def points_of(keys: InnerKeys) -> tuple[list[InnerPoint], tuple[str, ...]]:
    """Points that the keys of a domain describe, and notes on those of files; errors name the key."""
    made: list[InnerPoint] = []
    notes: list[str] = []
    for number, point in enumerate(keys.points):
        key = Key((*DOMAIN, "points", number))
        with about(key):
            found, more = _points(point)
            notes += more
            for copy in drawn(found, point):
                label = copy.label or f"point-{len(made) + 1}"
                made.append(replace(copy, label=label, key=key, optional=point.outside == "skip"))
    return made, tuple(notes)


def _points(point: PointKeys) -> tuple[list[InnerPoint], tuple[str, ...]]:
    if not isinstance(point, PointFile):
        return [InnerPoint(projected_vertex(point.at), point.label or "")], ()
    places, notes = readers.read_points(Path(point.file), named_in_file(point), point.name)
    return [InnerPoint(place.at, (point.label or place.label or "")) for place in places], notes


def named_in_file(keys: SelectedFile) -> Selection:
    """Selection of what a file holds, whatever it is taken as."""
    return Selection(keys.layer, keys.feature, keys.scale or 1.0, keys.units)
