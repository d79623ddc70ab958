"""Which cases an earlier batch has done, and what it left behind."""

import os
import shutil
from collections.abc import Iterable, Sequence
from hashlib import file_digest
from pathlib import Path

from bubblemesh.batch.plan import Entry, Settings, job_of
from bubblemesh.batch.rows import Row
from bubblemesh.errors import BubblemeshError, RequirementError

__all__ = ["key_of", "place_in", "unchanged", "without_leftovers"]

DONE = (0, RequirementError.exit_code)  # with these, another run would end the same way


def unchanged(entries: Sequence[Entry], rows: Iterable[Row], settings: Settings, root: Path) -> dict[int, Row]:
    """The rows, by the numbers of their entries, whose inputs are the same now and whose files are all as written."""
    known = {key_of(entry, root): entry for entry in entries if entry.place is not None}
    digests: dict[int, str | None] = {}
    found: dict[int, Row] = {}
    for row in rows:
        entry = known.get(row.key)
        if entry is None or entry.number in found or row.exit_code not in DONE or not row.files:
            continue
        if entry.number not in digests:
            digests[entry.number] = _digest(entry, settings)
        if row.inputs is not None and row.inputs == digests[entry.number] and _intact(row, root):
            found[entry.number] = row
    return found


def key_of(entry: Entry, root: Path) -> tuple[str | None, str]:
    """The key of the entry's row."""
    return place_in(root, entry), entry.name


def place_in(root: Path, entry: Entry) -> str | None:
    """The folder of the entry's results, seen from the summary's."""
    if entry.place is None or entry.place.folder is None:
        return None
    try:
        return Path(os.path.relpath(entry.place.folder, root)).as_posix()
    except ValueError:  # another drive of Windows
        return str(entry.place.folder.absolute())


def _digest(entry: Entry, settings: Settings) -> str | None:
    try:
        return job_of(entry, settings).digest()
    except BubblemeshError:
        return None


def _intact(row: Row, root: Path) -> bool:
    folder = root / str(row.folder)
    try:
        for name, digest in row.files.items():
            with (folder / name).open("rb") as file:
                if file_digest(file, "sha256").hexdigest() != digest:
                    return False
    except OSError:
        return False
    return True


def without_leftovers(entries: Iterable[Entry], prefix: str) -> None:
    """Remove staging folders that a batch had no time to remove."""
    folders = {entry.place.folder for entry in entries if entry.place is not None and entry.place.folder is not None}
    for folder in folders:
        for leftover in folder.glob(f"{prefix}*"):
            shutil.rmtree(leftover, ignore_errors=True)
