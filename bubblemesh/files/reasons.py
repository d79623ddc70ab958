"""Why the system does not give files: the errors of these."""

import errno

from bubblemesh.errors import FileError

TOO_MANY_FILES = errno.EMFILE, errno.ENFILE
MORE_FILES = "let this process open more (ulimit -n 4096), or give a batch fewer --jobs, each of which takes three"


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
