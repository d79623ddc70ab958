"""Files of users: how they are opened, how much of one is read, why the system refuses one; names for mesh files."""

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import BinaryIO

from bubblemesh.errors import CaseError, FileError, LimitError

MOST_BYTES = 500_000_000  # of a case, and of a file with geometry
LONGEST_NAME = 127  # characters of a boundary's, region's or point's name in mesh files
MOST_NAME_BYTES = 253  # of such a name, that Gmsh reads
FORBIDDEN = "quotes, backslashes, line breaks and other control characters"

_copies: ContextVar[Mapping[Path, Path] | None] = ContextVar("copies", default=None)


def opened(path: Path, what: str = "file") -> BinaryIO:
    """Stream of a file's bytes, or of those of its local copy; a file that the system does not give is a FileError."""
    try:
        return local_copy(path).open("rb")
    except (OSError, ValueError) as error:
        raise unreadable(error, what) from None


def read_bytes(path: Path) -> bytes:
    """All bytes of a file; one that cannot be read is a FileError."""
    with opened(path) as stream:
        try:
            return stream.read()
        except OSError as error:
            raise unreadable(error) from None


def read_text(path: Path) -> str:
    """Text of a UTF-8 file; FileError if it cannot be read, CaseError if its bytes are not UTF-8."""
    return _decoded(read_bytes(path), "line ")


def case_text(stream: BinaryIO, source: str) -> str:
    """Text of a case; messages name its ``source``. LimitError if it is too large; else as `read_text`."""
    try:
        content = stream.read(MOST_BYTES + 1)
    except OSError as error:
        raise FileError(f"{source}: {unreadable(error, 'case file')}") from None
    if len(content) > MOST_BYTES:
        raise LimitError(f"{source}: has more than the {MOST_BYTES / 1e6:.0f} MB that are read: is it a case?")
    return _decoded(content, f"{source}:")


def _decoded(content: bytes, place: str) -> str:
    """Text of UTF-8 bytes; ``place`` stands before the number of a line that is none."""
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        found = f"byte 0x{content[error.start]:02x}"
        raise CaseError(f"{place}{line}: not UTF-8 text (found {found}): save the file as UTF-8") from None


def require_readable(path: Path) -> None:
    """Check that a library can open a file, else FileError, and that it is not too large, else LimitError."""
    if not os.path.exists(path):  # noqa: PTH110 - the method of paths fails for a name that is too long
        raise unreadable("there is no such file")
    if not path.is_file():
        raise unreadable("it is a folder" if path.is_dir() else "it is no regular file")
    if not os.access(path, os.R_OK):
        raise unreadable("permission denied")
    size = path.stat().st_size
    if size > MOST_BYTES:
        raise LimitError(
            f"the file has {size / 1e6:.0f} MB, more than the {MOST_BYTES / 1e6:.0f} that are read: simplify it, or "
            "write only what the domain needs"
        )


def unreadable(why: Exception | str, what: str = "file") -> FileError:
    """The error of a file that the system does not give."""
    return FileError(f"the {what} cannot be read: {why if isinstance(why, str) else reason(why)}")


def unwritten(what: object, error: OSError) -> FileError:
    """The error of a file or stream that cannot be written."""
    # NumPy's tofile knows no errno, only how much it could write.
    return FileError(f"cannot write {what}: {reason(error)}{'' if error.strerror else ' (is the disk full?)'}")


def reason(error: Exception) -> str:
    """Say in a few words why a file operation failed."""
    return getattr(error, "strerror", None) or str(error)


@contextmanager
def local_copies(contents: Mapping[str, bytes]) -> Iterator[None]:
    """Within the block, and its thread, these contents are read in place of the files on the disk.

    They are given by the files' names as the case has them: a batch sends the files of a case along with it to a
    machine whose disk is another one. OSError if there is no place for copies.
    """
    with TemporaryDirectory(prefix="bubblemesh-") as folder:
        token = _copies.set(_written(contents, Path(folder)))
        try:
            yield
        finally:
            _copies.reset(token)


def local_copy(path: Path) -> Path:
    """Path at which to read a file that a case names: that of its local copy, if it has one."""
    return (_copies.get() or {}).get(path, path)


def _written(contents: Mapping[str, bytes], folder: Path) -> dict[Path, Path]:
    """A copy of each file; those of one folder stay together, as some formats find files beside theirs."""
    numbers: dict[Path, int] = {}
    copies = {}
    for name, content in contents.items():
        path = Path(name)
        place = folder / str(numbers.setdefault(path.parent, len(numbers)))
        place.mkdir(exist_ok=True)
        copies[path] = place / path.name
        copies[path].write_bytes(content)
    return copies


def is_writable(name: str) -> bool:
    """Whether every mesh file can hold a name: XML has no form for control characters, and a quote ends it in msh."""
    fits = 0 < len(name) <= LONGEST_NAME and len(name.encode()) <= MOST_NAME_BYTES
    return fits and name.isprintable() and not {*name} & {*'"\\'}
