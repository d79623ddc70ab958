"""One batch at a time writes a summary."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from bubblemesh.errors import FileError
from bubblemesh.output.atomic import reason

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

__all__ = ["reserved"]


@contextmanager
def reserved(folder: Path, *, shared: bool) -> Iterator[None]:
    """Keep other batches out of the folder, which is made if it is missing; shards (``shared``) are in it together.

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
    handle = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(handle, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(handle)
        raise FileError(
            f"{folder}: another batch is writing its summary here: wait for it, name another folder, or give both a "
            "--shard"
        ) from None
    except OSError:  # a file system without locks
        pass
    try:
        yield
    finally:
        os.close(handle)
