"""Geometry files that came along with a case, from a machine whose disk is elsewhere."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from tempfile import TemporaryDirectory

_copies: ContextVar[Mapping[Path, Path] | None] = ContextVar("copies", default=None)


@contextmanager
def carried(contents: Mapping[str, bytes]) -> Iterator[None]:
    """Within the block, and its thread, these files are read in place of those on the disk.

    Parameters
    ----------
    contents : mapping of str to bytes
        By the files' names as the case has them.

    Raises
    ------
    OSError
        If there is no place for copies.
    """
    with TemporaryDirectory(prefix="bubblemesh-") as folder:
        copies = _written(contents, Path(folder))
        token = _copies.set(copies)
        try:
            yield
        finally:
            _copies.reset(token)


def at_hand(path: Path) -> Path:
    """Where to read a file that a case names."""
    copies = _copies.get()
    return path if copies is None else copies.get(path, path)


def _written(contents: Mapping[str, bytes], folder: Path) -> dict[Path, Path]:
    """A copy of each file; those of one folder stay together, as some formats find files beside theirs."""
    numbers: dict[Path, int] = {}
    copies = {}
    for name, content in contents.items():
        path = Path(name)
        place = folder / str(numbers.setdefault(path.parent, len(numbers)))
        place.mkdir(exist_ok=True)
        copies[path] = place / path.name
        copies[path].write_bytes(content)
    return copies
