"""Files that appear together and complete, or not at all, and that survive a power cut."""

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from os.path import exists, isfile
from pathlib import Path
from tempfile import TemporaryDirectory, TemporaryFile

from bubblemesh.errors import FileError
from bubblemesh.files import LONGEST_FILE_NAME, OWNER, bytes_of_name, sync, temporary_folder, unwritten
from bubblemesh.process.watchdog import settle

_PREFIX = ".bubblemesh-"


@contextmanager
def transaction(folder: Path, prefix: str = _PREFIX, *, lasting: bool = True) -> Iterator[Path]:
    """Staging directory, whose files are moved into the folder when the block ends without an exception.

    After an exception, KeyboardInterrupt included, the folder and its old files are as they were. A symbolic link with
    the name of a new file is replaced, not followed. From the moment when files are moved, a time limit of the run ends
    nothing any more.

    Parameters
    ----------
    folder
        Where the files are to be; it is made if it is missing.
    prefix
        Beginning of the name of the staging directory.
    lasting
        Whether the files must survive a power cut once the block has ended.

    Raises
    ------
    FileError
        For any OSError, with the path and the reason; and if something other than a file has the name of a new file.
    """
    try:
        with (
            existing(folder, lasting),
            # A caller with a prefix of its own removes old folders itself: searching a large folder each time takes
            # long.
            temporary_folder(folder, prefix, tidy=prefix == _PREFIX) as staging,
        ):
            yield staging
            settle()
            _publish(staging, folder, lasting)
    except OSError as error:
        raise unwritten(_culprit(error, folder), error) from error


def _culprit(error: OSError, folder: Path) -> Path:
    if not isinstance(error.filename, str):
        return folder
    path = Path(error.filename)
    if path.name.startswith(_PREFIX):
        return folder
    return folder / path.name if path.parent.name.startswith(_PREFIX) else path


def require_room(folder: Path, names: Iterable[str]) -> None:
    """Check that names in a folder are free or those of files, so that files can have them.

    FileError if not, or if the name of the folder, or of one around it, is too long.
    """
    if any(bytes_of_name(part) > LONGEST_FILE_NAME for part in folder.parts):
        raise FileError(f"cannot write into {folder}: this is too long a name: shorten it")
    for name in names:
        path = folder / name
        if exists(path) and not isfile(path):  # noqa: PTH110, PTH113 - the methods of paths fail for too long a name
            raise FileError(f"cannot write {path}: something that is not a file has this name")


def require_writable(folder: Path, names: Iterable[str] = ()) -> None:
    """Check, before the work for them begins, that files with these names can be written into a folder.

    The folder need not exist, and is not made; nothing is left in it. The same FileError as `transaction` and
    `require_room`.
    """
    require_room(folder, names)
    _require_folder(folder)
    there = next(path for path in (folder, *folder.parents) if exists(path))  # noqa: PTH110 - as above
    try:
        TemporaryFile(dir=there).close()
    except OSError as error:
        raise unwritten(f"into {folder}", error) from error


def _require_folder(folder: Path) -> None:
    """Check that a path is a folder, or that nothing is there."""
    if folder.is_symlink() and not folder.exists():
        raise FileError(f"cannot write into {folder}: it is a symbolic link that leads nowhere")
    if folder.exists() and not folder.is_dir():
        raise FileError(f"cannot write into {folder}: it is not a folder")


@contextmanager
def existing(folder: Path, lasting: bool) -> Iterator[None]:
    """Make the folder and its parents, and remove those made here, if they are empty, after an exception.

    FileError if something else has the name. With ``lasting``, the new folders survive a power cut.
    """
    _require_folder(folder)
    missing = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        yield
        for path in missing if lasting else ():
            sync(path.parent)
    except BaseException:
        for path in missing:
            with suppress(OSError):
                path.rmdir()
        raise


def _publish(staging: Path, folder: Path, lasting: bool) -> None:
    """Move the files of the staging directory into the folder, all of them or none."""
    names = sorted(path.name for path in staging.iterdir() if path.name != OWNER)
    require_room(folder, names)
    for name in names if lasting else ():
        sync(staging / name)  # before it gets its name: a power cut leaves the old file or the complete new one
    with TemporaryDirectory(prefix=_PREFIX, dir=staging) as kept:
        touched: list[str] = []
        try:
            for name in names:
                touched.append(name)
                _keep(folder / name, Path(kept, name))
                (staging / name).replace(folder / name)
            if lasting:
                sync(folder)
        except BaseException:
            for name in touched:
                _restore(folder / name, Path(kept, name), new=not (staging / name).exists())
            raise


def _keep(target: Path, backup: Path) -> None:
    if not _present(target):
        return
    try:
        os.link(target, backup, follow_symlinks=False)
    except OSError:
        # A file system without hard links.
        target.replace(backup)


def _restore(target: Path, backup: Path, *, new: bool) -> None:
    if _present(backup):
        backup.replace(target)
    elif new:
        target.unlink(missing_ok=True)


def _present(path: Path) -> bool:
    return path.is_symlink() or path.exists()
