"""Text of files: many lines of numbers, fast and in full precision; reports as JSON; the history of a run as CSV."""

import csv
import dataclasses
import io
import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path, PurePath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bubblemesh.arrays import Floats
from bubblemesh.messages import printable

LINES_AT_ONCE = 50_000  # lines formatted at once
LONGEST_LINE, INDENT = 96, 2  # characters of readable JSON
FORMULA = re.compile(r"[=@+-](?!(?<=[+-])[0-9.]+([eE][+-]?[0-9]+)?$)")  # beginning of a formula, not of a number
HISTORY_FILES = (".rounds.csv", ".history.csv")


def write_text(path: Path, parts: Iterable[str]) -> None:
    """Write the parts one after the other, as UTF-8 with the same line ends on every system."""
    with path.open("w", encoding="utf-8", newline="\n") as file:
        file.writelines(parts)


def lines(form: str, *columns: NDArray[Any]) -> Iterator[str]:
    """Lines of text, many in each string, filled by columns (n,) or (n, k).

    The form is one line for ``%``, without its end; ``%r`` makes the shortest text that reads back as the same number.
    """
    for start in range(0, len(columns[0]), LINES_AT_ONCE):
        chunks = (column[start : start + LINES_AT_ONCE] for column in columns)
        parts = [part for chunk in chunks for part in ([chunk] if chunk.ndim == 1 else chunk.T)]
        rows, width = len(parts[0]), len(parts)
        flat = [None] * (rows * width)
        for k, part in enumerate(parts):
            flat[k::width] = part.tolist()
        yield (form + "\n") * rows % tuple(flat)


def numbered(count: int) -> NDArray[np.int64]:
    """Numbers (count,) from 1."""
    return np.arange(1, count + 1, dtype=np.int64)


def number_lines(numbers: NDArray[Any], width: int) -> str:
    """Numbers (n,) separated by commas, ``width`` of them in a line."""
    values = [str(number) for number in numbers.tolist()]
    return "".join(", ".join(values[k : k + width]) + "\n" for k in range(0, len(values), width))


def json_text(report: Mapping[str, Any]) -> str:
    """The report as JSON text, with keys in their order and numbers in full precision."""
    return dumped(json_ready(report), indent=2) + "\n"


def dumped(data: Any, **options: Any) -> str:
    """JSON text of plain data; letters stay as they are, control characters and invalid ones become escapes."""
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, **options)
    if text.replace("\n", "").isprintable():
        return text
    # Characters that are not printable, apart from line breaks, are within strings, where an escape means the same.
    return "".join(letter if letter.isprintable() or letter == "\n" else json.dumps(letter)[1:-1] for letter in text)


def readable_json(data: Any, most_lines: int) -> tuple[str, int]:
    """JSON text in at most ``most_lines`` lines of readable length, and the number of lines left out."""
    lines = _json_text(json_ready(data), 0).split("\n")
    return "\n".join(lines[:most_lines]), max(len(lines) - most_lines, 0)


def _json_text(value: Any, indent: int) -> str:
    line = dumped(value)
    if len(line) + indent <= LONGEST_LINE or not isinstance(value, dict | list) or not value:
        return line
    inner = indent + INDENT
    if isinstance(value, dict):
        items = [f"{dumped(key)}: {_json_text(item, inner)}" for key, item in value.items()]
    else:
        items = [_json_text(item, inner) for item in value]
    opening, closing = ("{", "}") if isinstance(value, dict) else ("[", "]")
    separator = ",\n" + " " * inner
    return f"{opening}\n{' ' * inner}{separator.join(items)}\n{' ' * indent}{closing}"


def json_ready(value: Any) -> Any:
    """Convert NumPy values, records, paths and tuples to values of JSON; NaN and infinity become None.

    Records and named tuples become mappings by the names of their fields. TypeError for other types.
    """
    if value is None or isinstance(value, (str, int, bool)):
        return value
    if type(value) is dict:  # first, as this is by far the most frequent type
        return {str(key): json_ready(item) for key, item in value.items()}
    if isinstance(value, (np.generic, np.ndarray)):
        # A 0-dimensional array, and a scalar of a subclass of float, become a Python number.
        return json_ready(value.tolist())
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, PurePath):
        return str(value)
    if isinstance(value, Mapping):
        return {str(key): json_ready(item) for key, item in value.items()}
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        return {key: json_ready(item) for key, item in zip(value._fields, value, strict=True)}
    if isinstance(value, (list, tuple)):
        return [json_ready(item) for item in value]
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: json_ready(getattr(value, field.name)) for field in dataclasses.fields(value)}
    raise TypeError(f"a report cannot hold {value!r}")


def history_tables(rounds: Sequence[dict[str, Any]], speeds: Sequence[Floats]) -> dict[str, str]:
    """Tables as CSV of the rounds and of the steps, one row for each, by the ends of their files' names.

    The keys of the rounds' figures become columns; ``speeds`` are the mean speeds of the bubbles after each step, for
    each round.
    """
    moves = ((number, speed) for number, course in enumerate(speeds, start=1) for speed in course.tolist())
    steps = ([step, number, speed] for step, (number, speed) in enumerate(moves, start=1))
    of_rounds = csv_text([rounds[0].keys(), *(row.values() for row in rounds)])
    of_steps = csv_text([["step", "round", "mean_speed"], *steps])
    return dict(zip(HISTORY_FILES, (of_rounds, of_steps), strict=True))


def csv_text(rows: Iterable[Iterable[Any]]) -> str:
    """CSV of rows of cells, without control characters, and without formulas for spreadsheets."""
    text = io.StringIO()
    cells = ([harmless(cell) if isinstance(cell, str) else cell for cell in row] for row in rows)
    csv.writer(text, lineterminator="\n").writerows(cells)
    return text.getvalue()


def harmless(cell: str) -> str:
    """Text of a cell in one line; it begins with an apostrophe if a spreadsheet would read it as a formula."""
    line = printable(cell).replace("\n", "\\n")
    return f"'{line}" if FORMULA.match(line) else line
