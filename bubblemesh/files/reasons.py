"""Errors of files that cannot be read or written, with the reason that the system gives."""

import errno
import os

from bubblemesh.errors import FileError, missing_library
from bubblemesh.messages import shown

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
    return outer_cause(error) or FileError(f"no place for temporary files: {reason(error)}")


def reason(error: Exception) -> str:
    """Short text that says why a file operation failed."""
    return getattr(error, "strerror", None) or str(error)


def outer_cause(error: Exception) -> FileError | None:
    """Error of the system or the installation in place of an exception of Python; None if the program is to blame.

    It stands for all that any access to a file may raise, so that it is asked where commands and cases of batches end.
    """
    match error:
        case ModuleNotFoundError() if missing := missing_library(error):
            return FileError(missing)
        case OSError(errno=errno.EMFILE | errno.ENFILE):
            return FileError(f"{reason(error)}: {MORE_FILES}")
        case OSError(errno=errno.ENAMETOOLONG):
            return FileError(
                f"{shown(error.filename)}: {reason(error)}: shorten it, or the names of its folders, and give several "
                "files as several words"
            )
        case OSError() if not _has_current_folder():
            return FileError("the current folder is not there any more: go to another one (cd)")
        case UnicodeEncodeError() if error.encoding != "utf-8":
            advice = "set PYTHONUTF8=1, or use plain letters"
            return FileError(f"{shown(error.object)!r} cannot be written where names are in {error.encoding}: {advice}")
    return None


def _has_current_folder() -> bool:
    """Whether the folder from which relative names start is still there: it may have been removed meanwhile."""
    try:
        os.getcwd()  # noqa: PTH109 - that alone is what fails
    except OSError:
        return False
    return True
