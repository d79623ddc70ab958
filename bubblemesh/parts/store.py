"""Where packed parts are kept until the mesh is made of them: in the memory, or in files that outlive the process."""

import os
import zlib
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple, Protocol, cast, get_type_hints
from zipfile import BadZipFile, ZipFile

import numpy as np
from numpy.typing import NDArray

from bubblemesh.errors import FileError, prefixed
from bubblemesh.files import opened, unreadable, unwritten
from bubblemesh.parts.part import Core, Margin, Part

NAME = "part-{}.npz"
# What readers raise of archives and arrays that are broken, or are something else.
BROKEN = BadZipFile, EOFError, KeyError, RuntimeError, TypeError, ValueError, zlib.error
UNFINISHED = ".unfinished"  # end of the name of a file that is being written


class Store(Protocol):
    """Keeps parts by their numbers."""

    @property
    def shared(self) -> bool:
        """Whether a copy of it in a process that packs parts keeps them in the same place."""

    def keep(self, number: int, part: Part) -> None:
        """Keep a part."""

    def margin(self, number: int) -> Margin | None:
        """All of a part but its core; None if it is not there as a whole."""

    def core(self, number: int) -> Core:
        """The core of a part that is there."""


class InMemory:
    """Keeps parts as long as the process runs."""

    shared = False

    def __init__(self) -> None:
        self._parts: dict[int, Part] = {}

    def keep(self, number: int, part: Part) -> None:
        """Keep a part."""
        self._parts[number] = part

    def margin(self, number: int) -> Margin | None:
        """All of a part but its core; None if it is not there."""
        return self._parts[number].margin if number in self._parts else None

    def core(self, number: int) -> Core:
        """The core of a part."""
        return self._parts[number].core


class InFolder:
    """Keeps each part in a file of a folder that exists; FileError where it cannot be written or read.

    It is ``shared`` if those who pack the parts see the same folder.
    """

    def __init__(self, folder: Path, *, shared: bool = False) -> None:
        self._folder = folder
        self.shared = shared

    def keep(self, number: int, part: Part) -> None:
        """Keep a part: its file is there as a whole, or not at all."""
        path = self._folder / NAME.format(number)
        begun = path.with_name(path.name + UNFINISHED)
        try:
            with begun.open("wb") as file:
                np.savez(file, allow_pickle=False, number=number, **_columns(part))
            begun.replace(path)
        except OSError as error:
            raise unwritten(path, error) from None

    def margin(self, number: int) -> Margin | None:
        """All of a part but its core; None if it is not there, or damaged, as after a loss of power: both are read.

        FileError if this process has no right to read it: what is packed anew could not be kept.
        """
        try:
            self.core(number)
            return cast("Margin", self._read(number, Margin, "margin"))
        except FileError:
            path = self._folder / NAME.format(number)
            if path.exists() and not os.access(path, os.R_OK):
                raise
            return None

    def core(self, number: int) -> Core:
        """The core of a part."""
        return self._read(number, Core, "core")

    def _read(self, number: int, kind: Any, name: str) -> Any:
        path = self._folder / NAME.format(number)
        try:
            with prefixed(path), opened(path, "part", limited=False) as stream, ZipFile(stream) as file:
                arrays = Arrays(file)
                found = _record(kind, arrays, name)
                if found is None or arrays["number"].tolist() != number:
                    raise ValueError("it is another one")
                return found
        except OSError as error:
            raise FileError(f"{path}: {unreadable(error, 'part')}") from None
        except BROKEN as error:
            raise FileError(f"{path}: this is no part of a mesh: remove it ({error})") from None


class Arrays:
    """Arrays in an archive of NumPy by their names, read to the end, where the archive shows whether they are whole."""

    def __init__(self, file: ZipFile) -> None:
        self._file = file
        self.names = [name.removesuffix(".npy") for name in file.namelist()]

    def __getitem__(self, name: str) -> NDArray[Any]:
        array: NDArray[Any] = np.load(BytesIO(self._file.read(f"{name}.npy")), allow_pickle=False)
        return array


class Keeping(NamedTuple):
    """Where parts are kept, and whether the mesh stays there, to be written slice by slice."""

    store: Callable[[str], Store]  # for the parts of a packing, by its name among those of a case
    in_slices: bool


IN_MEMORY = Keeping(lambda name: InMemory(), in_slices=False)


def _columns(record: Any, name: str = "") -> dict[str, NDArray[Any]]:
    """Arrays and numbers of a record, and of those in it, by their names with dots between; None has none."""
    if hasattr(record, "_asdict"):
        inner = (_columns(value, f"{name}.{key}" if name else key) for key, value in record._asdict().items())
        return {key: value for columns in inner for key, value in columns.items()}
    return {} if record is None else {name: np.asarray(record)}


def _record(kind: Any, file: Arrays, name: str) -> Any:
    """The record of a kind from its `_columns` in a file."""
    options = [option for option in getattr(kind, "__args__", (kind,)) if hasattr(option, "_fields")]
    if not options:
        value = file[name]
        return value if value.ndim else value.item()
    if not any(key.startswith(f"{name}.") for key in file.names):
        return None
    hints = get_type_hints(options[0])
    return options[0](*(_record(hints[key], file, f"{name}.{key}") for key in options[0]._fields))
