"""Sections of Gmsh's files (.msh), and the numbers in them, as text or in binary form."""

import re
import warnings
from collections.abc import Iterator
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import FileError
from bubblemesh.meshfiles.sources.source import require_length
from bubblemesh.messages import shown

HEAD = re.compile(rb"\$MeshFormat\s+(\S+)\s+(\d+)\s+(\d+)[ \t\r]*\n")
BEGIN = re.compile(rb"^\$(\w+)[ \t\r]*\n", re.MULTILINE)
VERSIONS = {"2": "2.2", "2.0": "2.2", "2.1": "2.2", "2.2": "2.2", "4": "4.0", "4.0": "4.0", "4.1": "4.1"}
FOUR_COUNTS = re.compile(rb"^\$Nodes\s+\d+[ \t]+\d+[ \t]+\d+[ \t]+\d+[ \t\r]*\n", re.MULTILINE)  # only in version 4.1
ONE = 1  # at the beginning of a binary file, to show the order of its bytes


class Form(NamedTuple):
    """How a file holds numbers."""

    version: str  # 2.2, 4.0 or 4.1
    binary: bool
    size: int  # bytes of sizes
    order: str  # of bytes, as NumPy writes it


class Section(NamedTuple):
    """Text or bytes between $NAME and $EndNAME."""

    name: str
    body: bytes


def form_of(data: bytes) -> Form:
    """Form of a file's numbers; FileError if the file is not one of Gmsh, or of a version that is not read."""
    head = HEAD.search(data)
    if head is None:
        raise FileError("has no $MeshFormat: it is no mesh of Gmsh, or of its version 1: let Gmsh write version 4.1")
    version = head[1].decode("ascii", "replace")
    if version not in VERSIONS:
        raise FileError(f"is of version {shown(version)} of Gmsh's format: let Gmsh write version 4.1, or 2.2")
    order = "<" if int.from_bytes(data[head.end() : head.end() + 4], "little") == ONE else ">"
    # Gmsh writes 4 for version 4.0, other programs write it for 4.1.
    exact = "4.1" if version == "4" and FOUR_COUNTS.search(data) else VERSIONS[version]
    size = int(head[3]) if exact == "4.1" else 8
    if size not in (4, 8):
        raise FileError(f"has sizes of {size} bytes, where 4 or 8 are to be: it is damaged")
    return Form(exact, head[2] != b"0", size, order)


def sections(data: bytes) -> Iterator[Section]:
    """All sections of a file; FileError if one does not end."""
    at = 0
    while (begin := BEGIN.search(data, at)) is not None:
        end = data.find(b"$End" + begin[1], begin.end())
        name = begin[1].decode("ascii", "replace")
        if end < 0:
            raise FileError(f"it ends too early: there is no $End{shown(name)}")
        yield Section(name, data[begin.end() : end])
        at = end + len(b"$End" + begin[1])


class Numbers(Protocol):
    """Reader of the numbers in a section, one after the other; FileError if it ends, or has something else."""

    def ints(self, count: int) -> Integers:
        """Whole numbers (count,)."""

    def sizes(self, count: int) -> Integers:
        """Whole numbers (count,) that are counts."""

    def tags(self, count: int) -> Integers:
        """Numbers (count,) of nodes or elements."""

    def reals(self, count: int) -> Floats:
        """Real numbers (count,)."""

    def rows(self, count: int, width: int) -> tuple[Integers, Floats]:
        """For each of ``count`` rows, a whole number (count,) and real numbers (count, width)."""


class Text:
    """Reader of numbers that are written as text."""

    def __init__(self, body: bytes, name: str) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # from NumPy, which stops at a text that is not a number
            try:
                self._values = np.fromstring(body.decode("ascii", "replace"), sep=" ")
            except (DeprecationWarning, ValueError):
                raise FileError(f"its section {name} holds what is no number: it is damaged") from None
        self._at, self._name = 0, name

    def _taken(self, count: int) -> Floats:
        _require_count(count, self._name)
        found = self._values[self._at : self._at + count]
        require_length(len(found), count, f"numbers of {self._name}")
        self._at += count
        return found

    def ints(self, count: int) -> Integers:
        return _wholes(self._taken(count), self._name)

    sizes = tags = ints

    def reals(self, count: int) -> Floats:
        return self._taken(count)

    def rows(self, count: int, width: int) -> tuple[Integers, Floats]:
        _require_count(min(count, width), self._name)
        table = self._taken(count * (1 + width)).reshape(count, 1 + width)
        return _wholes(table[:, 0], self._name), table[:, 1:]

    def ahead(self, count: int) -> Integers:
        """The next whole numbers (count,), without moving on."""
        found = self.ints(count)
        self._at -= count
        return found

    def alike(self, width: int, same: slice) -> Integers:
        """The next rows (m, width), as long as the columns ``same`` have the values of the first row."""
        left = (len(self._values) - self._at) // width
        require_length(left, 1, f"rows of {self._name}")
        table = self._values[self._at : self._at + left * width].reshape(left, width)
        count = looked = 1
        while count == looked and looked < left:  # twice as many rows each time, since there may be many blocks
            looked = min(2 * looked, left)
            other = (table[:looked, same] != table[0, same]).any(axis=1)
            count = int(other.argmax()) if other.any() else looked
        self._at += count * width
        return _wholes(table[:count], self._name)


class Binary:
    """Reader of binary numbers."""

    def __init__(self, body: bytes, name: str, form: Form) -> None:
        self._body, self._name, self._form, self._at = body, name, form, 0

    def _taken(self, kind: np.dtype[Any], count: int) -> NDArray[Any]:
        _require_count(count, self._name)
        left = (len(self._body) - self._at) // kind.itemsize
        require_length(left, count, f"numbers of {self._name}")
        found = np.frombuffer(self._body, kind, count, self._at)
        self._at += count * kind.itemsize
        return found

    def ints(self, count: int) -> Integers:
        return self._taken(np.dtype(f"{self._form.order}i4"), count).astype(np.int64)

    def sizes(self, count: int) -> Integers:
        return self._taken(np.dtype(f"{self._form.order}i{self._form.size}"), count).astype(np.int64)

    def tags(self, count: int) -> Integers:
        return self.sizes(count) if self._form.version == "4.1" else self.ints(count)

    def reals(self, count: int) -> Floats:
        return self._taken(np.dtype(f"{self._form.order}f8"), count).astype(float)

    def rows(self, count: int, width: int) -> tuple[Integers, Floats]:
        _require_count(min(count, width), self._name)
        kind = np.dtype([("number", f"{self._form.order}i4"), ("values", f"{self._form.order}f8", (width,))])
        found = self._taken(kind, count)
        return found["number"].astype(np.int64), found["values"].astype(float)


def first_line(body: bytes) -> tuple[bytes, bytes]:
    """First line of a body that is not empty, and the rest."""
    first, _, rest = body.lstrip(b"\r\n").partition(b"\n")
    return first.strip(), rest


def _require_count(count: int, name: str) -> None:
    if count < 0:
        raise FileError(f"its section {name} has a count below 0: it is damaged")


def _wholes(values: Floats, name: str) -> Integers:
    if not (np.abs(values) <= np.iinfo(np.int64).max // 2).all() or (values != np.round(values)).any():
        raise FileError(f"its section {name} has numbers that are not whole: it is damaged")
    return values.astype(np.int64)
