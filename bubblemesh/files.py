"""Files of users: how they are opened, how much of one is read, why the system refuses one; names for mesh files."""

import errno
import os
import shutil
import stat
from collections.abc import Collection, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from copy import copy
from glob import escape
from io import BufferedReader, BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory, gettempdir
from typing import BinaryIO

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

from bubblemesh.errors import BubblemeshError, CaseError, FileError, LimitError, prefixed

MOST_BYTES = 500_000_000  # of a case, and of a file with geometry or data
BLOCK = 1_000_000  # bytes that are read at once
NO_FILE = "a pipe or a device: write what it gives to a file first, or pipe a case in by bubblemesh run -"
READ = os.O_RDONLY | sum(getattr(os, name, 0) for name in ("O_NONBLOCK", "O_NOCTTY", "O_BINARY"))  # as systems have it
FOLDER = os.O_RDONLY | sum(getattr(os, name, 0) for name in ("O_DIRECTORY", "O_NOFOLLOW"))
TOO_MANY_FILES = errno.EMFILE, errno.ENFILE
MORE_FILES = "let this process open more (ulimit -n 4096), or give a batch fewer --jobs, each of which takes three"
OWNER = ".bubblemesh-owner"  # file in a temporary folder whose lock its process holds
LONGEST_FILE_NAME = 255  # bytes, as usual file systems have it
LONGEST_NAME = 127  # characters of a boundary's, region's or point's name in mesh files
MOST_NAME_BYTES = 253  # of such a name, that Gmsh reads
FORBIDDEN = "quotes, backslashes, line breaks and other control characters"

_copies: ContextVar[Mapping[Path, Path] | None] = ContextVar("copies", default=None)
_refusals: ContextVar[Mapping[Path, BubblemeshError] | None] = ContextVar("refusals", default=None)  # by their copies
_root: ContextVar[Path | None] = ContextVar("root", default=None)


def opened(path: Path, what: str = "file", *, limited: bool = True) -> BufferedReader:
    """Stream of a regular file's bytes, or of those of its local copy: the one way to what a user names.

    A pipe or a device, of which reading may never end, is not waited for. FileError if the system does not give the
    file, or it is no regular one; LimitError if it is ``limited`` and has more than `MOST_BYTES`; CaseError if it is
    elsewhere than files may be (`confined_to`). What could not be copied has the error of that (`local_copies`).
    """
    if refusal := (_refusals.get() or {}).get(local_copy(path)):
        raise copy(refusal)
    try:
        with _way_to(path) as (name, folder):
            follow = folder is None
            # To open some devices is to use them.
            _require_regular(os.stat(name, dir_fd=folder, follow_symlinks=follow), what, limited)
            number = os.open(name, READ if follow else READ | os.O_NOFOLLOW, dir_fd=folder)
    except (OSError, ValueError) as error:
        raise unreadable(error, what) from None
    stream = os.fdopen(number, "rb")
    try:
        _require_regular(os.fstat(number), what, limited)  # it may be another one by now
    except BaseException:
        stream.close()
        raise
    return stream


