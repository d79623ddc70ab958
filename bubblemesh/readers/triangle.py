"""Input of the Triangle program: ``.poly`` files with their vertices, segments, markers and holes."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import inf
from pathlib import Path

import shapely

from bubblemesh.errors import CaseError, prefixed
from bubblemesh.geometry.paths import Point
from bubblemesh.geometry.rings import LineTo
from bubblemesh.readers.features import (
    INNER,
    NO_PARTS,
    REGION,
    CompoundCurve,
    Feature,
    FeatureCollection,
    feature_of,
    finite_points,
    parts_of,
    text_of_number,
)
from bubblemesh.readers.rings.duplicates import without_copies
from bubblemesh.readers.segments import split_segments
from bubblemesh.readers.triangle_rows import NumberedRow, numbered_rows, section_head, section_rows

MOST_NAMED = 5  # segments in a note


def read_poly(path: Path) -> FeatureCollection:
    """The segments of a ``.poly`` file: those around the domain, and inner segments and regions as spare features.

    - The domain is the area that segments enclose, without parts that contain hole points.
    - A boundary marker other than 0 becomes the label of its segment.
    - A region is the part that contains its point; its properties are the regional ``attribute`` and the largest
      ``area`` of triangles.
    - Vertices that the file leaves out are read from the ``.node`` file beside it.

    FileError or CaseError with the line.
    """
    rows = numbered_rows(path)
    count, dimension = section_head(rows, "the number of vertices")
    vertices = _vertices(rows, count, dimension) if count else _vertices_beside(path.with_suffix(".node"))
    segments, slips = without_copies(list(_segments(rows, vertices)))
    if not segments:
        raise CaseError("it has no segments: give those around the domain, or the points as a .csv file in order")
    holes = finite_points(
        [(x, y) for _, (_, x, y, *_) in _optional_section(rows, "a hole: its number, x and y")], "hole"
    )
    regions = [row for _, row in _optional_section(rows, "a region: its number, x and y")]
    found = split_segments(segments, holes)
    features = [Feature("the segments", properties={"kind": "boundary"}, curves=tuple(found.around), slips=slips)]
    if found.inner:
        inner = tuple(found.inner)
        features.append(Feature("the inner segments", properties={"kind": "inner"}, curves=inner, spare=INNER))
    features += [_region(number, row, found.parts) for number, row in enumerate(regions)]
    notes = [f"left out, outside of the domain: {_named(found.outside)}"] if found.outside else []
    notes += [f"cut off at the boundary, beyond which they go on: {_named(found.crossing)}"] if found.crossing else []
    return FeatureCollection(tuple(features), tuple(notes), tuple(holes))


def read_nodes(path: Path) -> FeatureCollection:
    """The points of a ``.node`` file, with their numbers, attributes and markers as properties."""
    rows = numbered_rows(path)
    count, more = section_head(rows, "the number of vertices")
    attributes = more[1] if len(more) > 1 else 0
    if more and more[0] != 2:
        raise _not_plane(more[0])
    features = []
    for line, (number, x, y, *rest) in section_rows(rows, count, "a vertex: its number, x and y"):
        name = f"vertex in line {line}"
        properties = {"number": number} | {
            f"attribute {k}": value for k, value in enumerate(rest[:attributes], start=1)
        }
        properties |= dict(zip(["marker"], rest[attributes:], strict=False))
        features.append(Feature(name, properties=properties, points=tuple(finite_points([(x, y)], name))))
    return FeatureCollection(tuple(features))


def _segments(rows: Iterator[NumberedRow], vertices: dict[float, Point]) -> Iterator[CompoundCurve]:
    """The curve of each segment with a length."""
    count, marked = section_head(rows, "the number of segments")
    for line, (_, begin, end, *marker) in section_rows(rows, count, "a segment: its number and two vertices"):
        name = f"segment in line {line}"
        if begin not in vertices or end not in vertices:
            missing = begin if begin not in vertices else end
            raise CaseError(
                f"{name}: there is no vertex {text_of_number(missing)}: vertices are named by their numbers"
            )
        label = text_of_number(marker[0]) if marked and marked[0] and marker and marker[0] else None
        if vertices[begin] != vertices[end]:
            yield CompoundCurve(vertices[begin], (LineTo(vertices[end], label),), name)


def _named(segments: Sequence[CompoundCurve]) -> str:
    named = ", ".join(segment.name for segment in segments[:MOST_NAMED])
    return f"{named} and {len(segments) - MOST_NAMED} more" if len(segments) > MOST_NAMED else named


def _optional_section(rows: Iterator[NumberedRow], what: str) -> Iterator[NumberedRow]:
    """Rows of a section that may be left out at the end of the file."""
    first = next(rows, None)
    if first is None:
        return iter(())
    count, _ = section_head(iter([first]), f"the number of {what.split(':')[0].split()[-1]}s")
    return section_rows(rows, count, what)


def _region(number: int, row: list[float], parts: Sequence[shapely.Polygon]) -> Feature:
    """The part of the domain that contains the point of a region; an empty feature if there is none."""
    name, (x, y) = f"region {text_of_number(row[0])}", row[1:3]
    properties = {"kind": "region", "number": number} | dict(zip(("attribute", "area"), row[3:], strict=False))
    around = next((part for part in parts if shapely.contains_xy(part, x, y)), None)
    feature = feature_of(NO_PARTS if around is None else parts_of(around), name, None, properties)
    area = row[4] if len(row) > 4 else 0.0
    return replace(feature, spare=REGION, largest=area if 0 < area < inf else None)


def _vertices_beside(path: Path) -> dict[float, Point]:
    """Vertices of a ``.node`` file; errors name it."""
    with prefixed(f"its vertices are in {path.name}"):
        rows = numbered_rows(path)
        return _vertices(rows, *section_head(rows, "the number of vertices"))


def _vertices(rows: Iterator[NumberedRow], count: int, dimension: list[int]) -> dict[float, Point]:
    """Vertices by their numbers."""
    if dimension and dimension[0] != 2:
        raise _not_plane(dimension[0])
    found: dict[float, Point] = {}
    for line, (number, x, y, *_) in section_rows(rows, count, "a vertex: its number, x and y"):
        if number in found:
            raise CaseError(
                f"line {line}: the vertex {text_of_number(number)} is given twice: number them one after the other"
            )
        (found[number],) = finite_points([(x, y)], f"vertex in line {line}")
    return found


def _not_plane(dimension: int) -> CaseError:
    return CaseError(f"the vertices have {dimension} dimensions: only those of the plane are read")
