"""The page that compares the cases of a batch and links to theirs."""

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from bubblemesh.batch.plan import Entry
from bubblemesh.batch.rows import Row
from bubblemesh.batch.shards import Shard
from bubblemesh.errors import CaseError, FileError
from bubblemesh.meshfiles.transaction import transaction
from bubblemesh.meshfiles.writing import PAGE_FILE


def require_no_index(entries: Iterable[Entry], folder: Path, shard: Shard) -> None:
    """Check that no case's own page would be where the page of the batch goes.

    Raises
    ------
    CaseError
    """
    page = _page_in(folder, shard)
    for entry in entries:
        alike = [path for path in entry.place.files if path.name == page.name] if entry.place else []
        if any(os.path.realpath(path) == os.path.realpath(page) for path in alike):
            raise CaseError(f"{entry.source}: its page would be that of the batch: give the case another name")


@contextmanager
def indexed(rows: Callable[[], Sequence[Row]], folder: Path, shard: Shard) -> Iterator[None]:
    """Write the page of the rows that there are when the block ends, however it does, in place of an old one.

    Raises
    ------
    FileError
        If it cannot be written.
    """
    try:
        yield
    except BaseException:
        with suppress(FileError):  # what has ended the block is to be told
            _write(rows(), _page_in(folder, shard))
        raise
    _write(rows(), _page_in(folder, shard))


def _page_in(folder: Path, shard: Shard) -> Path:
    return folder / f"index{shard.suffix}{PAGE_FILE}"


def _write(rows: Sequence[Row], page: Path) -> None:
    from bubblemesh.pages.index import index_page

    with transaction(page.parent) as staging:
        text = index_page([_shown(row, page.parent) for row in rows])
        (staging / page.name).write_text(text, encoding="utf-8")


def _shown(row: Row, folder: Path) -> dict[str, Any]:
    """A row with its page, if that is there, seen from the folder of the summary."""
    pages = [Path(row.folder or ".", name) for name in row.files if name.endswith(PAGE_FILE)]
    links = [page.as_posix() for page in pages if (folder / page).is_file() and not page.is_absolute()]
    return row.data() | {"report": links[0] if links else None}
