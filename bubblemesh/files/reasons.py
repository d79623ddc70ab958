"""Errors of files that cannot be read or written, with the reason that the system gives."""

import errno

from bubblemesh.errors import FileError

TOO_MANY_FILES = errno.EMFILE, errno.ENFILE
MORE_FILES = "let this process open more (ulimit -n 4096), or give a batch fewer --jobs, each of which takes three"


class UnwrittenError(FileError):
    """A file or stream that cannot be written; its cause may be a library's error, which lacks the system's number."""


def unreadable(why: Exception | str, what: str = "file") -> FileError:
    """Error of a file that cannot be read."""
    return FileError(f"the {what} cannot be read: {why if isinstance(why, str) else reason(why)}")


def unwritten(what: object, error: OSError) -> UnwrittenError:
    """Error of a file or stream that cannot be written."""
    # NumPy's tofile has no errno, only how much it could write.
    return UnwrittenError(f"cannot write {what}: {reason(error)}{'' if error.strerror else ' (is the disk full?)'}")


def no_place(error: OSError) -> FileError:
    """Error of temporary files that cannot be made."""
    if error.errno in TOO_MANY_FILES:
        return FileError(f"{reason(error)}: {MORE_FILES}")
    return FileError(f"no place for temporary files: {reason(error)}")


def reason(error: Exception) -> str:
    """Short text that says why a file operation failed."""
    return getattr(error, "strerror", None) or str(error)
