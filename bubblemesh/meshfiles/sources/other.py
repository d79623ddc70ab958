"""Formats that meshio reads."""

import contextlib
import io
from pathlib import Path
from typing import Any

from bubblemesh.errors import FileError
from bubblemesh.meshfiles.containment import bounded_reading
from bubblemesh.meshfiles.med import teach_med
from bubblemesh.meshfiles.sources.source import Source
from bubblemesh.messages import LONGEST_REASON, shown


def read_med(path: Path) -> Source:
    """Mesh of Salome or Code_Aster; the same errors as `read_other`."""
    teach_med()
    return read_other(path)


def read_other(path: Path) -> Source:
    """Mesh as read by meshio, by the file's ending; FileError with meshio's reason."""
    import meshio

    chatter = io.StringIO()
    streams = contextlib.redirect_stdout(chatter), contextlib.redirect_stderr(chatter)
    try:
        with bounded_reading(), streams[0], streams[1]:  # the standard streams belong to all threads, too
            mesh: Any = meshio.read(path)
    except SystemExit:  # raised by meshio if all readers for the ending fail; it prints their reasons
        raise FileError(f"is no mesh that can be read ({_reason(chatter.getvalue(), path)})") from None
    return Source.of(mesh)


def _reason(printed: str, path: Path) -> str:
    """Text that meshio has printed, without the name of the file, with which messages begin."""
    lines = [line.strip().removeprefix("Error: ").strip() for line in printed.splitlines() if line.strip()]
    said = [line for line in lines if "Couldn't read file" not in line and str(path) not in line]
    return shown(" ".join(said) or "meshio gives no reason", LONGEST_REASON)
