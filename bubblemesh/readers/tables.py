"""Tables as text: numbers in a line, separated by commas, semicolons or blanks, or columns with names.

In a line with semicolons, and within quotes, a comma is a decimal point. A text in quotes is one cell.
"""

import csv
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import CaseError
from bubblemesh.files import read_text
from bubblemesh.messages import listed, shown

SEPARATOR = re.compile(r"\s*[,;]\s*|\s+")
COMMENT = re.compile(r"[#%!].*")
QUOTED_OR_COMMENT = re.compile(r'"([^"]*)"|[#%!].*')
# No text can be matched in two ways: else a line of a thousand digits would be tried in a million ways.
NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eEdD][-+]?\d+)?|[-+]?(nan|inf|infinity)", re.IGNORECASE)
STARTS_AS_NUMBER = re.compile(r"[-+.]*\d")
LETTER = re.compile(r"[^\W\d_]")
PER_CENT = re.compile(rf"\s*[\d.]+\s*%.*{LETTER.pattern}")  # as 12% JOUKOWSKI, where % begins no comment
DECIMAL_COMMA = re.compile(r"[-+]?\d+(,\d+)?([eE][-+]?\d+)?")
WITH_COMMA = re.compile(r"[-+]?\d[\d.]*,[\d.,]*([eE][-+]?\d+)?")
THOUSANDS = re.compile(r"[-+]?[1-9]\d{0,2},\d{3}")  # may also be a number with three decimals
DELIMITERS = ";\t,"  # the first one found in a header is used
# The last names are those of German surveyors.
X = (
    *("x", "lon", "long", "lng", "longitude", "easting", "east", "xcoord", "xcoordinate", "pointx", "coordx"),
    *("rechtswert", "rechts", "ostwert", "ost"),
)
Y = (
    *("y", "lat", "latitude", "northing", "north", "ycoord", "ycoordinate", "pointy", "coordy"),
    *("hochwert", "hoch", "nordwert", "nord"),
)
UNIT = re.compile(r"[\s_.-]+(mm|cm|m|km|ft|deg|degrees?|dd|utm)$")  # at the end of a name, as in x_m


class TableLine(NamedTuple):
    """A line of a table; ``values`` is None for words, and empty for a blank line or a comment."""

    number: int
    text: str
    values: list[float] | None


class Named(NamedTuple):
    """Row of a table whose columns have names: its place, if there is one, and all cells by the names."""

    number: int
    place: tuple[float, float] | None
    cells: dict[str, str]


def read_columns(path: Path, names: Sequence[str]) -> Floats:
    """The numbers (n, k) of a table with one column for each of the ``names``; lines of words before it are a header.

    FileError or CaseError with the line.
    """
    rows: list[list[float]] = []
    for number, text, values in table_lines(read_text(path)):
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


def table_lines(content: str, title: int = 0) -> Iterator[TableLine]:
    """The lines of a text, and an empty one at its end; that with the number ``title`` is words, whatever is in it.

    CaseError if a line begins like a number but is not one, or if a column is empty; the same errors as `plain_line`.
    """
    for number, text in enumerate([*content.splitlines(), ""], start=1):
        if number == title:
            yield TableLine(number, text, None)
            continue
        words = SEPARATOR.split(plain_line(text, number))
        if len(words) > 1 and words[-1] == "":  # a separator at the end of the line
            words.pop()
        if len(words) > 1 and "" in words:
            raise CaseError(f"line {number}: an empty column: {shown(text, 40)!r}: give a number in each")
        words = [word for word in words if word]
        values = numbers_in(words)
        if values is None and STARTS_AS_NUMBER.match(words[0]):
            raise CaseError(f"line {number}: no numbers: {shown(text, 40)!r}: correct it, or mark it as a comment by #")
        yield TableLine(number, text, values)


def title_line(content: str) -> int:
    """Number of the first line that is not blank or a comment, if it has letters and is no row of numbers; else 0.

    The same CaseError as `plain_line`.
    """
    for number, text in enumerate(content.splitlines(), start=1):
        plain = plain_line(text, number)
        words = [word for word in SEPARATOR.split(plain) if word]
        if not words:
            continue
        if numbers_in(words) is None:
            return number if LETTER.search(plain) else 0
        return number if len(words) == 1 and PER_CENT.match(text) else 0
    return 0


def plain_line(text: str, number: int) -> str:
    """A line without its comment and its quotes: a text in quotes is one word, numbers have decimal points.

    The same CaseError as `_with_point`.
    """
    if '"' in text:
        semicolons = ";" in QUOTED_OR_COMMENT.sub("", text)

        def word(found: re.Match[str]) -> str:
            content = (found[1] or "").strip()
            plain = content.replace(",", ".") if semicolons else _with_point(content, number)
            return plain if NUMBER.fullmatch(plain) else re.sub(r"\W", "_", content)

        plain = QUOTED_OR_COMMENT.sub(word, text).replace('"', "").strip()
    else:
        plain = COMMENT.sub("", text).strip()
    return plain.replace(",", ".") if ";" in plain else plain


