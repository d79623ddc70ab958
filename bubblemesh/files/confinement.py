"""A folder outside of which no file may be opened, for untrusted cases."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from bubblemesh.errors import CaseError
from bubblemesh.files.copies import is_copy, local_copy
from bubblemesh.files.temporary import FOLDER

_root: ContextVar[Path | None] = ContextVar("root", default=None)


@contextmanager
def confined_to(root: Path | None) -> Iterator[None]:
    """Within the block, and in its thread, open files below this folder only, wherever links lead.

    ``root`` is a path without links, or None for no restriction. Local copies may be anywhere.
    """
    token = _root.set(root)
    try:
        yield
    finally:
        _root.reset(token)


def is_confined() -> bool:
    """Whether files may be opened below one folder only."""
    return _root.get() is not None


@contextmanager
def way_to(path: Path) -> Iterator[tuple[Path | str, int | None]]:
    """Path of a file, or of its local copy, and None; if files are confined, its last part and its open folder.

    The folder is given by its file descriptor. It is opened part by part without following links, since somebody may
    replace a folder by a link at any moment.
    """
    root, copy = _root.get(), local_copy(path)
    if root is None or is_copy(copy):
        yield copy, None
        return
    real = Path(os.path.realpath(path))
    if not real.is_relative_to(root):
        raise CaseError(f"leads out of {root}: an untrusted case reads only from below its folder: copy it there")
    if os.open not in os.supports_dir_fd or real == root:  # Windows; or the folder itself, which is not a file
        yield real, None
        return
    *parts, name = real.relative_to(root).parts
    folder = os.open(root, FOLDER)
    try:
        for part in parts:
            outer, folder = folder, os.open(part, FOLDER, dir_fd=folder)
            os.close(outer)
        yield name, folder
    finally:
        os.close(folder)
