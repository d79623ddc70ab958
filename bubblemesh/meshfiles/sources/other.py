"""Formats that meshio reads."""

import contextlib
import io
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any, TypeVar

from bubblemesh.errors import FileError
from bubblemesh.files import opened
from bubblemesh.meshfiles.sources.source import Source
from bubblemesh.messages import LONGEST_REASON, shown
from bubblemesh.process.shared import ALONE

Text = TypeVar("Text", str, bytes)

MOST_ENDS = 1000  # how often the end of a file may be read


def read_other(path: Path) -> Source:
    """Mesh as read by meshio, by the file's ending; FileError with meshio's reason."""
    import meshio

    chatter = io.StringIO()
    streams = contextlib.redirect_stdout(chatter), contextlib.redirect_stderr(chatter)
    try:
        with _bounded(), streams[0], streams[1]:  # the standard streams belong to all threads, too
            mesh: Any = meshio.read(path)
    except SystemExit:  # raised by meshio if all readers for the ending fail; it prints their reasons
        raise FileError(f"is no mesh that can be read ({_reason(chatter.getvalue(), path)})") from None
    return Source.of(mesh)


def _reason(printed: str, path: Path) -> str:
    """Text that meshio has printed before it gave up, without the name of the file, with which messages begin."""
    lines = [line.strip() for line in printed.partition("Error: Couldn't read file")[0].splitlines()]
    said = [line for line in lines if line and str(path) not in line]
    return shown(" ".join(said) or "meshio gives no reason", LONGEST_REASON)


class _Lines(io.TextIOWrapper):
    """Text that ends readers which read beyond its end for ever, waiting for a line."""

    _ends = 0

    def readline(self, size: int = -1, /) -> str:  # type: ignore[override]
        line = super().readline(size)
        self._ends = 0 if line else self._ends + 1
        return _not_for_ever(line, self._ends)


class _Bytes(io.BufferedReader):
    """Bytes that end readers which read beyond their end for ever."""

    _ends = 0

    def readline(self, size: int | None = -1, /) -> bytes:
        line = super().readline(size)
        self._ends = 0 if line else self._ends + 1
        return _not_for_ever(line, self._ends)


def _not_for_ever(line: Text, ends: int) -> Text:
    if ends > MOST_ENDS:
        raise EOFError("it ends too early")
    return line


def _opened(path: str, mode: str) -> IO[Any]:
    """A file that meshio opens to read."""
    stream = _Bytes(opened(Path(path)).detach())
    return stream if "b" in mode else _Lines(stream)


@contextlib.contextmanager
def _bounded() -> Iterator[None]:
    """Within the block, meshio opens files by the function of this package, and cannot read beyond their end for ever.

    The readers of many formats wait for a line beyond the end. The function is the same for all threads, so that only
    one thread at a time is in such a block. Blocks must not be nested.
    """
    from meshio import _files as door

    with ALONE:
        door.open = _opened
        try:
            yield
        finally:
            del door.open
