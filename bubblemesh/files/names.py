"""Names: how long those of files can be, and which ones mesh files can hold."""

import os
from typing import Any

from bubblemesh.errors import CaseError
from bubblemesh.messages import shown

LONGEST_FILE_NAME = 255  # bytes, in most file systems
LONGEST_NAME = 127  # characters of a boundary's, region's or point's name in mesh files
MOST_NAME_BYTES = 253  # of such a name: Gmsh reads no more
LARGEST_ID = 2**31 - 1  # of a group: formats and solvers hold ids as integers of 32 bits
FORBIDDEN = "quotes, backslashes, line breaks and other control characters"


def bytes_of_name(name: str) -> int:
    """Bytes that a file system needs for the name of a file or a folder."""
    return len(os.fsencode(name))


def with_home(path: os.PathLike[str] | str) -> str:
    """A path as a text, with the user's home folder in place of ``~`` at its start, as shells have it.

    That of another user stands for ``~name``; where there is no such user, the path is as it was. CaseError for what is
    no path.
    """
    text = os.fspath(path) if isinstance(path, str | os.PathLike) else path
    if not isinstance(text, str):
        raise CaseError(f"path: must be a text or a Path (found {type(path).__name__})")
    if not text.startswith("~"):
        return text
    try:
        return os.path.expanduser(text)  # noqa: PTH111 - the method of paths fails where there is no such user
    except ValueError:  # a null character, which opening the file will tell
        return text


def is_writable(name: str) -> bool:
    """Whether every mesh file can hold a name: XML has no form for control characters, and a quote ends it in msh."""
    fits = 0 < len(name) <= LONGEST_NAME and len(name.encode()) <= MOST_NAME_BYTES
    return fits and name.isprintable() and not {*name} & {*'"\\'}


def require_name(name: Any, argument: str) -> str:
    """The given name; CaseError, with the name of the argument, if it is not a text that every mesh file can hold."""
    if not isinstance(name, str) or not is_writable(name):
        raise CaseError(f"{argument}: {shown(repr(name))} is no name: use short texts without {FORBIDDEN}")
    return name
