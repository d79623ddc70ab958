"""The page that compares the cases of a batch and links to theirs."""

import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from bubblemesh.batch.plan import Entry
from bubblemesh.batch.rows import Row
from bubblemesh.errors import CaseError
from bubblemesh.output.atomic import transaction

__all__ = ["require_no_index", "write_index"]

STEM = "index"
ENDING = ".html"


def require_no_index(entries: Iterable[Entry], folder: Path) -> None:
    """Check that no case's own page would be where the page of the batch goes.

    Raises
    ------
    CaseError
    """
    place = os.path.realpath(folder / f"{STEM}{ENDING}")
    for entry in entries:
        if entry.place is not None and place in map(os.path.realpath, entry.place.files):
            raise CaseError(f"{entry.source}: its page would be that of the batch: give the case another name")


def write_index(rows: Sequence[Row], folder: Path, suffix: str) -> Path:
    """Write the page of these rows, in place of an old one.

    Raises
    ------
    FileError
    """
    from bubblemesh.output.html.index import index_page

    name = f"{STEM}{suffix}{ENDING}"
    with transaction(folder) as staging:
        (staging / name).write_text(index_page([_shown(row) for row in rows]), encoding="utf-8")
    return folder / name


def _shown(row: Row) -> dict[str, Any]:
    """A row with its page, seen from the folder of the summary."""
    page = next((name for name in row.files if name.endswith(ENDING)), None)
    return row.data() | {"report": None if page is None else (Path(row.folder or ".") / page).as_posix()}
