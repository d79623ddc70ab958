"""Lines and points of files, to be embedded in a domain."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import reduce
from operator import add
from pathlib import Path
from typing import NamedTuple

from bubblemesh.errors import CaseError, prefixed
from bubblemesh.geometry import rings
from bubblemesh.geometry.map_projection import UNPROJECTED, MapProjection
from bubblemesh.geometry.paths import OpenPath, Point
from bubblemesh.geometry.similarity import Similarity
from bubblemesh.messages import counted, meant, place
from bubblemesh.readers.clips import clipped
from bubblemesh.readers.features import INNER, SPARE, CompoundCurve, Feature, text_of, writable_label
from bubblemesh.readers.formats import FORMATS, length_notes, read_content
from bubblemesh.readers.projection import projected_features
from bubblemesh.readers.rings.duplicates import without_copies, without_same_circles
from bubblemesh.readers.rings.joining import Joining
from bubblemesh.readers.selection import Selection
from bubblemesh.readers.slips import Slips

MOST_NAMED = 5


class FilePoint(NamedTuple):
    """A point of a file, and its label, if any."""

    at: Point
    label: str | None


def read_lines(path: Path, selection: Selection, projection: MapProjection = UNPROJECTED) -> list[OpenPath]:
    """Lines of a file, and the sides of its rings and areas; the first has the notes on the whole file.

    Sides have the labels of the file, lines have no label. FileError, CaseError or GeometryError with the file.
    """
    with prefixed(path):
        content = read_content(path, selection, "lines")
        features, clips = clipped(projected_features(path, content, selection, projection), Joining(selection.join))
        used = _first_with(features, lambda one: one.bounds)
        curves, slips = without_copies([curve for one in used for curve in one.curves])
        found = []
        for curve in curves:
            with prefixed(curve.name):
                found.append(_line(curve))
        closed = [ring for one in used for ring in (*one.rings, *(ring for area in one.areas for ring in area))]
        loops, copies = without_same_circles(closed)
        found += [OpenPath.around(ring, "") for ring in loops]
        left_out = counted(sum(len(one.points) for one in used), "point")
        if not found:
            others = "" if left_out.startswith("no ") else f" (but {left_out})"
            raise CaseError(f"there is no line in it{others}: give lines or rings, or another layer or feature")
    slips = reduce(add, (one.slips for one in used), slips + copies)
    notes = [
        *content.notes,
        *length_notes(content, selection),
        *clips,
        *slips.notes,
        *([f"left out: {left_out}"] if not left_out.startswith("no ") else []),
    ]
    factor = selection.factor(content)
    return [_finished(line, path, factor, notes if k == 0 else ()) for k, line in enumerate(found)]


def read_inner_lines(path: Path, selection: Selection, projection: MapProjection = UNPROJECTED) -> list[OpenPath]:
    """Lines within the domain that a file describes, if its format has such lines."""
    known = FORMATS.get(path.suffix.lower())
    if known is None or not known.has_inner_lines or selection.feature is not None:
        return []
    with prefixed(path):
        content = read_content(path, selection)
        features = projected_features(path, content, selection, projection)
    curves = [curve for one in features if one.spare == INNER for curve in one.curves]
    return [_finished(_line(curve), path, selection.factor(content), ()) for curve in curves]


def _line(curve: CompoundCurve) -> OpenPath:
    return replace(rings.open_path(curve.start, curve.pieces, ""), origin=curve.name)


def _finished(line: OpenPath, path: Path, factor: float, notes: Sequence[str]) -> OpenPath:
    """The line in the case's lengths, with the file in front of its origin and of its notes."""
    named = tuple(f"{path.name}: {note}" for note in (*notes, *line.notes))
    origin = f"{path.name}: {line.origin}"
    return replace(line.moved(Similarity.of(scale=factor)), notes=named, origin=origin)


def read_points(
    path: Path, selection: Selection, name: str | None, projection: MapProjection = UNPROJECTED
) -> tuple[list[FilePoint], tuple[str, ...]]:
    """Points of a file, each place once, and notes.

    Their labels are the values of the property or column ``name``; by default those of ``label``, else of ``name``.
    FileError or CaseError with the file.
    """
    with prefixed(path):
        content = read_content(path, selection, "points")
        features, clips = clipped(projected_features(path, content, selection, projection), Joining(selection.join))
        used = _first_with(features, lambda one: bool(one.points))
        if not any(one.points for one in used):
            more = ", as no drawing in SVG has" if path.suffix.lower() == ".svg" else ""
            lines = counted(sum(len(one.curves) for one in features), "line")
            areas = counted(sum(len(one.areas) + len(one.rings) for one in features), "area")
            raise CaseError(f"there is no point in it{more} (but {lines}, {areas}): give points, or another layer")
        if name is not None:
            content.require_properties()
            _require_property(used, name)
        notes = [*content.notes, *clips]
        found: dict[Point, str | None] = {}
        slips, unused = Slips(), list[str]()
        for at, label in _places(used, name, notes):
            if at in found:
                slips += Slips(doubles=1, first=at)
                if label is not None and label != found[at]:
                    unused.append(f"{label!r} at {place(at)}, where {found[at] or 'another point'!r} is")
            else:
                found[at] = label
    factor = selection.factor(content)
    places = [FilePoint((x * factor, y * factor), label) for (x, y), label in found.items()]
    return places, tuple(
        f"{path.name}: {note}" for note in (*dict.fromkeys(notes), *slips.notes, *_unused_notes(unused))
    )


def _unused_notes(unused: Sequence[str]) -> Iterator[str]:
    """Note on labels of points in the place of others, with their places."""
    if unused:
        more = f" and {len(unused) - MOST_NAMED} more" if len(unused) > MOST_NAMED else ""
        named = ", ".join(unused[:MOST_NAMED]) + more
        yield f"{counted(len(unused), 'label')} left out, of points in the place of others: {named}"


def _first_with(features: Sequence[Feature], has: Callable[[Feature], bool]) -> list[Feature]:
    """Features to use: spare ones only if no other feature has what is looked for."""
    kinds = ([one for one in features if one.spare == kind] for kind in (None, *SPARE))
    return next((ones for ones in kinds if any(map(has, ones))), list(features))


def _places(features: Sequence[Feature], name: str | None, notes: list[str]) -> Iterator[tuple[Point, str | None]]:
    """Points with their labels; values that cannot be labels are added to the notes."""
    keys = ("label", "name") if name is None else (name.lower(),)
    for one in features:
        label, more = writable_label(text_of(one.properties, *keys), one.name)
        notes += more
        for at in one.points:
            yield at, label


def _require_property(features: Sequence[Feature], name: str) -> None:
    known = dict.fromkeys(str(key) for one in features for key in one.properties)
    if name.lower() not in map(str.lower, known):
        advice = meant(name, known) if known else "give the columns names in the first line, or leave name out"
        raise CaseError(f"no point has a {name!r} for its name: {advice}")
