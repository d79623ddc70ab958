"""Files of users: how they are opened, how much of one is read, and how they are brought to the disk."""

import errno
import os
import stat
from collections.abc import Collection
from glob import escape
from io import BufferedReader, BytesIO
from pathlib import Path
from typing import BinaryIO

from bubblemesh.errors import CaseError, LimitError, prefixed
from bubblemesh.files.confinement import way_to
from bubblemesh.files.copies import refusal_of
from bubblemesh.files.reasons import unreadable

MOST_BYTES = 500_000_000  # of a case, and of a file with geometry or data
BLOCK = 1_000_000  # bytes that are read at once
CASE_FILE = "case file"
NO_FILE = "a pipe or a device: write what it gives to a file first"
READ = os.O_RDONLY | sum(getattr(os, name, 0) for name in ("O_NONBLOCK", "O_NOCTTY", "O_BINARY"))  # as systems have it


def opened(path: Path, what: str = "file", *, limited: bool = True) -> BufferedReader:
    """Stream of the bytes of a regular file or of its local copy; all files that users name are opened here.

    Pipes and devices are refused without reading, which might never end.

    Raises
    ------
    FileError
        If the file cannot be opened, or is not a regular one.
    LimitError
        If it is ``limited`` and has more than `MOST_BYTES`.
    CaseError
        If it is outside of the folder to which files are confined (`confined_to`).
    BubblemeshError
        The error that `local_copies` has for the file in place of a content.
    """
    if refusal := refusal_of(path):
        raise refusal
    try:
        with way_to(path) as (name, folder):
            follow = folder is None
            # Looked at before, as opening some devices makes them do something.
            _require_regular(os.stat(name, dir_fd=folder, follow_symlinks=follow), what, limited)
            number = os.open(name, READ if follow else READ | os.O_NOFOLLOW, dir_fd=folder)
    except (OSError, ValueError) as error:
        raise unreadable(error, what) from None
    stream = os.fdopen(number, "rb")
    try:
        _require_regular(os.fstat(number), what, limited)  # once more, as it may have been replaced
    except BaseException:
        stream.close()
        raise
    return stream


def _require_regular(status: os.stat_result, what: str, limited: bool) -> None:
    if not stat.S_ISREG(status.st_mode):
        is_folder = stat.S_ISDIR(status.st_mode)
        raise unreadable("it is a folder" if is_folder else f"it is no regular file, but {_no_file(what)}", what)
    if limited and status.st_size > MOST_BYTES:
        raise _too_large(what, f"{status.st_size / 1e6:,.0f} MB, ")


def _no_file(what: str) -> str:
    """What a pipe or a device is, and what to do."""
    return f"{NO_FILE}, or pipe the case in by bubblemesh run -" if what == CASE_FILE else NO_FILE


def _too_large(what: str, size: str = "") -> LimitError:
    advice = "simplify it, or write only what the case needs"
    return LimitError(f"the {what} has {size}more than the {MOST_BYTES / 1e6:,.0f} MB that are read: {advice}")


def read_bytes(path: Path) -> bytes:
    """All bytes of a file; the same errors as `opened` and `content_of`."""
    with opened(path) as stream:
        return content_of(stream)


def content_of(stream: BinaryIO, what: str = "file") -> bytes:
    """All bytes of a stream; FileError if they cannot be read, LimitError if there are more than `MOST_BYTES`."""
    content = BytesIO()
    try:
        # Read in blocks: a stream reserves as much memory as it is asked to read, however little there is to read.
        while block := stream.read(BLOCK):
            content.write(block)
            if content.tell() > MOST_BYTES:
                raise _too_large(what)
    except OSError as error:
        raise unreadable(error, what) from None
    if block is None:  # no bytes yet, as for some files of the system
        raise unreadable(f"it is {_no_file(what)}", what)
    return content.getvalue()


def read_text(path: Path) -> str:
    """Text of a UTF-8 file; the same errors as `read_bytes`, and CaseError if its bytes are no text in UTF-8."""
    content = read_bytes(path)
    if (at := content.find(0)) >= 0:  # at once: readers may take minutes for a file of zeros
        line = content.count(b"\n", 0, at) + 1
        raise CaseError(f"line {line}: not UTF-8 text (found byte 0x00): save the file as UTF-8")
    return _decoded(content, "line ")


def case_text(stream: BinaryIO, source: str) -> str:
    """Text of a case; CaseError, which names its ``source``, if it is not UTF-8; the same errors as `content_of`."""
    with prefixed(source):
        content = content_of(stream, CASE_FILE)
    return _decoded(content, f"{source}:")


def _decoded(content: bytes, place: str) -> str:
    """Text of UTF-8 bytes; CaseError with ``place`` and the number of the line that is not UTF-8."""
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        found = f"byte 0x{content[error.start]:02x}"
        raise CaseError(f"{place}{line}: not UTF-8 text (found {found}): save the file as UTF-8") from None


def require_readable(path: Path) -> None:
    """Check that a library can open a file; the same errors as `opened`."""
    opened(path).close()


def beside(path: Path, endings: Collection[str]) -> list[Path]:
    """Files in the folder of a file that differ from it by one of the endings alone, in small or capital letters."""
    try:
        others = sorted(path.parent.glob(f"{escape(path.stem)}.*")) if endings else []
    except OSError:  # the folder cannot be read: opening the file itself will raise the error
        return []
    return [other for other in others if other.suffix.lower() in endings and other.stem == path.stem]


def sync(path: Path) -> None:
    """Make sure that a file, or the list of names in a folder, is on the disk, if the system can; else OSError."""
    is_folder = path.is_dir()
    if is_folder and os.name == "nt":  # Windows has no way to do that
        return
    number = os.open(path, os.O_RDONLY if is_folder else os.O_RDWR)
    try:
        os.fsync(number)
    except OSError as error:
        if not is_folder or error.errno != errno.EINVAL:  # EINVAL: a file system that syncs folders by itself
            raise
    finally:
        os.close(number)
