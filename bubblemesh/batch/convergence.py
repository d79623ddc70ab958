"""The picture of a batch with histories: how each of its meshes became good."""

import csv
from collections.abc import Iterator, Sequence
from io import StringIO
from pathlib import Path

import numpy as np

from bubblemesh.batch.row import Row
from bubblemesh.errors import FileError
from bubblemesh.files import read_bytes
from bubblemesh.meshfiles.text import HISTORY_FILES

STEM, ENDING = "convergence", ".svg"


def write_convergence(rows: Sequence[Row], folder: Path, path: Path) -> None:
    """Draw the histories beside the meshes of rows, whose folders are seen from ``folder``; none where there are none.

    FileError if the picture cannot be written.
    """
    from bubblemesh.pictures.convergence import Course, draw_convergence

    courses = [
        Course(row.case, np.cumsum(table["iterations"]), np.asarray(table["quality_mean"]))
        for row in rows
        for table in _tables(row, folder)
    ]
    if courses:
        draw_convergence(courses, path)


def _tables(row: Row, folder: Path) -> Iterator[dict[str, list[float]]]:
    """Columns of the table of rounds of a row, unless it is gone or is none."""
    for name in (name for name in row.files if name.endswith(HISTORY_FILES[0])):
        try:
            text = read_bytes(folder / (row.folder or ".") / name).decode()
            lines = list(csv.DictReader(StringIO(text)))
            if not lines:
                raise ValueError("no rows")
            yield {key: [float(line[key]) for line in lines] for key in ("iterations", "quality_mean")}
        except (FileError, ValueError, KeyError, TypeError):
            continue
