"""Text of a file."""

from pathlib import Path

from bubblemesh.errors import CaseError, FileError


def read_text(path: Path) -> str:
    """Text of a UTF-8 file.

    Raises
    ------
    FileError
        If there is no such file, or it cannot be read.
    CaseError
        If its bytes are not UTF-8.
    """
    try:
        content = path.read_bytes()
    except (OSError, ValueError) as error:
        raise unreadable(error) from None
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise CaseError(f"line {line}: not UTF-8 text (found byte 0x{content[error.start]:02x})") from None


def unreadable(error: Exception) -> FileError:
    """The error of a file that the system does not give."""
    return FileError(f"the file cannot be read: {getattr(error, 'strerror', None) or error}")