def _with_point(cell: str, number: int) -> str:
    """A cell with a point in place of its decimal comma; CaseError if the comma may also separate thousands."""
    if not WITH_COMMA.fullmatch(cell):
        return cell
    if THOUSANDS.fullmatch(cell) or not DECIMAL_COMMA.fullmatch(cell):
        raise CaseError(
            f"line {number}: the comma in {shown(cell, 40)!r} may be a decimal point or part thousands: write numbers "
            "without commas"
        )
    return cell.replace(",", ".")


def numbers_in(words: list[str]) -> list[float] | None:
    """The words as numbers; None if one is not a number."""
    if not all(NUMBER.fullmatch(word) for word in words):
        return None
    return list(map(number_of, words))


def number_of(word: str) -> float:
    """The value of a number, whose exponent may be written as in Fortran, 1.5D-03."""
    try:
        return float(word)
    except ValueError:
        return float(word.upper().replace("D", "E"))


def has_decimal_commas(content: str, title: int = 0) -> bool:
    """Whether the commas of a table are decimal points, since numbers are separated by blanks in each line.

    The line with the number ``title`` does not count. The same CaseError as `plain_line`.
    """
    found = False
    for number, text in enumerate(content.splitlines(), start=1):
        plain = plain_line(text, number)
        words = plain.split()
        if ";" in plain:
            return False
        if number == title or not words or not STARTS_AS_NUMBER.match(words[0]):
            continue
        if len(words) < 2 or not all(DECIMAL_COMMA.fullmatch(word) for word in words):
            return False
        found = found or "," in plain
    return found


def named_rows(content: str, fewest: int = 2) -> tuple[list[Named], str] | None:
    """Rows of a table whose first line names columns for x and y, and a text with these names; None for other tables.

    Tables with fewer than ``fewest`` names are other tables. A row has no place if it is blank or its x and y are nan.

    Raises
    ------
    CaseError
        With the line, if a row is invalid, or if there are three names or more of which none is known as x or y, in a
        table with as many cells in a row, two of them numbers: the first may be the number of the row.
    """
    lines = content.splitlines()
    first = next((k for k, text in enumerate(lines) if COMMENT.sub("", text).strip()), 0)
    header = lines[first] if lines else ""
    delimiter = next((letter for letter in DELIMITERS if letter in header), None)
    names = _cells(header, delimiter)
    plain = [_plain_name(name) for name in names]
    columns = [next((plain.index(name) for name in known if name in plain), None) for known in (X, Y)]
    if columns[0] is None or columns[1] is None:
        if delimiter is not None and len(names) > 2 and _are_columns(names, lines[first + 1 :], delimiter):
            found = listed([repr(shown(name, 20)) for name in names])
            raise CaseError(
                f"line {first + 1}: of the columns {found} none are known as x and y: call two of them x and y"
            )
        return None
    if len(names) < fewest:
        return None
    rows = []
    for number, text in enumerate(lines[first + 1 :], start=first + 2):
        cells = _cells(text, delimiter) if COMMENT.sub("", text).strip() else []
        here = [cells[column] if column < len(cells) else "" for column in columns if column is not None]
        rows.append(Named(number, _place(here, number, text, delimiter), dict(zip(names, cells, strict=False))))
    return rows, f"{names[columns[0]]!r} and {names[columns[1]]!r}"


def _plain_name(name: str) -> str:
    """The name of a column without a unit, signs and blanks, in small letters."""
    return re.sub(r"[\W_]", "", UNIT.sub("", name.partition("(")[0].partition("[")[0].strip().lower()))


def _are_columns(names: Sequence[str], lines: Sequence[str], delimiter: str) -> bool:
    """Whether the names are no numbers, and the first line that is not blank has as many cells, two of them numbers."""
    row = next((text for text in lines if COMMENT.sub("", text).strip()), "")
    cells = [cell.replace(",", ".") for cell in _cells(row, delimiter)]
    numbers = sum(NUMBER.fullmatch(cell) is not None for cell in cells)
    return len(cells) == len(names) and numbers >= 2 and not any(NUMBER.fullmatch(name) for name in names)


def _cells(text: str, delimiter: str | None) -> list[str]:
    if delimiter is None:
        return [word.strip('"') for word in text.split()]
    try:
        return [cell.strip() for cell in next(csv.reader([text], delimiter=delimiter, skipinitialspace=True), [])]
    except csv.Error:
        return [cell.strip() for cell in text.split(delimiter)]


def _place(cells: list[str], number: int, text: str, delimiter: str | None) -> tuple[float, float] | None:
    """Place of the cells for x and y; None where both are empty or nan."""
    words = [_with_point(cell, number) if delimiter == "," else cell.replace(",", ".") for cell in cells]
    if all(word.lower() in ("", "nan") for word in words):
        return None
    values = numbers_in(words)
    if values is None:
        raise CaseError(f"line {number}: x and y are no numbers: {shown(text, 40)!r}: correct it, or remove the line")
    return values[0], values[1]
