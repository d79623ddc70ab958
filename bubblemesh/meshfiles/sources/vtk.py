"""VTK's legacy files: binary ones of unstructured grids are read here, all others by meshio.

meshio would read the binary table of colours that FreeFEM writes as text.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from bubblemesh.arrays import Integers
from bubblemesh.errors import FileError
from bubblemesh.files import opened, read_bytes
from bubblemesh.meshfiles.sources.other import read_other
from bubblemesh.meshfiles.sources.source import Data, Source, require_length, wholes
from bubblemesh.meshfiles.sources.vtk_cells import vtk_source
from bubblemesh.messages import shown

TYPES = {  # names of numbers, all of which have their highest byte first
    "unsigned_char": ">u1",
    "char": ">i1",
    "unsigned_short": ">u2",
    "short": ">i2",
    "unsigned_int": ">u4",
    "int": ">i4",
    "unsigned_long": ">u8",
    "long": ">i8",
    "vtkidtype": ">i4",
    "float": ">f4",
    "double": ">f8",
    **{f"vtktype{sign}int{8 * size}": f">{sign or 'i'}{size}" for sign in ("", "u") for size in (1, 2, 4, 8)},
}
COLOURS = 4  # bytes of each entry of a table of colours
BINARY, GRID = b"BINARY", b"DATASET UNSTRUCTURED_GRID"


def read_vtk(path: Path) -> Source:
    """Nodes, cells and data of a legacy file; the same errors as `read_other`, FileError if a binary one is damaged."""
    with opened(path) as stream:
        head = [stream.readline(300).strip().upper() for _ in range(4)]
    if head[2] != BINARY or head[3] != GRID:
        return read_other(path)
    grid = _Grid(read_bytes(path))
    while words := grid.words():
        section = SECTIONS.get(words[0].upper())
        if section is None:
            raise FileError(f"has the section {shown(words[0])!r}, which is not known: write the grid as .vtu")
        section(grid, words[1:])
    return grid.source()


@dataclass
class _Grid:
    """State of a file that is read section by section: its lines, and what has been found."""

    content: bytes
    at: int = 0
    found: dict[str, Data] = field(default_factory=dict)  # points, nodes and ends of cells, types
    data: dict[str, dict[str, Data]] = field(default_factory=lambda: {"POINT_DATA": {}, "CELL_DATA": {}})
    of: str = ""  # whether the next data are of points or cells
    count: int = 0  # number of their rows

    def __post_init__(self) -> None:
        for _ in range(4):
            self.line()

    def line(self) -> str:
        end = self.content.find(b"\n", self.at)
        end = len(self.content) if end < 0 else end
        text, self.at = self.content[self.at : end], end + 1
        return text.decode("latin-1").strip()

    def words(self) -> list[str]:
        """Words of the next line that is not blank; an empty list at the end."""
        while self.at < len(self.content):
            if words := self.line().split():
                return words
        return []

    def numbers(self, kind: str, *shape: int) -> Data:
        """The next numbers, as an array."""
        if kind.lower() not in TYPES:
            raise FileError(f"has numbers of the type {shown(kind)!r}, which is not known: write the grid as .vtu")
        dtype, count = np.dtype(TYPES[kind.lower()]), int(np.prod([int(n) for n in shape], dtype=object))
        require_length(len(self.content) - self.at, count * dtype.itemsize, "bytes")
        values = np.frombuffer(self.content, dtype, count, self.at).reshape(shape)
        self.at += count * dtype.itemsize
        return values.astype(dtype.newbyteorder("="))

    def source(self) -> Source:
        missing = [name for name in ("points", "nodes", "types") if name not in self.found]
        if missing:
            raise FileError(f"ends before its {missing[0]}: the file is damaged")
        found, points, cells = self.found, self.data["POINT_DATA"], self.data["CELL_DATA"]
        return vtk_source(found["points"], found["nodes"], found["ends"], found["types"], points, cells)


def _points(grid: _Grid, words: list[str]) -> None:
    grid.found["points"] = grid.numbers(_word(words, 1), _count(words, 0), 3)


def _cells(grid: _Grid, words: list[str]) -> None:
    """Read cells: each after its size, or since version 5 as separate lists of ends and nodes."""
    count, length, before = _count(words, 0), _count(words, 1), grid.at
    following = grid.words()
    if following and following[0].upper() == "OFFSETS":
        ends = grid.numbers(_word(following, 1), count)
        kind = _word(grid.words(), 1)
        grid.found |= {"ends": ends[1:].astype(np.int64), "nodes": grid.numbers(kind, length).astype(np.int64)}
        return
    grid.at = before
    items = grid.numbers("int", length).astype(np.int64)
    sizes = _sizes(items, count)
    heads = np.cumsum(sizes + 1) - sizes - 1
    grid.found |= {"ends": np.cumsum(sizes), "nodes": np.delete(items[: int((sizes + 1).sum())], heads)}


def _sizes(items: Integers, count: int) -> Integers:
    """Numbers (count,) of the nodes of cells in a list that has the size and the nodes of each cell.

    FileError if the list is too short, or a size is invalid.
    """
    sizes = np.zeros(count, np.int64)
    cell, at, ahead = 0, 0, 1
    while cell < count:
        if at >= len(items) or not 0 <= items[at] < len(items):
            raise FileError("its lists of cells do not fit together: the file is damaged")
        # Cells of one kind are mostly in a row: look at many at a time, twice as many as were of the same size before.
        size = int(items[at])
        heads = items[at :: size + 1][: min(ahead, count - cell)]
        alike = int(np.argmin(heads == size)) or len(heads)
        sizes[cell : cell + alike] = size
        cell, at, ahead = cell + alike, at + alike * (size + 1), 2 * alike
    return sizes


def _types(grid: _Grid, words: list[str]) -> None:
    grid.found["types"] = grid.numbers("int", _count(words, 0)).astype(np.int64)


def _data_of(name: str) -> Callable[[_Grid, list[str]], None]:
    def begin(grid: _Grid, words: list[str]) -> None:
        grid.of, grid.count = name, _count(words, 0)

    return begin


def _keep(grid: _Grid, name: str, values: Data) -> None:
    if grid.of:
        grid.data[grid.of][name] = values[:, 0] if values.ndim == 2 and values.shape[1] == 1 else values


def _scalars(grid: _Grid, words: list[str]) -> None:
    before = grid.at
    following = grid.words()
    if not (len(following) == 2 and following[0].upper() == "LOOKUP_TABLE"):
        grid.at = before
    columns = _count(words, 2) if len(words) > 2 else 1
    _keep(grid, _word(words, 0), grid.numbers(_word(words, 1), grid.count, columns))


def _vectors(grid: _Grid, words: list[str]) -> None:
    _keep(grid, _word(words, 0), grid.numbers(_word(words, 1), grid.count, 3))


def _tensors(grid: _Grid, words: list[str]) -> None:
    _keep(grid, _word(words, 0), grid.numbers(_word(words, 1), grid.count, 9))


def _colours(grid: _Grid, words: list[str]) -> None:
    grid.numbers("unsigned_char", grid.count, _count(words, 1))


def _table(grid: _Grid, words: list[str]) -> None:
    grid.numbers("unsigned_char", _count(words, 1), COLOURS)


def _field(grid: _Grid, words: list[str]) -> None:
    for _ in range(_count(words, 1)):
        head = grid.words()
        while head and head[0].upper() == "METADATA":
            _metadata(grid, [])
            head = grid.words()
        if not head:
            raise FileError("ends within its data: the file is damaged")
        _keep(grid, head[0], grid.numbers(_word(head, 3), _count(head, 2), _count(head, 1)))


def _metadata(grid: _Grid, words: list[str]) -> None:
    """Skip lines on names and units, which end with an empty line."""
    while grid.at < len(grid.content) and grid.line():
        pass


def _word(words: list[str], place: int) -> str:
    if place >= len(words):
        raise FileError(f"has a line that ends too early ({shown(' '.join(words))!r}): the file is damaged")
    return words[place]


def _count(words: list[str], place: int) -> int:
    count = int(wholes([_word(words, place)], "counts")[0])
    if count < 0:
        raise FileError(f"has a count of {count}: the file is damaged")
    return count


SECTIONS: dict[str, Callable[[_Grid, list[str]], None]] = {
    "POINTS": _points,
    "CELLS": _cells,
    "CELL_TYPES": _types,
    "POINT_DATA": _data_of("POINT_DATA"),
    "CELL_DATA": _data_of("CELL_DATA"),
    "SCALARS": _scalars,
    "VECTORS": _vectors,
    "NORMALS": _vectors,
    "TENSORS": _tensors,
    "COLOR_SCALARS": _colours,
    "LOOKUP_TABLE": _table,
    "FIELD": _field,
    "METADATA": _metadata,
}