@contextmanager
def confined_to(root: Path | None) -> Iterator[None]:
    """Within the block, and its thread, files are opened below this folder only, wherever links lead; None is any.

    ``root`` is a real path. Local copies may be anywhere.
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
def _way_to(path: Path) -> Iterator[tuple[Path | str, int | None]]:
    """Name of a file or of its local copy; if files are confined, its last part, and the number of its open folder.

    That folder is reached without links, which somebody may put in place of a folder at any moment.
    """
    root, copy = _root.get(), local_copy(path)
    if root is None or copy in (_copies.get() or {}).values():
        yield copy, None
        return
    real = Path(os.path.realpath(path))
    if not real.is_relative_to(root):
        raise CaseError(
            f"{path}: leads out of {root}: an untrusted case reads only from below its folder: copy it there"
        )
    if os.open not in os.supports_dir_fd or real == root:  # Windows; a folder is no file
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


def _require_regular(status: os.stat_result, what: str, limited: bool) -> None:
    if not stat.S_ISREG(status.st_mode):
        is_folder = stat.S_ISDIR(status.st_mode)
        raise unreadable("it is a folder" if is_folder else f"it is no regular file, but {NO_FILE}", what)
    if limited and status.st_size > MOST_BYTES:
        raise _too_large(what, f"{status.st_size / 1e6:,.0f} MB, ")


def _too_large(what: str, size: str = "") -> LimitError:
    advice = "simplify it, or write only what the case needs"
    return LimitError(f"the {what} has {size}more than the {MOST_BYTES / 1e6:,.0f} MB that are read: {advice}")


def read_bytes(path: Path, what: str = "file") -> bytes:
    """All bytes of a file; errors as of `opened` and `content_of`."""
    with opened(path, what) as stream:
        return content_of(stream, what)


def content_of(stream: BinaryIO, what: str = "file") -> bytes:
    """All bytes of a stream; FileError if they cannot be read, LimitError if there are more than `MOST_BYTES`."""
    content = BytesIO()
    try:
        # A stream sets aside as much memory as it is asked to read, however little there is.
        while block := stream.read(BLOCK):
            content.write(block)
            if content.tell() > MOST_BYTES:
                raise _too_large(what)
    except OSError as error:
        raise unreadable(error, what) from None
    if block is None:  # a file of the system whose bytes are yet to come
        raise unreadable(f"it is {NO_FILE}", what)
    return content.getvalue()


def read_text(path: Path) -> str:
    """Text of a UTF-8 file; errors as of `read_bytes`, CaseError if its bytes are not UTF-8."""
    return _decoded(read_bytes(path), "line ")


def case_text(stream: BinaryIO, source: str) -> str:
    """Text of a case; messages name its ``source``; errors as of `content_of`, CaseError if it is not UTF-8."""
    with prefixed(source):
        content = content_of(stream, "case file")
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
    """Check that a library can open a file; errors are those of `opened`."""
    opened(path).close()


def beside(path: Path, endings: Collection[str]) -> list[Path]:
    """Files in the folder of a file that differ from it by one of the endings alone, in small or capital letters."""
    try:
        others = sorted(path.parent.glob(f"{escape(path.stem)}.*")) if endings else []
    except OSError:  # the folder cannot be looked into, which who opens the file itself will be told
        return []
    return [other for other in others if other.suffix.lower() in endings and other.stem == path.stem]


def bytes_of_name(name: str) -> int:
    """Bytes that a file system needs for the name of a file or a folder."""
    return len(os.fsencode(name))


def sync(path: Path) -> None:
    """Bring a file, or the names in a folder, to the disk, as far as the system can; OSError if that fails."""
    is_folder = path.is_dir()
    if is_folder and os.name == "nt":  # which has no way to do that
        return
    number = os.open(path, os.O_RDONLY if is_folder else os.O_RDWR)
    try:
        os.fsync(number)
    except OSError as error:
        if not is_folder or error.errno != errno.EINVAL:  # of file systems that keep their folders by themselves
            raise
    finally:
        os.close(number)


def unreadable(why: Exception | str, what: str = "file") -> FileError:
    """The error of a file that the system does not give."""
    return FileError(f"the {what} cannot be read: {why if isinstance(why, str) else reason(why)}")


def unwritten(what: object, error: OSError) -> FileError:
    """The error of a file or stream that cannot be written."""
    # NumPy's tofile knows no errno, only how much it could write.
    return FileError(f"cannot write {what}: {reason(error)}{'' if error.strerror else ' (is the disk full?)'}")


def no_place(error: OSError) -> FileError:
    """The error of temporary files that the system does not give."""
    if error.errno in TOO_MANY_FILES:
        return FileError(f"{reason(error)}: {MORE_FILES}")
    return FileError(f"no place for temporary files: {reason(error)}")


def reason(error: Exception) -> str:
    """Say in a few words why a file operation failed."""
    return getattr(error, "strerror", None) or str(error)


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


@contextmanager
def local_copies(contents: Mapping[str, bytes | BubblemeshError]) -> Iterator[None]:
    """Within the block, and its thread, these contents are read in place of the files on the disk.

    They are given by the files' names as the case has them: a batch sends the files of a case along with it to a
    machine whose disk is another one. Who opens a file with an error in place of its content gets that error.
    FileError if there is no place for copies.
    """
    with ExitStack() as stack:
        try:
            copies = _written(contents, stack.enter_context(temporary_folder()))
        except OSError as error:
            raise no_place(error) from error
        errors = {copies[Path(name)]: one for name, one in contents.items() if isinstance(one, BubblemeshError)}
        tokens = _copies.set(copies), _refusals.set(errors)
        try:
            yield
        finally:
            _copies.reset(tokens[0])
            _refusals.reset(tokens[1])


def local_copy(path: Path) -> Path:
    """Path at which to read a file that a case names: that of its local copy, if it has one."""
    copies = _copies.get()
    return copies.get(path, path) if copies else path


def has_copies() -> bool:
    """Whether contents are read in place of files on the disk."""
    return _copies.get() is not None


def _written(contents: Mapping[str, bytes | BubblemeshError], folder: Path) -> dict[Path, Path]:
    """A copy of each file; those of one folder and below it stay together, as some formats find files beside theirs.

    That of a file with an error is a name alone.
    """
    places: dict[Path, Path] = {}
    copies = {}
    for name, content in contents.items():
        path = Path(name)
        below = [(place, path.parent.relative_to(top)) for top, place in places.items() if _is_below(path.parent, top)]
        place = below[0][0] / below[0][1] if below else places.setdefault(path.parent, folder / str(len(places)))
        place.mkdir(parents=True, exist_ok=True)
        copies[path] = place / path.name
        if isinstance(content, bytes):
            copies[path].write_bytes(content)
    return copies


def _is_below(folder: Path, top: Path) -> bool:
    """Whether a folder is another one, or in it."""
    return folder.is_relative_to(top) and ".." not in folder.relative_to(top).parts


def is_writable(name: str) -> bool:
    """Whether every mesh file can hold a name: XML has no form for control characters, and a quote ends it in msh."""
    fits = 0 < len(name) <= LONGEST_NAME and len(name.encode()) <= MOST_NAME_BYTES
    return fits and name.isprintable() and not {*name} & {*'"\\'}
