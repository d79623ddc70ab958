"""Temporary folders, also those of processes that were killed, and locks of folders."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from glob import escape
from pathlib import Path
from tempfile import TemporaryDirectory, gettempdir

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

OWNER = ".bubblemesh-owner"  # file in a temporary folder, locked by the process that has made it
FOLDER = os.O_RDONLY | sum(getattr(os, name, 0) for name in ("O_DIRECTORY", "O_NOFOLLOW"))  # flags to open a folder


@contextmanager
def temporary_folder(parent: Path | None = None, prefix: str = "bubblemesh-", *, tidy: bool = True) -> Iterator[Path]:
    """Folder that is removed when the block ends; OSError if it cannot be made.

    A file in it, named `OWNER`, is locked as long as its process lives: the system frees the lock however that ends.

    Parameters
    ----------
    parent
        Folder in which it is made; by default the one that the system has for temporary files.
    prefix
        Beginning of its name.
    tidy
        Whether to remove, before, the folders with this prefix that killed processes have left.
    """
    parent = parent or Path(gettempdir())
    if tidy:
        _remove_abandoned(parent, prefix)
    with TemporaryDirectory(prefix=prefix, dir=parent, ignore_cleanup_errors=True) as name, _owned(Path(name)):
        yield Path(name)


@contextmanager
def _owned(folder: Path) -> Iterator[None]:
    """Lock a file of a folder, which gets its name when it is locked; do nothing on systems without locks."""
    if fcntl is None:
        yield
        return
    unlocked = folder / f"{OWNER}-new"
    with unlocked.open("x") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            unlocked.rename(folder / OWNER)
        except OSError:  # a file system without locks: folders of killed processes stay there
            unlocked.unlink()
        yield


@contextmanager
def locked(folder: Path) -> Iterator[bool]:
    """Lock a permanent folder within the block; the system frees the lock however the process ends.

    The value is False if another process, or another block, holds the lock, and always True where there are no locks.
    OSError if there is no such folder.
    """
    if fcntl is None:
        yield True
        return
    number = os.open(folder, FOLDER)
    try:
        yield _is_mine(number)
    finally:
        os.close(number)


def _is_mine(number: int) -> bool:
    """Try to lock an open file; whether this opening of it holds the lock now."""
    try:
        fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks
        return True
    return True


def _remove_abandoned(parent: Path, prefix: str) -> None:
    """Remove the temporary folders whose processes have ended."""
    for owner in parent.glob(f"{escape(prefix)}*/{OWNER}") if fcntl is not None else ():
        with suppress(OSError), owner.open("r+") as file:  # error: of another user, or just removed by its own process
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            shutil.rmtree(owner.parent, ignore_errors=True)
