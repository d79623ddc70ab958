"""The case files that the paths of a command line mean: folders, patterns and names."""

import os
from collections.abc import Iterator, Sequence
from glob import glob, has_magic
from pathlib import Path

from bubblemesh.errors import CaseError, FileError

ENDINGS = (".yaml", ".yml")
PRIVATE = (".", "_")  # names that begin so are not for everyone, such as those of bases


def case_files(paths: Sequence[str]) -> list[str]:
    """Case files, each once: in the order of the paths, those of a folder or pattern by their names.

    Raises
    ------
    CaseError
        If there is no case file in a folder, or nothing fits a pattern.
    FileError
        If a folder cannot be read.
    """
    found: dict[str, str] = {}
    for path in paths:
        for file in _files(path):
            found.setdefault(os.path.abspath(file), file)  # noqa: PTH100 (two links to one file are two cases)
    return list(found.values())


def _files(path: str) -> list[str]:
    if path == "-":
        raise CaseError("-: a batch reads no case from the standard input: use bubblemesh run -")
    if Path(path).is_dir():
        return _of_folder(path)
    if not has_magic(path) or Path(path).exists():
        return [path]  # a file that is missing is a case that fails
    matches = sorted(glob(path, recursive=True))  # noqa: PTH207 (a whole pattern, absolute or not)
    files = [file for match in matches for file in (_in_folder(match) if Path(match).is_dir() else [match])]
    if not files:
        raise CaseError(f"{path}: no file fits this pattern")
    return files


def _of_folder(path: str) -> list[str]:
    files = list(_in_folder(path))
    if not files:
        raise CaseError(
            f"{path}: no case file is in this folder: their names end in {' or '.join(ENDINGS)}, and those that begin "
            f"with {' or '.join(PRIVATE)} are left out"
        )
    return files


def _in_folder(path: str) -> Iterator[str]:
    def refuse(error: OSError) -> None:
        raise FileError(f"{error.filename}: the folder cannot be read: {error.strerror}")

    for folder, inner, names in os.walk(path, onerror=refuse):
        inner[:] = sorted(name for name in inner if not name.startswith(PRIVATE))
        for name in sorted(names):
            if name.endswith(ENDINGS) and not name.startswith(PRIVATE):
                yield str(Path(folder, name))
