"""Lists of points as text: rings, open lines, or single points."""

import math
from collections.abc import Callable, Iterator
from itertools import groupby, pairwise
from pathlib import Path
from typing import Any, NamedTuple

from bubblemesh.errors import CaseError
from bubblemesh.files import read_text
from bubblemesh.geometry.paths import Point
from bubblemesh.messages import shown
from bubblemesh.readers.airfoils import NumberRows, airfoil_outlines, points_of_rows
from bubblemesh.readers.features import Feature, FeatureCollection, finite_points, line_curve, polygon_ring
from bubblemesh.readers.slips import Slips
from bubblemesh.readers.tables import (
    NUMBER,
    SEPARATOR,
    STARTS_AS_NUMBER,
    TableLine,
    has_decimal_commas,
    named_rows,
    number_of,
    numbers_in,
    plain_line,
    table_lines,
    title_line,
)

FEWEST_POINTS = 3  # points of a ring, after which a line of words ends it


def read_rings(path: Path) -> FeatureCollection:
    """A ring for each block of points; blocks are separated by blank lines and rows of nan, and may begin with words.

    Columns are found by the names x and y, if the first line has names. The formats of programs for airfoils are known.
    FileError, or CaseError with the line.
    """
    return _listed(path, "ring", polygon_ring, "rings")


def read_lines(path: Path) -> FeatureCollection:
    """An open line for each block of points, as `read_rings` reads them."""
    return _listed(path, "line", line_curve, "curves")


def _listed(
    path: Path, noun: str, made: Callable[[list[Point], str], tuple[Any, Slips]], key: str
) -> FeatureCollection:
    """A feature for each block of points, which holds under ``key`` what ``made`` returns, unless that is None."""
    found = _blocks(path)
    features: list[Feature] = []
    for block in found.blocks:
        name = f"{noun} {len(features)} (line {block.line})"
        one, slips = made(finite_points(points_of_rows(block), name), name)
        held: dict[str, Any] = {key: () if one is None else (one,)}
        features.append(Feature(name, slips=slips, **held))
    return FeatureCollection(tuple(features), found.notes)


def read_points(path: Path) -> FeatureCollection:
    """A point for each row, with its cells by the names of the columns as properties.

    Without names the first two numbers of each row are x and y. FileError, or CaseError with the line.
    """
    text = read_text(path)
    named = named_rows(text)
    if named is not None:
        rows = [(row.number, row.place, row.cells) for row in named[0] if row.place is not None]
        notes: tuple[str, ...] = (f"columns {named[1]} are taken as x and y",)
    else:
        rows, notes = _first_two(text)
    features: list[Feature] = []
    for number, place, cells in rows:
        name = f"point in line {number}"
        features.append(Feature(name, properties=cells, points=tuple(finite_points([place], name))))
    if not features:
        raise CaseError("there are no points in it: give two numbers in a line")
    return FeatureCollection(tuple(features), notes)


def _first_two(text: str) -> tuple[list[tuple[int, tuple[float, float], dict[str, str]]], tuple[str, ...]]:
    """Line, place and empty properties of each row with two numbers or more, and notes; words are left out."""
    decimal = has_decimal_commas(text, title_line(text))
    rows, widest, notes = [], 0, list[str]()
    for number, line in enumerate(text.splitlines(), start=1):
        plain = plain_line(line, number)
        plain = plain.replace(",", ".") if decimal else plain
        words = [word for word in SEPARATOR.split(plain) if NUMBER.fullmatch(word)]
        if len(words) >= 2:
            rows.append((number, (number_of(words[0]), number_of(words[1])), dict[str, str]()))
            widest = max(widest, len(words))
        elif plain and rows:
            raise CaseError(f"line {number}: not a point: {shown(line, 40)!r}: give two numbers in a line")
        elif plain and _is_slip(line):
            notes.append(_header_note(number, line))
    if widest > 2:
        more = "name columns x and y in the first line to choose"
        notes.append(f"the first two numbers of each line are taken as x and y: {more}")
    return rows, tuple(notes)


