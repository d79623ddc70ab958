"""Lists of points and tables as text: numbers in a line, separated by commas, semicolons or blanks.

In a line with semicolons a comma is a decimal point.
"""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import CaseError
from bubblemesh.files import read_text
from bubblemesh.geometry.paths import Point
from bubblemesh.messages import shown
from bubblemesh.readers.features import Feature, FeatureCollection, finite_points, polygon_ring

SEPARATOR = re.compile(r"\s*[,;]\s*|\s+")
COMMENT = re.compile(r"[#%!].*")
# Of no text can one part be a match in two ways: a line of a thousand digits would be tried in a million.
NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?|[-+]?(nan|inf|infinity)", re.IGNORECASE)
STARTS_AS_NUMBER = re.compile(r"[-+.]*\d")


def read_table(path: Path) -> FeatureCollection:
    """A ring for each block of points; blank lines part blocks, and lines of words before a block are its header.

    FileError, CaseError or GeometryError with the line.
    """
    features: list[Feature] = []
    notes: dict[str, None] = {}
    for first, points in _blocks(path, notes):
        name = f"ring {len(features)} (line {first})"
        features.append(Feature(name, rings=(polygon_ring(finite_points(points, name), name),)))
    if not features:
        raise CaseError("there are no points in it: give two numbers in a line")
    return FeatureCollection(tuple(features), tuple(notes))


def read_columns(path: Path, names: Sequence[str]) -> Floats:
    """The numbers (n, k) of a table with one column for each of the ``names``; lines of words before are its header.

    FileError or CaseError with the line.
    """
    rows: list[list[float]] = []
    for number, text, values in _lines(path):
        if values is None and not rows:
            continue
        if values is None or len(values) not in (0, len(names)):
            found = repr(shown(text, 40))
            raise CaseError(f"line {number}: must have {len(names)} numbers, {', '.join(names)} (found {found})")
        if values:
            rows.append(values)
    if not rows:
        raise CaseError(f"there are no numbers in it: give {', '.join(names)} in each line")
    return np.array(rows)


def _lines(path: Path) -> Iterator[tuple[int, str, list[float] | None]]:
    """Number, text and values of each line; None for a line of words.

    CaseError if a line starts as numbers do, but is none, or a column is empty.
    """
    for number, text in enumerate([*read_text(path).splitlines(), ""], start=1):
        plain = COMMENT.sub("", text).replace('"', "").strip()
        words = SEPARATOR.split(plain.replace(",", ".") if ";" in plain else plain)
        if len(words) > 1 and words[-1] == "":  # a separator at the end of the line
            words.pop()
        if len(words) > 1 and "" in words:
            raise CaseError(f"line {number}: an empty column: {shown(text, 40)!r}: give a number in each")
        words = [word for word in words if word]
        values = _numbers(words)
        if values is None and STARTS_AS_NUMBER.match(words[0]):
            raise CaseError(f"line {number}: no numbers: {shown(text, 40)!r}: correct it, or mark it as a comment by #")
        yield number, text, values


def _blocks(path: Path, notes: dict[str, None]) -> Iterator[tuple[int, list[Point]]]:
    """First line and points of each block; what is left out is added to the notes."""
    points: list[Point] = []
    first = 0
    for number, text, values in _lines(path):
        if not values:
            if points and values is None:
                raise CaseError(f"line {number}: not a point: {shown(text, 40)!r}: give two numbers in a line")
            if values is None and _is_slip(text):
                notes[f"line {number} is taken as a header: {shown(text, 40)!r}"] = None
            if points:
                yield first, points
            points = []
            continue
        if len(values) < 2:
            raise CaseError(f"line {number}: one number alone: a point has two")
        if len(values) > 2:
            notes["columns after the second are not used"] = None
        first = number if not points else first
        points.append((values[0], values[1]))


def _is_slip(text: str) -> bool:
    """Whether a line of words may be a mistyped point such as ``O 0``, rather than a header such as ``NACA 0012``."""
    words = [word for word in SEPARATOR.split(text.strip()) if word]
    others = [word for word in words if _numbers([word]) is None]
    return len(others) < len(words) and any(len(word) == 1 or any(c.isdigit() for c in word) for word in others)


def _numbers(words: list[str]) -> list[float] | None:
    """The words as numbers; None if one is none."""
    if not all(NUMBER.fullmatch(word) for word in words):
        return None
    return [float(word) for word in words]
