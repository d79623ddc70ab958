"""VTK's XML files of unstructured grids (.vtu), in every encoding: text, base64 or raw, compressed or not."""

import base64
import lzma
import re
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from bubblemesh.errors import FileError
from bubblemesh.files import read_bytes
from bubblemesh.meshfiles.containment import Unpacking
from bubblemesh.meshfiles.sources.source import Data, Source, reals, wholes
from bubblemesh.meshfiles.sources.vtk_cells import vtk_source
from bubblemesh.records import record

KIND = re.compile(r"(Float|U?Int)(8|16|32|64)")
UNPACKERS: dict[str, Callable[[], Any]] = {
    "vtkZLibDataCompressor": zlib.decompressobj,
    "vtkLZMADataCompressor": lzma.LZMADecompressor,
}
Tape = memoryview
APPENDED = re.compile(rb"<AppendedData[^>]*>\s*_")
NO_WHITESPACE = str.maketrans("", "", " \t\r\n")


def read_vtu(path: Path) -> Source:
    """All pieces of a grid as one; FileError if the file cannot be read, LimitError if its data are too large."""
    return joined_pieces(pieces_of(path, Unpacking()))


def joined_pieces(pieces: list["Piece"]) -> Source:
    """Pieces of a grid as one, each with its own nodes, and with the data that all pieces have."""
    if not pieces:
        raise FileError("holds no pieces of a grid")
    filled = [piece for piece in pieces if len(piece.points)] or pieces[:1]
    first = np.cumsum([0, *(len(piece.points) for piece in filled)])
    begin = np.cumsum([0, *(len(piece.nodes) for piece in filled)])
    for piece in filled if len(filled) > 1 else ():
        if len(piece.nodes) and (piece.nodes.min() < 0 or piece.nodes.max() >= len(piece.points)):
            raise FileError("a cell has a node that is not there: the file is damaged")
    return vtk_source(
        np.concatenate([piece.points for piece in filled]),
        np.concatenate([piece.nodes + k for piece, k in zip(filled, first, strict=False)]),
        np.concatenate([piece.ends + k for piece, k in zip(filled, begin, strict=False)]),
        np.concatenate([piece.types for piece in filled]),
        _common([piece.point_data for piece in filled]),
        _common([piece.cell_data for piece in filled]),
    )


@record
class Piece:
    """Nodes, cells and data of a part of a grid."""

    points: Data  # (n, 3)
    nodes: Data  # of all cells, one after the other
    ends: Data  # (c,) of each cell's nodes among these
    types: Data  # (c,)
    point_data: dict[str, Data]
    cell_data: dict[str, Data]


def pieces_of(path: Path, unpacking: Unpacking) -> list[Piece]:
    """The pieces of a grid; the same errors as `read_vtu`."""
    root, arrays = _parsed(read_bytes(path), unpacking)
    if root.tag != "VTKFile" or root.get("type") != "UnstructuredGrid":
        raise FileError(f"holds {root.get('type', root.tag)}: only an UnstructuredGrid of VTK is read from this ending")
    return [_piece(piece, arrays) for piece in root.iterfind("UnstructuredGrid/Piece")]


def _common(data: list[dict[str, Data]]) -> dict[str, Data]:
    names = [name for name in data[0] if all(name in each and _like(each[name], data[0][name]) for each in data)]
    return {name: np.concatenate([each[name] for each in data]) for name in names}


def _like(one: Data, other: Data) -> bool:
    return one.shape[1:] == other.shape[1:]


def _piece(piece: ElementTree.Element, arrays: "_Arrays") -> Piece:
    points = next(iter(_data(piece, "Points", arrays).values()), np.zeros((0, 3)))
    cells = _data(piece, "Cells", arrays)
    missing = [name for name in ("connectivity", "offsets", "types") if name not in cells]
    if missing and len(points):
        raise FileError(f"its cells have no {missing[0]}")
    nodes, ends, types = (
        cells.get(name, np.zeros(0)).astype(np.int64).ravel() for name in ("connectivity", "offsets", "types")
    )
    point_data = {name: values for name, values in _data(piece, "PointData", arrays).items() if name}
    cell_data = {name: values for name, values in _data(piece, "CellData", arrays).items() if name}
    return Piece(points.reshape(-1, 3), nodes, ends, types, point_data, cell_data)


def _data(piece: ElementTree.Element, section: str, arrays: "_Arrays") -> dict[str, Data]:
    """Arrays of a section by their names; that of the points may lack one."""
    found = {}
    for item in piece.iterfind(f"{section}/DataArray"):
        values = arrays.of(item)
        components = int(item.get("NumberOfComponents") or 1)
        found[item.get("Name", "")] = values.reshape(-1, components) if components > 1 else values
    return found


