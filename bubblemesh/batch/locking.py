"""One batch at a time writes a summary."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from bubblemesh.batch.shards import WHOLE, Shard
from bubblemesh.errors import FileError
from bubblemesh.files import reason, unwritten

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]


LOCK = ".bubblemesh-lock"
ATTEMPTS = 10  # at a lock file that others remove as they end


@contextmanager
def reserved(folder: Path, shard: Shard) -> Iterator[None]:
    """Keep other batches out of the folder, which is made if it is missing; different shards are in it together.

    The system frees the folder when the process ends, however that happens.

    Raises
    ------
    FileError
        If another batch is in it, or it cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        problem = "it is not a folder" if folder.exists() else reason(error)
        raise FileError(f"cannot write into {folder}: {problem}") from None
    if fcntl is None:
        yield
        return
    with _common(folder, shard), _own(folder, shard):
        yield


@contextmanager
def _common(folder: Path, shard: Shard) -> Iterator[None]:
    """A lock of the folder itself, which shards share and a whole batch has alone."""
    handle = _opened(folder, os.O_RDONLY)
    try:
        advice = "wait for it, name another folder, or give both a --shard"
        refusal = f"{folder}: another batch is writing its summary here: {advice}"
        _lock(handle, fcntl.LOCK_EX if shard == WHOLE else fcntl.LOCK_SH, refusal)
        yield
    finally:
        os.close(handle)


@contextmanager
def _own(folder: Path, shard: Shard) -> Iterator[None]:
    """A lock of this shard alone: a file, since network file systems lock no folder for a single process."""
    path = folder / f"{LOCK}{shard.suffix}"
    what = "its summary" if shard == WHOLE else "the summary of this shard"
    handle = _locked(path, f"{folder}: another batch is writing {what} here: wait for it, or name another folder")
    try:
        yield
    finally:
        with suppress(OSError):
            path.unlink()
        os.close(handle)


def _locked(path: Path, refusal: str) -> int:
    """Handle of the lock file."""
    for _ in range(ATTEMPTS):
        handle = _opened(path, os.O_RDWR | os.O_CREAT)
        try:
            _lock(handle, fcntl.LOCK_EX, refusal)
        except BaseException:
            os.close(handle)
            raise
        if _is_at(path, handle):
            return handle
        os.close(handle)  # who had it has ended and removed it in between
    raise FileError(refusal)


def _opened(path: Path, flags: int) -> int:
    try:
        return os.open(path, flags, 0o666)
    except OSError as error:
        raise unwritten(path, error) from None


def _is_at(path: Path, handle: int) -> bool:
    try:
        return os.path.samestat(path.stat(), os.fstat(handle))
    except FileNotFoundError:
        return False


def _lock(handle: int, how: int, refusal: str) -> None:
    try:
        fcntl.flock(handle, how | fcntl.LOCK_NB)
    except BlockingIOError:
        raise FileError(refusal) from None
    except OSError:  # a file system without locks
        pass
