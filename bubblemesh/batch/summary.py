"""The summary of a batch on the disk: summary.jsonl and summary.csv, which grow by a row for each case."""

import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from bubblemesh.batch.row import COLUMNS, Row, csv_line
from bubblemesh.errors import DONE, FileError
from bubblemesh.files import reason, unwritten
from bubblemesh.meshfiles.transaction import transaction

STEM = "summary"


class Summary:
    """Two files that begin with these rows, in place of old ones, and grow; a FileError if they cannot be written.

    Attributes
    ----------
    rows : list of Row
        All that the files hold.
    path : Path
        The file that has all of each row.
    """

    def __init__(self, folder: Path, suffix: str, rows: Iterable[Row]) -> None:
        self.rows = list(rows)
        self.path = folder / f"{STEM}{suffix}.jsonl"
        self._last: tuple[int, Row] | None = None  # size of the lines, and the row that they are about to get
        self._lines, self._table = self._written()

    def append(self, row: Row) -> None:
        """Add a row to both files.

        Raises
        ------
        FileError
            If that cannot be done; the files are whole nevertheless.
        """
        self.keep()
        self._last = self._lines.size, row
        self._lines.append(row.line())
        self.rows.append(row)
        self._table.append(row.cells())
        self._last = None

    def keep(self) -> None:
        """Write both files anew if one has been removed.

        Raises
        ------
        FileError
            If that cannot be done, or another summary has taken the place of this one.
        """
        if self._lines.in_place and self._table.in_place:
            return
        if os.path.lexists(self.path) and not self._lines.in_place:
            raise FileError(f"{self.path}: another file has taken its place: run the batch again with --resume")
        old = self._lines, self._table
        self._lines, self._table = self._written()
        for lines in old:
            lines.close()

    def close(self) -> None:
        """Give the table the row that it lacks after an interrupt, and close both."""
        try:
            if self._last is not None and self._lines.size > self._last[0]:
                self._table.append(self._last[1].cells())
        finally:
            self._lines.close()
            self._table.close()

    def _written(self) -> "tuple[Lines, Lines]":
        """Lines and table, written anew."""
        table = self.path.with_suffix(".csv")
        texts = {
            self.path: "".join(row.line() for row in self.rows),
            table: csv_line(COLUMNS) + "".join(row.cells() for row in self.rows),
        }
        with transaction(self.path.parent) as staging:
            for path, text in texts.items():
                with (staging / path.name).open("w", encoding="utf-8", newline="") as file:
                    file.write(text)
                    file.flush()
                    os.fsync(file.fileno())  # a power cut must not take the rows of hours
        return Lines(self.path), Lines(table)


class Lines:
    """A file that grows by whole lines; a FileError if it cannot be opened."""

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            self._file = os.open(path, os.O_WRONLY | os.O_APPEND | getattr(os, "O_BINARY", 0))
        except OSError as error:
            raise unwritten(path, error) from error

    @property
    def size(self) -> int:
        """Size in bytes."""
        return os.fstat(self._file).st_size

    @property
    def in_place(self) -> bool:
        """Whether its name is still that of the file which has been opened."""
        try:
            return os.path.samestat(self.path.stat(), os.fstat(self._file))
        except OSError:
            return False

    def append(self, text: str) -> None:
        """Add text at the end, all of it or nothing; a FileError if that fails."""
        before, content = self.size, text.encode()
        try:
            written = os.write(self._file, content)  # one call, which no signal of ours cuts in two
            if written < len(content):
                os.ftruncate(self._file, before)
                raise FileError(f"cannot write {self.path}: only a part of a row fits: is the disk full?")
        except OSError as error:
            raise unwritten(self.path, error) from error

    def close(self) -> None:
        """Close the file."""
        os.close(self._file)


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
    return [row for row in map(Row.parse, lines) if row is not None]


def totals(rows: Sequence[Row], unchanged: int) -> dict[str, Any]:
    """Counts and rows of a batch, as ``--json`` prints them; the exit code is the largest of the rows, or 0."""
    codes = [row.exit_code for row in rows]
    counts = {"cases": len(rows), "failed": sum(code != DONE for code in codes), "unchanged": unchanged}
    return counts | {"exit_code": max(codes, default=DONE), "rows": [row.data() for row in rows]}
