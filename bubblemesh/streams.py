"""The standard input and output, as bytes: the locale of the terminal does not matter to data."""

import sys
from typing import BinaryIO

from bubblemesh.errors import CaseError, FileError

__all__ = ["output_stream", "read_input", "write_output"]


def read_input() -> str:
    """All of the standard input.

    Raises
    ------
    FileError
        If it is closed.
    CaseError
        If it is not UTF-8 text.
    """
    if sys.stdin is None:
        raise FileError("the standard input is closed")
    try:
        return sys.stdin.buffer.read().decode("utf-8")
    except UnicodeDecodeError as error:
        raise CaseError(f"<stdin>: is not UTF-8 text ({error.reason} at byte {error.start})") from error


def output_stream() -> BinaryIO:
    """The standard output; a closed one is a FileError."""
    if sys.stdout is None:
        raise FileError("the standard output is closed")
    return sys.stdout.buffer


def write_output(text: str) -> None:
    """Write text to the standard output, and see that it arrives.

    Raises
    ------
    FileError
        If it cannot be written.
    BrokenPipeError
        If its reader has gone.
    """
    stream = output_stream()
    try:
        stream.write(text.encode("utf-8"))
        stream.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        raise FileError(f"cannot write to the standard output: {error.strerror}") from error
