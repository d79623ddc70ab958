"""The picture of a batch with histories: how each of its meshes became good."""

import csv
from collections.abc import Callable, Sequence
from io import StringIO
from pathlib import Path

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.batch.row import Row
from bubblemesh.errors import BubblemeshError
from bubblemesh.files import read_bytes
from bubblemesh.meshfiles.text import HISTORY_FILES

STEM, ENDING = "convergence", ".svg"


def write_convergence(rows: Sequence[Row], folder: Path, path: Path, warn: Callable[[str], None]) -> None:
    """Draw the histories beside the meshes of rows; without histories, no picture is written.

    Parameters
    ----------
    rows
        Rows of a summary.
    folder
        Folder to which the folders in the rows are relative.
    path
        File of the picture.
    warn
        Called with a warning on each history that is damaged or missing, and left out.

    Raises
    ------
    FileError
        If the picture cannot be written.
    """
    from bubblemesh.pictures.convergence import Course, draw_convergence

    courses = list[Course]()
    for row in rows:
        for name in (name for name in row.files if name.endswith(HISTORY_FILES[0])):
            file = folder / (row.folder or ".") / name
            try:
                iterations, quality = _columns(read_bytes(file), "iterations", "quality_mean")
            except (BubblemeshError, ValueError, KeyError, TypeError):
                warn(f"{file}: the table is damaged or gone: {row.case} is not in {path.name}")
            else:
                courses.append(Course(row.case, np.cumsum(iterations), quality))
    if courses:
        draw_convergence(courses, path)


def _columns(content: bytes, *names: str) -> Floats:
    """Columns (k, n) of a table by their names; ValueError, KeyError or TypeError if it is not such a table."""
    lines = list(csv.DictReader(StringIO(content.decode())))
    if not lines:
        raise ValueError("no rows")
    return np.array([[float(line[name]) for line in lines] for name in names])
