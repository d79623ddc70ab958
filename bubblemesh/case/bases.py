"""A case file that extends another one: ``base: other.yaml``."""

from collections.abc import Sequence
from functools import lru_cache
from os.path import realpath
from pathlib import Path
from typing import Any

from bubblemesh.case.data_terms import DataTerms
from bubblemesh.case.fields import is_file_name
from bubblemesh.case.parameters import literal
from bubblemesh.case.yaml import Document, read_case_text, read_document
from bubblemesh.errors import CaseError, prefixed
from bubblemesh.files import with_home
from bubblemesh.records import record

# A batch may have many cases with the same base.
document_of = lru_cache(maxsize=4)(read_document)

OWN_KEYS = ("base", "name", "sweep")  # keys that a case does not inherit from its base and cannot sweep


@record
class SourceFile:
    """The data of a file of a case, with the file's name in messages."""

    source: str
    document: Document
    folder: Path = Path()


def source_files(path: Path, source: str, text: str) -> list[SourceFile]:
    """The files of a case with its ``text``, from the one that has no base to the case itself.

    Messages call the case ``source``. A base is relative to the folder of the file that names it.

    Raises
    ------
    CaseError
        If the name of a base is not a text, or a base extends itself; with the line.
    FileError
        If a base cannot be read; with the line.
    """
    files = [SourceFile(source, document_of(text, source), path.parent)]
    seen = [realpath(path)]
    while (base := files[0].document.data.get("base")) is not None:
        place = f"{files[0].source}:{files[0].document.line(('base',))}: base"
        if not isinstance(base, str) or not base:
            raise CaseError(f"{place}: must be the name of a case file (found {base!r})")
        path = path.parent / with_home(base)
        if realpath(path) in seen:
            raise CaseError(f"{place}: {path} extends itself: remove one of the bases")
        seen.append(realpath(path))
        with prefixed(place):
            text = read_case_text(path)
        files.insert(0, SourceFile(str(path), document_of(text, str(path)), path.parent))
    return files


def merged(files: Sequence[SourceFile]) -> dict[str, Any]:
    """The data of all files together: a key of a later file replaces that of an earlier one; mappings are merged.

    Mappings are merged one level deep: ``packing: {w2: 0.7}`` keeps the base's ``w1``, but a ring is replaced whole.
    """
    data: dict[str, Any] = {}
    for file in files:
        data = {key: value for key, value in data.items() if key not in OWN_KEYS}
        for key, given in file.document.data.items():
            value = _at_home(key, given, file.folder)
            present = data.get(key)
            data[key] = {**present, **value} if isinstance(present, dict) and isinstance(value, dict) else value
    data.pop("base", None)
    return data


def _at_home(key: str, value: Any, folder: Path) -> Any:
    """The value of a key of the case; if it may name files, with the folder before their names."""
    if key == "spacing" and isinstance(value, dict):
        return value | {
            name: _with_files_found(value[name], folder) for name in DataTerms.model_fields if name in value
        }
    return _with_files_found(value, folder) if key in ("domain", "metric") else value


def _with_files_found(value: Any, folder: Path) -> Any:
    """Copy of data with the folder before the names of files in it."""
    if isinstance(value, list):
        return [_with_files_found(entry, folder) if isinstance(entry, (dict, list)) else entry for entry in value]
    if not isinstance(value, dict):
        return value
    found, name = {}, value.get("file")
    if isinstance(name, str) and is_file_name(name) and with_home(name) == name:
        found = {"file": str(Path(literal(str(folder))) / name)}
    return {key: _with_files_found(entry, folder) for key, entry in value.items()} | found


def place_of(files: Sequence[SourceFile], path: Sequence[str | int]) -> str:
    """File and line of the value at a key path, or of what comes nearest to it."""
    known = files[0] if len(files) == 1 else max(reversed(files), key=lambda file: file.document.depth(path))
    return f"{known.source}:{known.document.line(path) or 1}"
