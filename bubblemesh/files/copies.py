"""Contents that are read in place of files on the disk, such as those sent to another machine."""

from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from contextvars import ContextVar
from copy import copy
from pathlib import Path

from bubblemesh.errors import BubblemeshError
from bubblemesh.files.reasons import no_place
from bubblemesh.files.temporary import temporary_folder

_copies: ContextVar[Mapping[Path, Path] | None] = ContextVar("copies", default=None)
_refusals: ContextVar[Mapping[Path, BubblemeshError] | None] = ContextVar("refusals", default=None)  # by their copies


@contextmanager
def local_copies(contents: Mapping[str, bytes | BubblemeshError]) -> Iterator[None]:
    """Within the block, and in its thread, read these contents in place of the files on the disk.

    A batch sends the files of a case along with it to a machine that has another disk.

    Parameters
    ----------
    contents
        The content of each file, by its name as it is in the case. To open a file that has an error in place of its
        content raises that error.

    Raises
    ------
    FileError
        If there is no place for the copies.
    """
    with ExitStack() as stack:
        try:
            copies = _written(contents, stack.enter_context(temporary_folder()))
        except OSError as error:
            raise no_place(error) from error
        errors = {copies[Path(name)]: one for name, one in contents.items() if isinstance(one, BubblemeshError)}
        tokens = _copies.set(copies), _refusals.set(errors)
        try:
            yield
        finally:
            _copies.reset(tokens[0])
            _refusals.reset(tokens[1])


def local_copy(path: Path) -> Path:
    """Path at which to read a file that a case names: that of its local copy, if it has one."""
    copies = _copies.get()
    return copies.get(path, path) if copies else path


def is_copy(path: Path) -> bool:
    """Whether a path is that of a local copy."""
    return path in (_copies.get() or {}).values()


def refusal_of(path: Path) -> BubblemeshError | None:
    """The error that a file has in place of its content, if it has one."""
    refusal = (_refusals.get() or {}).get(local_copy(path))
    return None if refusal is None else copy(refusal)


def has_copies() -> bool:
    """Whether contents are read in place of files on the disk."""
    return _copies.get() is not None


def _written(contents: Mapping[str, bytes | BubblemeshError], folder: Path) -> dict[Path, Path]:
    """Write the files, and return the path of the copy of each; files with an error have a path only.

    Files of one folder, or below it, stay together, as some formats read further files beside the first.
    """
    places: dict[Path, Path] = {}
    copies = {}
    for name, content in contents.items():
        path = Path(name)
        below = [(place, path.parent.relative_to(top)) for top, place in places.items() if _is_below(path.parent, top)]
        place = below[0][0] / below[0][1] if below else places.setdefault(path.parent, folder / str(len(places)))
        place.mkdir(parents=True, exist_ok=True)
        copies[path] = place / path.name
        if isinstance(content, bytes):
            copies[path].write_bytes(content)
    return copies


def _is_below(folder: Path, top: Path) -> bool:
    """Whether a folder is ``top`` or inside of it."""
    return folder.is_relative_to(top) and ".." not in folder.relative_to(top).parts