def _parsed(content: bytes, unpacking: Unpacking) -> tuple[ElementTree.Element, "_Arrays"]:
    """The XML and the arrays, which may follow it as raw bytes."""
    start = APPENDED.search(content)
    tail = b""
    if start is not None:
        content, tail = content[: start.start()] + b"</VTKFile>", content[start.end() :]
    try:
        root = ElementTree.fromstring(content)
    except ElementTree.ParseError as error:
        raise FileError(f"is no XML: {error}") from None
    order = ">" if root.get("byte_order") == "BigEndian" else "<"
    raw = start is None or b"base64" not in start.group()
    if not raw:
        tail = b"".join(tail.partition(b"<")[0].split())
    header = np.dtype(order + ("u8" if root.get("header_type") == "UInt64" else "u4"))
    return root, _Arrays(order, header, root.get("compressor"), memoryview(tail), raw, unpacking)


@record
class _Arrays:
    """Encoding of the arrays of a file."""

    order: str  # of bytes
    header: "np.dtype[Any]"  # of the numbers before a block
    compressor: str | None
    tail: Tape  # after the XML
    raw: bool  # rather than base64
    unpacking: Unpacking

    def of(self, item: ElementTree.Element) -> Data:
        """Numbers of an element of the XML."""
        kind = KIND.fullmatch(item.get("type", ""))
        if kind is None:
            raise FileError(f"its data {item.get('Name')} is of the type {item.get('type')!r}, which is not read")
        letter = {"Float": "f", "Int": "i", "UInt": "u"}[kind[1]]
        form, what = item.get("format", "ascii"), f"data {item.get('Name', 'Points')}"
        if form == "ascii":
            words = (item.text or "").split()
            self.unpacking.count(8 * len(words))
            return reals(words, what) if letter == "f" else wholes(words, what)
        if form == "appended":
            content = self._content(self.tail[int(item.get("offset", 0)) :], self.raw)
        else:
            content = self._content(memoryview((item.text or "").translate(NO_WHITESPACE).encode()), False)
        self.unpacking.count(len(content))
        values = np.frombuffer(content, f"{self.order}{letter}{int(kind[2]) // 8}")
        return values.astype(values.dtype.newbyteorder("="))

    def _content(self, tape: Tape, raw: bool) -> bytes | Tape:
        """Bytes of an array, whose header begins a tape."""
        size = self.header.itemsize
        if self.compressor is None:
            length = self._numbers(tape, 1, raw)
            return _bytes_after(tape, size, int(length[0]), raw) if len(length) else b""
        if self.compressor not in UNPACKERS:
            raise FileError(f"is compressed by {self.compressor}, which is not read: write it with zlib or as text")
        count = self._numbers(tape, 1, raw)
        if not len(count) or not count[0]:
            return b""
        sizes = self._numbers(tape, 3 + int(count[0]), raw)[3:]
        packed = _bytes_after(tape, size * (3 + int(count[0])), int(sizes.sum()), raw)
        ends = np.cumsum(sizes).tolist()
        unpacker = UNPACKERS[self.compressor]
        return b"".join(
            self.unpacking.unpacked(unpacker(), bytes(packed[a:b])) for a, b in zip([0, *ends], ends, strict=False)
        )

    def _numbers(self, tape: Tape, count: int, raw: bool) -> Data:
        """The first numbers of a header, fewer if the tape ends."""
        length = count * self.header.itemsize
        content = tape[:length] if raw else _decoded(tape[: _letters(length)])[:length]
        return np.frombuffer(content, self.header, len(content) // self.header.itemsize).astype(np.int64)


def _bytes_after(tape: Tape, header: int, length: int, raw: bool) -> bytes | Tape:
    """Bytes after a header; in base64 they may be encoded together with it, or separately."""
    found: bytes | Tape
    if raw:
        found = tape[header : header + length]
    else:
        letters, padding = _letters(header), -header % 3
        alone = tape[letters - padding : letters] == b"=" * padding
        if alone:
            found = _decoded(tape[letters : letters + _letters(length)])
        else:
            found = _decoded(tape[: _letters(header + length)])[header:]
    if length < 0 or len(found) < length:
        raise FileError("an array ends too early: the file is damaged")
    return found[:length]


def _letters(count: int) -> int:
    """Number of letters in base64 for ``count`` bytes."""
    return -(-count // 3) * 4


def _decoded(letters: Tape) -> bytes:
    try:
        return base64.b64decode(letters, validate=True)
    except ValueError as error:
        raise FileError(f"an array is no base64 ({error})") from None
