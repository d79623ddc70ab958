"""Many lines of numbers as text, fast and at full precision."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

CHUNK = 50_000  # lines formatted at once


def lines(form: str, *columns: NDArray[Any]) -> Iterator[str]:
    """Lines of text, many in each string.

    Parameters
    ----------
    form : str
        One line as for ``%``, without its end; ``%r`` gives the shortest text that reads back as the same number.
    columns : (n,) or (n, k)
        What fills it.
    """
    for start in range(0, len(columns[0]), CHUNK):
        parts = [part for column in columns for part in _single(column[start : start + CHUNK])]
        rows, width = len(parts[0]), len(parts)
        flat = [None] * (rows * width)
        for k, part in enumerate(parts):
            flat[k::width] = part.tolist()
        yield (form + "\n") * rows % tuple(flat)


def _single(column: NDArray[Any]) -> Iterable[NDArray[Any]]:
    return [column] if column.ndim == 1 else column.T


def numbered(count: int) -> NDArray[np.int64]:
    """Numbers (count,) from 1."""
    return np.arange(1, count + 1, dtype=np.int64)


def listed(numbers: NDArray[Any], width: int) -> str:
    """Numbers (n,) separated by commas, so many on a line."""
    values = [str(number) for number in numbers.tolist()]
    return "".join(", ".join(values[k : k + width]) + "\n" for k in range(0, len(values), width))


def write_text(path: Path, parts: Iterable[str]) -> None:
    """Write the parts one after the other as UTF-8, with the same line ends on every system."""
    with path.open("w", encoding="utf-8", newline="\n") as file:
        file.writelines(parts)
