"""The folders into which a batch writes: other batches are kept out, the files of a case appear together.

Locks are those of the system, which end with the process however that ends. On file systems without locks, batches are
not kept apart.
"""

import os
import shutil
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

from bubblemesh.batch.plan import BatchOptions, Entry
from bubblemesh.batch.row import Row
from bubblemesh.batch.worker import Outcome, is_full
from bubblemesh.errors import FileError
from bubblemesh.files import sync, unwritten
from bubblemesh.meshfiles.transaction import require_writable, transaction

LOCK = ".bubblemesh-lock"
BEGIN = 10.0  # seconds to wait while another batch begins
MAKE_ROOM = "the batch ends, what is done stays: make room, and run it again with --resume"


@contextmanager
def reserved(options: BatchOptions) -> Iterator[None]:
    """Keep other batches out of the summary's folder within the block; shards of one batch may be in it together.

    The folder is made if it is missing. FileError if another batch is in it, or it cannot be made.
    """
    folder = options.root
    require_writable(folder)
    try:
        missing = [path for path in (folder, *folder.parents) if not path.exists()]
        folder.mkdir(parents=True, exist_ok=True)
        for path in missing:
            sync(path.parent)
    except OSError as error:
        raise unwritten(f"into {folder}", error) from None
    busy = (
        f"{folder}: another batch is writing its summary here: wait for it, name another folder, or give both a --shard"
    )
    own = f"{folder}: another batch is writing the summary of this shard here: wait for it, or name another folder"
    with ExitStack() as stack:
        with _locked(folder / f"{LOCK}-begin", f"{folder}: other batches are beginning here: try again", BEGIN):
            stack.enter_context(_locked(folder / f"{LOCK}{options.suffix}", own if options.suffix else busy))
            for other in [folder / LOCK] if options.suffix else folder.glob(f"{LOCK}-*-of-*"):
                with _locked(other, busy):  # so nobody else has it
                    pass
        yield


@contextmanager
def _locked(path: Path, refusal: str, seconds: float = 0.1) -> Iterator[None]:
    """Lock a file within the block, and remove it at the end; whoever waits for it then begins with a new file."""
    from filelock import FileLock, Timeout

    lock = FileLock(path, timeout=seconds, fallback_to_soft=False)
    try:
        lock.acquire()
    except Timeout:
        raise FileError(refusal) from None
    except OSError as error:
        if error.filename is not None:  # no name: a file system without locks
            raise unwritten(path, error) from None
    try:
        yield
    finally:
        with suppress(OSError):
            path.unlink()
        lock.release()


def staging_prefix(folder: Path, options: BatchOptions) -> str:
    """Beginning of the names of staging folders, in which the files of a case are until all of them are complete.

    Batches with different summaries may write into one folder at the same time. The names depend on the summary, which
    one batch has at a time: folders of the same name that an earlier batch has left can be removed.
    """
    try:
        way = os.path.relpath(os.path.realpath(options.root), os.path.realpath(folder))
    except ValueError:  # another drive of Windows
        way = os.path.realpath(options.root)
    return f".bubblemesh-batch-{sha256(os.fsencode(way)).hexdigest()[:12]}{options.suffix}-"


@contextmanager
def tidied(entries: Iterable[Entry], options: BatchOptions) -> Iterator[None]:
    """Remove the staging folders that a killed batch has left, and after the block those that an interrupt leaves."""
    folders = {entry.destination.folder for entry in entries if entry.destination is not None}

    def remove() -> None:
        for folder in folders:
            for leftover in folder.glob(f"{staging_prefix(folder, options)}*"):
                shutil.rmtree(leftover, ignore_errors=True)

    remove()
    try:
        yield
    finally:
        remove()


def place_files(entry: Entry, outcome: Outcome, options: BatchOptions) -> Row:
    """Write the files of a case, all or none of them, and return its row; if that fails, the row has the error.

    FileError if a disk is full, that of the results or that of a worker.
    """
    row, is_at_end = outcome.row, outcome.full
    if outcome.files and entry.destination:
        folder = entry.destination.folder
        try:
            with transaction(folder, staging_prefix(folder, options)) as staging:
                for name, content in outcome.files.items():
                    (staging / name).write_bytes(content)
        except FileError as error:
            row = replace(row, figures={}, files={}).failed(error.exit_code, f"{row.source}: {error}")
            is_at_end = is_full(error)
    if is_at_end:
        raise FileError(f"{row.error}: {MAKE_ROOM}")
    return row