class _Blocks(NamedTuple):
    """Blocks of points, and notes on what was left out and how lines were read."""

    blocks: list[NumberRows]
    notes: tuple[str, ...]


def _blocks(path: Path) -> _Blocks:
    """Blocks of a file; FileError, or CaseError with the line."""
    text = read_text(path)
    notes: dict[str, None] = {}
    named = named_rows(text, fewest=3)
    if named is not None:
        lines = [TableLine(row.number, "", list(row.place) if row.place else []) for row in named[0]]
        blocked = _blocked([row.cells for row in named[0]], named[1])
        notes[f"columns {named[1]} are taken as x and y, others are not used{blocked}"] = None
        found = list(_parted(iter([*lines, TableLine(0, "", [])]), notes))
    else:
        title = title_line(text)
        if has_decimal_commas(text, title):
            notes["commas are taken as decimal points"] = None
            text = text.replace(",", ".")
        found = list(_parted(table_lines(text, title), notes))
    blocks, more = airfoil_outlines(found)
    if not blocks:
        raise CaseError("there are no points in it: give two numbers in a line")
    if any(len(row) > 2 for block in blocks for row in block.rows):
        notes["columns after the second are not used" + _index(blocks)] = None
    return _Blocks(blocks, (*notes, *more))


def _blocked(rows: list[dict[str, str]], used: str) -> str:
    """Advice if blocks of rows have a value each in the first column, none of those ``used``, as an id; else empty."""
    first = next(iter(next(filter(None, rows), {})), "")
    if not first or repr(first) in used:
        return ""
    values = [row.get(first, "") for row in rows]
    runs = [len(list(run)) for _, run in groupby(values)]
    several = len(runs) > 1 and min(runs) > 1 and len(runs) == len(set(values))
    if not several:
        return ""
    return f", not even {first!r} with its {len(runs)} values: put blank lines between what is apart"


def _index(blocks: list[NumberRows]) -> str:
    """Advice if the first column may be an index; else empty."""
    first = [row[0] for block in blocks for row in block.rows]
    counts = len(first) > FEWEST_POINTS and first[0] in (0, 1) and all(b - a == 1 for a, b in pairwise(first))
    return ", and the first, which counts the rows, is x: name columns x and y in the first line" if counts else ""


def _parted(lines: Iterator[TableLine], notes: dict[str, None]) -> Iterator[NumberRows]:
    """The blocks of rows; notes are added on what is left out."""
    rows: list[list[float]] = []
    first = 0
    for number, text, values in lines:
        if values is None:
            if _is_slip(text):
                if rows:
                    raise _no_point(number, text)
                notes[_header_note(number, text)] = None
            elif 0 < len(rows) < FEWEST_POINTS:
                raise _no_point(number, text)
            elif rows:
                notes[f"line {number} is taken as text after a ring: {shown(text, 40)!r}"] = None
        if not values or all(math.isnan(value) for value in values[:2]):
            if rows:
                yield NumberRows(first, rows)
            rows = []
            continue
        if len(values) < 2:
            raise CaseError(f"line {number}: one number alone: a point has two; put # before a header")
        first = first if rows else number
        rows.append(values)


def _no_point(number: int, text: str) -> CaseError:
    return CaseError(f"line {number}: not a point: {shown(text, 40)!r}: give two numbers in a line")


def _header_note(number: int, text: str) -> str:
    return f"line {number} is taken as a header: {shown(text, 40)!r}"


def _is_slip(text: str) -> bool:
    """Whether a line of words may be a mistyped point, as ``O 0`` or ``1.O 0``, and not a header, as ``NACA 0012``."""
    words = [word for word in SEPARATOR.split(text.strip().replace('"', "")) if word]
    if STARTS_AS_NUMBER.match(words[0]):
        return True
    others = [word for word in words if numbers_in([word]) is None]
    return len(others) < len(words) and any(len(word) == 1 or any(c.isdigit() for c in word) for word in others)
