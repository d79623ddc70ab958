"""The page that compares the cases of a batch and links to theirs."""

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from bubblemesh.batch.plan import BatchOptions, Entry
from bubblemesh.batch.row import Row
from bubblemesh.errors import CaseError, FileError
from bubblemesh.meshfiles.transaction import transaction
from bubblemesh.meshfiles.writing import PAGE_FILE


def require_no_index(entries: Iterable[Entry], options: BatchOptions) -> None:
    """Check that no case's own page would be where the page of the batch goes; else it is a CaseError."""
    page = _page_of(options)
    for entry in entries if options.page else ():
        alike = [path for path in entry.files if path.name == page.name]
        if any(os.path.realpath(path) == os.path.realpath(page) for path in alike):
            raise CaseError(f"{entry.row.source}: its page would be that of the batch: give the case another name")


@contextmanager
def indexed(rows: Callable[[], Sequence[Row]], options: BatchOptions) -> Iterator[None]:
    """Write the page of the rows that there are when the block ends, however it does, if pages are asked for.

    Raises
    ------
    FileError
        If it cannot be written.
    """
    try:
        yield
    except BaseException:
        with suppress(FileError):  # what has ended the block is to be told
            _write(rows, options)
        raise
    _write(rows, options)


def _write(rows: Callable[[], Sequence[Row]], options: BatchOptions) -> None:
    if not options.page:
        return
    from bubblemesh.pages.index import index_page

    page = _page_of(options)
    with transaction(page.parent) as staging:
        text = index_page([_linked(row, page.parent) for row in rows()])
        (staging / page.name).write_text(text, encoding="utf-8")


def _page_of(options: BatchOptions) -> Path:
    return options.root / f"index{options.suffix}{PAGE_FILE}"


def _linked(row: Row, folder: Path) -> dict[str, Any]:
    """Values of a row and its page, if that is there, seen from the folder of the summary."""
    pages = [Path(row.folder or ".", name) for name in row.files if name.endswith(PAGE_FILE)]
    links = [page.as_posix() for page in pages if (folder / page).is_file() and not page.is_absolute()]
    return row.data() | {"report": links[0] if links else None}
