"""The summary of a batch on the disk: summary.jsonl and summary.csv, which grow by a row for each case."""

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from bubblemesh.batch.rows import HEAD, Row
from bubblemesh.errors import FileError
from bubblemesh.output.atomic import reason, transaction

__all__ = ["Summary", "recorded", "summary"]

STEM = "summary"


class Summary:
    """Two files with the same rows."""

    def __init__(self, lines: "Lines", table: "Lines") -> None:
        self.lines = lines
        self.table = table
        self._last: tuple[int, Row] | None = None

    @property
    def path(self) -> Path:
        """The file that has all of each row."""
        return self.lines.path

    def append(self, row: Row) -> None:
        """Add a row to both files.

        Raises
        ------
        FileError
            If that cannot be done; the files are whole nevertheless.
        """
        self._last = self.lines.size, row
        self.lines.append(row.line())
        self.table.append(row.cells())
        self._last = None

    def close(self) -> None:
        """Give the table the row that it lacks after an interrupt, and close both."""
        try:
            if self._last is not None and self.lines.size > self._last[0]:
                self.table.append(self._last[1].cells())
        finally:
            self.lines.close()
            self.table.close()


class Lines:
    """A file that grows by whole lines."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._file = os.open(path, os.O_WRONLY | os.O_APPEND | getattr(os, "O_BINARY", 0))

    @property
    def size(self) -> int:
        """Its size in bytes."""
        return os.fstat(self._file).st_size

    def append(self, text: str) -> None:
        """Add text at the end, all of it or nothing; a FileError if that fails."""
        before, content = self.size, text.encode()
        try:
            written = os.write(self._file, content)  # one call, which no signal of ours cuts in two
            if written < len(content):
                os.ftruncate(self._file, before)
                raise FileError(f"cannot write {self.path}: only a part of a row fits: is the disk full?")
        except OSError as error:
            raise FileError(f"cannot write {self.path}: {reason(error)}") from error

    def close(self) -> None:
        """Close the file."""
        os.close(self._file)


@contextmanager
def summary(folder: Path, suffix: str, rows: Iterable[Row]) -> Iterator[Summary]:
    """A summary that begins with these rows, in place of an old one.

    Raises
    ------
    FileError
        If it cannot be written; then an old one is as it was.
    """
    kept = list(rows)
    names = [f"{STEM}{suffix}.jsonl", f"{STEM}{suffix}.csv"]
    texts = ["".join(row.line() for row in kept), HEAD + "".join(row.cells() for row in kept)]
    with transaction(folder) as staging:
        for name, text in zip(names, texts, strict=True):
            with (staging / name).open("w", encoding="utf-8", newline="") as file:
                file.write(text)
                file.flush()
                os.fsync(file.fileno())  # a power cut must not take the rows of hours
    opened: list[Lines] = []
    try:
        opened += [Lines(folder / name) for name in names]
    except OSError as error:
        raise FileError(f"cannot write {folder / names[0]}: {reason(error)}") from error
    growing = Summary(*opened)
    try:
        yield growing
    finally:
        growing.close()


def recorded(folder: Path, suffix: str | None = None) -> list[Row]:
    """Rows of the folder's summary with this suffix, or of all summaries there; what is not whole is left out.

    Raises
    ------
    FileError
        If one cannot be read.
    """
    names = [f"{STEM}.jsonl", f"{STEM}-*-of-*.jsonl"] if suffix is None else [f"{STEM}{suffix}.jsonl"]
    paths = [path for name in names for path in sorted(folder.glob(name))]
    try:
        lines = [line for path in paths for line in path.read_bytes().split(b"\n")]
    except OSError as error:
        raise FileError(f"cannot read the summary {error.filename}: {reason(error)}") from error
    return [row for row in map(Row.parsed, lines) if row is not None]
