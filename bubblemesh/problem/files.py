"""The files that a case names: which they are, what is in them, and copies of them for an untrusted case."""

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from hashlib import sha256
from pathlib import Path
from typing import Any

from bubblemesh import readers
from bubblemesh.case import Case
from bubblemesh.case.data_terms import DataTerm
from bubblemesh.case.fields import Strict
from bubblemesh.case.geometry_files import SelectedFile
from bubblemesh.case.shoreline import ShorelineKeys
from bubblemesh.errors import BubblemeshError, prefixed
from bubblemesh.files import confined_to, has_copies, local_copies, read_bytes


def parts_of(model: Strict) -> Iterator[Strict]:
    """A case, or a part of it, and all parts within that."""
    yield model
    for value in vars(model).values():  # far quicker than by the model itself, and there may be many
        for part in value if isinstance(value, tuple) else [value]:
            if isinstance(part, Strict):
                yield from parts_of(part)


def named_files(model: Strict) -> Iterator[Path]:
    """The files that a case, or a part of it, names, with those that belong to them."""
    for part in parts_of(model):
        if isinstance(part, SelectedFile | ShorelineKeys):
            yield from readers.files_of(Path(part.file))
        if isinstance(part, DataTerm):
            yield from part.files()


def unit_of_files(model: Strict) -> str | None:
    """The first unit of length that a case, or a part of it, names for a file, if there is one."""
    units = (part.units for part in parts_of(model) if isinstance(part, SelectedFile))
    return next((unit for unit in units if unit is not None), None)


def files_of_case(case: Case) -> list[Path]:
    """All files that a case names, with those that belong to them as far as it may read these."""
    with confined_to(case.root):
        return list(named_files(case))


def contents_of(model: Strict, root: Path | None) -> dict[str, bytes]:
    """Contents of the files that a case, or a part of it, names, by their names; errors have the file.

    CaseError if a file lies elsewhere than below the root of an untrusted case.
    """
    with confined_to(root):
        return {str(path): _content(path) for path in named_files(model)}


def contents_or_errors(model: Strict, root: Path | None) -> dict[str, bytes | BubblemeshError]:
    """Contents as from `contents_of`, with the error itself in place of what cannot be read."""
    with confined_to(root):
        return {str(path): _content_or_error(path) for path in named_files(model)}


def _content_or_error(path: Path) -> bytes | BubblemeshError:
    try:
        return read_bytes(path)
    except BubblemeshError as error:
        return error


def _content(path: Path) -> bytes:
    with prefixed(path):
        return read_bytes(path)


@contextmanager
def own_files(model: Strict, root: Path | None) -> Iterator[None]:
    """Within the block libraries find no other files than copies of those that a part of an untrusted case may read.

    Nothing changes for a trusted one, and copies that are there already stay. The same errors as `contents_of`;
    FileError if there is no place for copies.
    """
    copies = nullcontext() if root is None or has_copies() else local_copies(contents_of(model, root))
    with confined_to(root), copies:
        yield


def inputs_digest(case: Case, files: Mapping[str, bytes], **more: Any) -> str:
    """Hash of a case with the contents of its ``files``, by their names, and of ``more`` that its results depend on.

    Where files lie does not count, what is in them does. Nor does it count what is written, and how much time and
    memory there is.
    """
    contents = {name: sha256(content).hexdigest() for name, content in files.items()}
    data = case.model_dump(mode="json", exclude={"output": True, "limits": {"seconds", "max_memory_mb"}})
    inputs = {
        "case": _with_contents(data, contents) if contents else data,
        "files": sorted((Path(name).name, digest) for name, digest in contents.items()),
        **more,
    }
    return sha256(json.dumps(inputs, sort_keys=True).encode()).hexdigest()


def _with_contents(value: Any, contents: Mapping[str, str]) -> Any:
    """Copy of data with the hash of its content in place of each file's name."""
    if isinstance(value, dict):
        named = {"file": contents[value["file"]]} if value.get("file") in contents else {}
        return {key: _with_contents(entry, contents) for key, entry in value.items()} | named
    if isinstance(value, list | tuple):
        return [_with_contents(entry, contents) for entry in value]
    return value
