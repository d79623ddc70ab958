"""Lists of points and tables as text: numbers in a line, separated by commas, semicolons or blanks.

In a line with semicolons a comma is a decimal point.
"""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import CaseError, GeometryError
from bubblemesh.geometry import rings
from bubblemesh.readers.features import Content, Feature, Point, checked
from bubblemesh.readers.text import read_text

__all__ = ["read_columns", "read_table"]

SEPARATOR = re.compile(r"\s*[,;]\s*|\s+")
COMMENT = re.compile(r"[#%!].*")


def read_table(path: Path) -> Content:
    """A ring for each block of points; blank lines part blocks, and lines of words before a block are its header.

    Raises
    ------
    FileError, CaseError, GeometryError
        With the line.
    """
    features: list[Feature] = []
    more = False
    for first, points, columns in _blocks(path):
        name = f"ring {len(features)} (line {first})"
        more = more or columns > 2
        try:
            ring = rings.polygon(checked(points, name))
        except GeometryError as error:
            raise GeometryError(f"{name}: {error}") from None
        features.append(Feature(name, rings=(ring,)))
    if not features:
        raise CaseError("there are no points in it: give two numbers in a line")
    return Content(tuple(features), ("columns after the second are not used",) if more else ())


def read_columns(path: Path, names: Sequence[str]) -> Floats:
    """The numbers (n, k) of a table with one column for each of the ``names``; lines of words before are its header.

    Raises
    ------
    FileError, CaseError
        With the line.
    """
    rows: list[list[float]] = []
    for number, text, values in _lines(path):
        if values is None and not rows:
            continue
        if values is None or len(values) not in (0, len(names)):
            found = repr(text.strip()[:40])
            raise CaseError(f"line {number}: must have {len(names)} numbers, {', '.join(names)} (found {found})")
        if values:
            rows.append(values)
    if not rows:
        raise CaseError(f"there are no numbers in it: give {', '.join(names)} in each line")
    return np.array(rows)


def _lines(path: Path) -> Iterator[tuple[int, str, list[float] | None]]:
    """Number, text and values of each line; None for a line of words."""
    for number, text in enumerate([*read_text(path).splitlines(), ""], start=1):
        plain = COMMENT.sub("", text).strip()
        words = [word for word in SEPARATOR.split(plain.replace(",", ".") if ";" in plain else plain) if word]
        yield number, text, _numbers(words)


def _blocks(path: Path) -> Iterator[tuple[int, list[Point], int]]:
    """First line, points and number of columns of each block."""
    points: list[Point] = []
    first = columns = 0
    for number, text, values in _lines(path):
        if not values:
            if points and values is None:
                raise CaseError(f"line {number}: not a point: {text.strip()[:40]!r}: give two numbers in a line")
            if points:
                yield first, points, columns
            points, columns = [], 0
            continue
        if len(values) < 2:
            raise CaseError(f"line {number}: one number alone: a point has two")
        first = number if not points else first
        points.append((values[0], values[1]))
        columns = max(columns, len(values))


def _numbers(words: list[str]) -> list[float] | None:
    """The words as numbers; None if they are words."""
    try:
        return [float(word) for word in words]
    except ValueError:
        return None
