"""Resuming an earlier batch: the rows that it has recorded, its finished cases, and the rows that stay."""

from collections.abc import Iterable, Sequence
from hashlib import sha256
from pathlib import Path
from typing import BinaryIO, NamedTuple

from bubblemesh.batch.plan import STEM, Entry
from bubblemesh.batch.row import Row
from bubblemesh.batch.worker import BatchJob
from bubblemesh.errors import DONE, FileError, RequirementError, prefixed
from bubblemesh.files import opened, unreadable
from bubblemesh.meshfiles.text import HISTORY_FILES
from bubblemesh.meshfiles.writing import PAGE_FILE

EXTRAS = (PAGE_FILE, *HISTORY_FILES)  # files that the hash of the inputs does not cover
BLOCK = 1 << 16  # bytes of a file to read at once
FINAL = (DONE, RequirementError.exit_code)  # with these, another run would end the same way


class OldSummary(NamedTuple):
    """What a summary holds: its rows, and the number of lines that are none, as they are damaged or cut off."""

    rows: Sequence[Row] = ()
    damaged: int = 0


def recorded(paths: Iterable[Path]) -> dict[Path, OldSummary]:
    """What summaries hold, by their files, as far as there are any; FileError if one cannot be read."""
    return {path: _parsed(_content(path)) for path in paths if path.exists()}


def summaries_in(folder: Path) -> list[Path]:
    """The files of all summaries of a folder."""
    return [path for name in (f"{STEM}.jsonl", f"{STEM}-*-of-*.jsonl") for path in sorted(folder.glob(name))]


def _parsed(content: bytes) -> OldSummary:
    found = [Row.parse(line) for line in content.split(b"\n") if line.strip()]
    rows = [row for row in found if row is not None]
    return OldSummary(rows, len(found) - len(rows))


def _content(path: Path) -> bytes:
    try:
        with prefixed(path), opened(path, "summary", limited=False) as stream:
            return stream.read()
    except OSError as error:
        raise FileError(f"{path}: {unreadable(error, 'summary')}") from error


def unchanged(entries: Sequence[Entry], rows: Iterable[Row], root: Path) -> dict[int, Row]:
    """Rows whose inputs are still the same and whose files are all as written, by the numbers of their entries."""
    known = {entry.row.key: entry for entry in entries if entry.case is not None}
    digests: dict[int, str | None] = {}
    found: dict[int, Row] = {}
    for row in rows:
        entry = known.get(row.key)
        if entry is None or entry.number in found or row.exit_code not in FINAL or not _has_extras(row, entry):
            continue
        if entry.number not in digests:
            job = entry.job()
            digests[entry.number] = job.row.inputs if isinstance(job, BatchJob) else None
        if row.inputs is not None and row.inputs == digests[entry.number] and _intact(row, root):
            found[entry.number] = row
    return found


def rows_of_others(entries: Sequence[Entry], rows: Iterable[Row]) -> list[Row]:
    """Rows of cases outside the batch."""
    keys = {entry.row.key for entry in entries}
    sources = {entry.row.source for entry in entries}
    unreadable = {entry.row.source for entry in entries if entry.case is None}

    def is_of_others(row: Row) -> bool:
        if row.folder is None:  # its file could not be read, so that its cases are unknown
            return row.source not in sources
        return row.key not in keys and row.source not in unreadable

    return [row for row in rows if is_of_others(row)]


def replaced(earlier: Iterable[Row], staying: Iterable[Row]) -> list[Row]:
    """Rows of an earlier batch whose cases are not among those that stay: this batch replaces them one by one."""
    keys = {row.key for row in staying}
    return [row for row in earlier if row.key not in keys]


def _has_extras(row: Row, entry: Entry) -> bool:
    """Whether the row has a mesh, and beside it the page and the tables that the case asks for."""
    extras = {name for name in entry.names if name.endswith(EXTRAS)}
    return bool(row.files) and extras <= row.files.keys()


def _digest(file: BinaryIO) -> str:
    """SHA-256 hash of a file's content, by small blocks: the standard library's function clears a large buffer."""
    found = sha256()
    while block := file.read(BLOCK):
        found.update(block)
    return found.hexdigest()


def _intact(row: Row, root: Path) -> bool:
    folder = root / str(row.folder)
    try:
        for name, digest in row.files.items():
            with opened(folder / name, limited=False) as file:
                if _digest(file) != digest:
                    return False
    except (OSError, FileError):
        return False
    return True
