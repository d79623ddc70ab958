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

OWNER = ".bubblemesh-owner"  # file in a temporary folder whose lock its process holds
FOLDER = os.O_RDONLY | sum(getattr(os, name, 0) for name in ("O_DIRECTORY", "O_NOFOLLOW"))  # how a folder is opened


@contextmanager
def temporary_folder(parent: Path | None = None, prefix: str = "bubblemesh-", *, tidy: bool = True) -> Iterator[Path]:
    """Folder that is removed when the block ends; to ``tidy``, those of killed processes with this prefix go first.

    It is made in ``parent``, or where the system keeps temporary files. The lock of a file in it, named `OWNER`, tells
    that its process lives: the system gives that up however a process ends. OSError if the folder cannot be made.
    """
    parent = parent or Path(gettempdir())
    if tidy:
        _remove_abandoned(parent, prefix)
    with TemporaryDirectory(prefix=prefix, dir=parent, ignore_cleanup_errors=True) as name, _owned(Path(name)):
        yield Path(name)


@contextmanager
def _owned(folder: Path) -> Iterator[None]:
    """Hold the lock of a folder's file, which has its name only when it is locked; nothing on systems without locks."""
    if fcntl is None:
        yield
        return
    unlocked = folder / f"{OWNER}-new"
    with unlocked.open("x") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            unlocked.rename(folder / OWNER)
        except OSError:  # a file system without locks: what is left over there stays
            unlocked.unlink()
        yield


@contextmanager
def locked(folder: Path) -> Iterator[bool]:
    """Hold the lock of a folder that stays, which the system gives up however a process ends.

    It is False if another process, or another block, holds it; where there are no locks it is True for all. OSError if
    there is no such folder.
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
    """Whether the lock of an open file is, or now becomes, that of this opening."""
    try:
        fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks
        return True
    return True


def _remove_abandoned(parent: Path, prefix: str) -> None:
    """Remove the temporary folders that nobody owns any more."""
    for owner in parent.glob(f"{escape(prefix)}*/{OWNER}") if fcntl is not None else ():
        with suppress(OSError), owner.open("r+") as file:  # of another user, or removed by its own process meanwhile
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            shutil.rmtree(owner.parent, ignore_errors=True)
