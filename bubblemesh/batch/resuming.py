"""Which cases an earlier batch has done, and which of its rows stay."""

import os
from collections.abc import Iterable, Sequence
from hashlib import file_digest
from pathlib import Path

from bubblemesh.batch.plan import Entry, Settings, job_of
from bubblemesh.batch.rows import Row
from bubblemesh.errors import BubblemeshError, RequirementError
from bubblemesh.meshfiles.history import HISTORY_FILES
from bubblemesh.meshfiles.writing import PAGE_FILE

EXTRAS = (PAGE_FILE, *HISTORY_FILES)  # which the inputs of a mesh do not tell
DONE = (0, RequirementError.exit_code)  # with these, another run would end the same way


def unchanged(entries: Sequence[Entry], rows: Iterable[Row], settings: Settings, root: Path) -> dict[int, Row]:
    """The rows, by the numbers of their entries, whose inputs are the same now and whose files are all as written."""
    known = {key_of(entry, root): entry for entry in entries if entry.place is not None}
    digests: dict[int, str | None] = {}
    found: dict[int, Row] = {}
    for row in rows:
        entry = known.get(row.key)
        if entry is None or entry.number in found or row.exit_code not in DONE or not _has_extras(row, entry):
            continue
        if entry.number not in digests:
            digests[entry.number] = _digest(entry, settings)
        if row.inputs is not None and row.inputs == digests[entry.number] and _intact(row, root):
            found[entry.number] = row
    return found


def _has_extras(row: Row, entry: Entry) -> bool:
    """Whether the row has a mesh, and the page and the tables that are wanted beside it."""
    wanted = {path.name for path in entry.place.files if path.name.endswith(EXTRAS)} if entry.place else set()
    return bool(row.files) and wanted <= row.files.keys()


def of_others(entries: Sequence[Entry], rows: Iterable[Row], root: Path) -> list[Row]:
    """The rows of cases outside the batch."""
    keys = {key_of(entry, root) for entry in entries}
    sources = {entry.source for entry in entries}
    unreadable = {entry.source for entry in entries if entry.place is None}

    def is_of_others(row: Row) -> bool:
        if row.folder is None:  # its file could not be read: nobody knows which cases it stands for
            return row.source not in sources
        return row.key not in keys and row.source not in unreadable

    return [row for row in rows if is_of_others(row)]


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
    except (OSError, ValueError):  # no name of a file
        return False
    return True
