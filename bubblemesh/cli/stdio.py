"""The standard streams: input and output as bytes, as data must not depend on the locale; and the error stream."""

import os
import sys
from pathlib import Path
from typing import Any, BinaryIO, TextIO, cast

from bubblemesh.errors import CaseError, FileError
from bubblemesh.files import case_text, sync, unwritten


def read_input() -> str:
    """The whole text of the standard input; FileError if it is closed, and the errors of `case_text`."""
    if sys.stdin is None:
        raise FileError("the standard input is closed")
    return case_text(sys.stdin.buffer, "<stdin>")


def write_new(path: Path, text: str) -> None:
    """Write text to a new file, whole or not at all; FileError if there is a file, or it cannot be written."""
    made = False
    try:
        with path.open("x", encoding="utf-8") as file:
            made = True
            file.write(text)
        sync(path)
        sync(path.parent)
    except FileExistsError as error:
        raise FileError(f"{path}: exists already: give another name") from error
    except BaseException as error:
        if made:
            path.unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise FileError(f"{path}: cannot be written: {error.strerror}") from error
        raise


def output_stream() -> BinaryIO:
    """The standard output; FileError if it is closed."""
    if sys.stdout is None:
        raise FileError("the standard output is closed")
    return sys.stdout.buffer


def mesh_stream(output: str | None, as_json: bool) -> BinaryIO | None:
    """The standard output if the option ``-o`` names it as the place of a mesh, else None.

    FileError if it is closed or a terminal, CaseError if it is also to get a report as JSON.
    """
    if output != "-":
        return None
    stream = output_stream()
    if stream.isatty():
        raise FileError("-o -: the mesh would go to the terminal: redirect it or pipe it to a program")
    if as_json:
        raise CaseError("--json and -o - would both write to the standard output: drop one of them")
    return stream


def write_output(text: str) -> None:
    """Write text to the standard output, and flush it.

    FileError if it cannot be written, BrokenPipeError if its reader has gone.
    """
    stream = output_stream()
    try:
        stream.write(text.encode("utf-8"))
        stream.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        raise unwritten("to the standard output", error) from error


def write_json(data: Any) -> None:
    """Write data as JSON to the standard output; the same errors as `write_output`."""
    from bubblemesh.meshfiles.text import json_text

    write_output(json_text(data))


class Expendable:
    """A stream that drops its text as soon as writing fails, so that the work does not end for want of a message.

    From then on the stream's file descriptor leads to the null device, for what is still buffered and for other
    writers.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write text, or drop it."""
        try:
            return self._stream.write(text)
        except OSError:
            self._give_up()
            return len(text)

    def flush(self) -> None:
        """Write what is buffered, or drop it."""
        try:
            self._stream.flush()
        except OSError:
            self._give_up()

    def _give_up(self) -> None:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, self._stream.fileno())
        os.close(nowhere)


def expendable_messages() -> None:
    """From now on, let the process go on if its error stream fails: on a full disk, or without a reader."""
    if sys.stderr is not None:
        sys.stderr = cast(TextIO, Expendable(sys.stderr))
