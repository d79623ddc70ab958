"""The summary of a batch on the disk: summary.jsonl and summary.csv, with a row for each case, and index.html."""

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from bubblemesh.batch.convergence import ENDING, STEM, write_convergence
from bubblemesh.batch.plan import BatchOptions, Entry
from bubblemesh.batch.row import COLUMNS, Row
from bubblemesh.errors import DONE, BubblemeshError, CaseError, FileError
from bubblemesh.files import unwritten
from bubblemesh.meshfiles.text import csv_text
from bubblemesh.meshfiles.transaction import transaction
from bubblemesh.meshfiles.writing import PAGE_FILE


class Summary:
    """Two growing files, which replace old ones and begin with the given rows; FileError if they cannot be written.

    Rows of an ``earlier`` batch stay until a case with the same key has a new one, or until this batch is at its end:
    if it is interrupted, the meshes that they tell of are still there.
    """

    def __init__(self, options: BatchOptions, rows: Iterable[Row], earlier: Iterable[Row] = ()) -> None:
        self._rows = list(rows)  # of this batch, and of others that stay
        self._earlier = {row.key: row for row in earlier}
        self._has_superseded = False  # whether the files have rows of earlier batches that are no longer true
        self.path = options.summary  # the file with all values of each row
        self._last: tuple[int, Row] | None = None  # size of the lines before the row that is being added, and that row
        self._lines, self._table = self._written()

    @property
    def rows(self) -> list[Row]:
        """All rows that are true."""
        return [*self._earlier.values(), *self._rows]

    def append(self, row: Row) -> None:
        """Add a row to both files; FileError if that fails, which leaves both without half lines.

        The line of JSON is on the disk then. Lines of the table that a power cut has taken, a resumed batch writes
        anew.
        """
        self.keep()
        self._last = self._lines.size, row
        self._lines.append(row.line())
        self._lines.sync()
        self._take(row)
        self._table.append(row.cells())
        self._last = None

    def _take(self, row: Row) -> None:
        """Count a row among those in the files, in place of an earlier one of its case."""
        if row not in self._rows[-1:]:
            self._rows.append(row)
        self._has_superseded |= self._earlier.pop(row.key, None) is not None

    def end(self) -> None:
        """Drop what is left of earlier batches, as this one is at its end; FileError as for `keep`."""
        self.keep()
        self._has_superseded |= bool(self._earlier)
        self._earlier.clear()

    def keep(self) -> None:
        """Write both files anew if one has been removed; FileError if another summary has taken their place."""
        if self._lines.in_place and self._table.in_place:
            return
        if os.path.lexists(self.path) and not self._lines.in_place:
            raise FileError(f"{self.path}: another file has taken its place: run the batch again with --resume")
        self._rewrite()

    def _rewrite(self) -> None:
        old = self._lines, self._table
        self._lines, self._table = self._written()
        for lines in old:
            lines.close()

    def close(self) -> None:
        """Close both files, with the row that an interrupt has left out of the table, and without replaced ones."""
        try:
            if self._last is not None and self._lines.size > self._last[0]:
                self._take(self._last[1])
                self._table.append(self._last[1].cells())
            if self._has_superseded:
                self._rewrite()
        finally:
            self._lines.close()
            self._table.close()

    def _written(self) -> "tuple[GrowingFile, GrowingFile]":
        """The files with lines of JSON and with the table, written anew."""
        table = self.path.with_suffix(".csv")
        texts = {
            self.path: "".join(row.line() for row in self.rows),
            table: csv_text([COLUMNS]) + "".join(row.cells() for row in self.rows),
        }
        with transaction(self.path.parent) as staging:
            for path, text in texts.items():
                (staging / path.name).write_text(text, encoding="utf-8", newline="\n")
        return GrowingFile(self.path), GrowingFile(table)


class GrowingFile:
    """A file that grows by whole lines; FileError if it cannot be opened."""

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
        """Whether the path still leads to the file that was opened."""
        try:
            return os.path.samestat(self.path.stat(), os.fstat(self._file))
        except OSError:
            return False

    def append(self, text: str) -> None:
        """Add text at the end, all of it or nothing; FileError if that fails."""
        before, content = self.size, text.encode()
        try:
            written = os.write(self._file, content)  # one call, which our signals do not interrupt
            if written < len(content):
                os.ftruncate(self._file, before)
                raise FileError(f"cannot write {self.path}: only a part of a row fits: is the disk full?")
        except OSError as error:
            raise unwritten(self.path, error) from error

    def sync(self) -> None:
        """Make sure that all lines are on the disk."""
        try:
            os.fsync(self._file)
        except OSError as error:
            raise unwritten(self.path, error) from error

    def close(self) -> None:
        """Close the file."""
        os.close(self._file)


def totals(rows: Sequence[Row], unchanged: int) -> dict[str, Any]:
    """Counts and rows of a batch, as ``--json`` prints them; the exit code is the largest of the rows, or 0."""
    codes = [row.exit_code for row in rows]
    counts = {"cases": len(rows), "failed": sum(code != DONE for code in codes), "unchanged": unchanged}
    return counts | {"exit_code": max(codes, default=DONE), "rows": [row.data() for row in rows]}


def require_no_index(entries: Iterable[Entry], options: BatchOptions) -> None:
    """Check that the page of no case would replace the page of the batch; CaseError if one would."""
    page = _page_of(options)
    for entry in entries if options.page else ():
        folder = entry.destination.folder if entry.destination else None
        if folder and page.name in entry.names and os.path.realpath(folder) == os.path.realpath(page.parent):
            raise CaseError(f"{entry.row.source}: its page would be that of the batch: give the case another name")


@contextmanager
def indexed(
    summary: Summary, entries: Iterable[Entry], options: BatchOptions, warn: Callable[[str], None]
) -> Iterator[None]:
    """Write the page and the picture that compare the cases, if asked for, when the block ends, however it ends.

    The rows are in the order of the entries, after those of cases outside the batch. ``warn`` is called with what is
    missing in the picture. FileError if a file cannot be written.
    """
    try:
        yield
    except BaseException:
        with suppress(BubblemeshError):  # the error that has ended the block is the one to report
            _write_index(summary, entries, options, warn)
        raise
    _write_index(summary, entries, options, warn)


def _write_index(
    summary: Summary, entries: Iterable[Entry], options: BatchOptions, warn: Callable[[str], None]
) -> None:
    """Write the page and the picture that compare the cases, if the options ask for them."""
    if not options.page and not options.history:
        return
    from bubblemesh.pages.index import index_page

    page, numbers = _page_of(options), {entry.row.key: entry.number for entry in entries}
    rows = sorted(summary.rows, key=lambda row: (numbers.get(row.key, 0), row.source, row.case))
    if options.history:
        write_convergence(rows, options.root, options.root / f"{STEM}{options.suffix}{ENDING}", warn)
    if not options.page:
        return
    with transaction(page.parent) as staging:
        text = index_page([_linked(row, page.parent) for row in rows])
        (staging / page.name).write_text(text, encoding="utf-8", newline="\n")


def _page_of(options: BatchOptions) -> Path:
    return options.root / f"index{options.suffix}{PAGE_FILE}"


def _linked(row: Row, folder: Path) -> dict[str, Any]:
    """Values of a row, with the path of its page, if there is one, relative to the folder of the summary."""
    pages = [Path(row.folder or ".", name) for name in row.files if name.endswith(PAGE_FILE)]
    links = [page.as_posix() for page in pages if (folder / page).is_file() and not page.is_absolute()]
    return row.data() | {"report": links[0] if links else None}
