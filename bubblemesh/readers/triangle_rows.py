"""Rows of numbers in files of the Triangle program, which are sections with a count of their rows in front."""

from collections.abc import Iterator
from pathlib import Path

from bubblemesh.errors import CaseError
from bubblemesh.files import read_text
from bubblemesh.messages import shown
from bubblemesh.readers.features import text_of_number

NumberedRow = tuple[int, list[float]]  # line and numbers


def numbered_rows(path: Path) -> Iterator[NumberedRow]:
    """The lines of a file that hold numbers, one after the other; CaseError for one with words."""
    for number, line in enumerate(read_text(path).splitlines(), start=1):
        words = line.partition("#")[0].split()
        if words:
            try:
                yield number, [float(word) for word in words]
            except ValueError:
                raise CaseError(f"line {number}: not a row of numbers: {shown(line, 40)!r}") from None


def next_row(rows: Iterator[NumberedRow], columns: int, what: str) -> NumberedRow:
    """The next row; CaseError if there is none, or if it does not have so many columns."""
    number, row = next(rows, (0, []))
    if len(row) < columns:
        raise CaseError(f"{f'line {number}' if row else 'the end of the file'}: expected {what}")
    return number, row


def section_head(rows: Iterator[NumberedRow], what: str) -> tuple[int, list[int]]:
    """Number of rows in a section, and the further numbers in its first line; CaseError if one is no count."""
    line, numbers = next_row(rows, 1, what)
    for number in numbers:
        if not (number >= 0 and number.is_integer()):
            raise CaseError(f"line {line}: {text_of_number(number)} is no count: expected {what}")
    count, *more = map(int, numbers)
    return count, more


def section_rows(rows: Iterator[NumberedRow], count: int, what: str, columns: int = 3) -> Iterator[NumberedRow]:
    """Rows of a section, each with so many columns or more; the same errors as `next_row`."""
    return (next_row(rows, columns, what) for _ in range(count))
