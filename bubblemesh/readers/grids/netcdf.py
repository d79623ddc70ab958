"""NetCDF files: the classic formats, and version 4, which is HDF5. Windows of arrays can be read.

References
----------
Unidata, "NetCDF Classic Format Specification" (CDF-1, CDF-2 and CDF-5).
"""

import math
import mmap
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from io import BufferedReader
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bubblemesh.errors import BubblemeshError, FileError, LimitError
from bubblemesh.files import opened
from bubblemesh.messages import cause
from bubblemesh.readers.grids import MOST_VALUES
from bubblemesh.records import record

CLASSIC, HDF = b"CDF", b"\x89HDF\r\n\x1a\n"
TYPES = {1: "i1", 2: "S1", 3: ">i2", 4: ">i4", 5: ">f4", 6: ">f8", 7: "u1", 8: ">u2", 9: ">u4", 10: ">i8", 11: ">u8"}
DIMENSION, VARIABLE, ATTRIBUTE = 10, 11, 12
MOST_NAMES = 100_000  # in a header

Window = tuple[slice, ...]


@record
class Variable:
    """An array of a file, of which a part may be read."""

    dimensions: tuple[str, ...]
    shape: tuple[int, ...]
    kind: str  # NumPy's type of the values
    attributes: Mapping[str, Any]
    part: Callable[[Window], NDArray[Any]]

    def __call__(self, *window: slice) -> NDArray[Any]:
        """The values, or those of a window, one slice for each of the first dimensions; LimitError if too many."""
        whole = (*window, *(slice(None) for _ in self.shape[len(window) :]))
        count = math.prod(len(range(*part.indices(n))) for part, n in zip(whole, self.shape, strict=True))
        if count > MOST_VALUES:
            raise LimitError(f"has {count:,} values where {MOST_VALUES:,} are read at most: thin it out")
        return self.part(whole)

    def numbers(self, *window: slice) -> NDArray[np.float64]:
        """The values as real numbers, with the scale and offset in the attributes applied; NaN for missing ones."""
        raw = self(*window)
        values = raw.astype(float)
        for name in ("_FillValue", "missing_value"):
            if name in self.attributes:
                values[np.isin(raw, np.atleast_1d(self.attributes[name]))] = np.nan
        values[np.abs(values) >= 9.9e36] = np.nan  # the libraries' default for missing values
        scale, offset = (float(self.attributes.get(key, x)) for key, x in (("scale_factor", 1), ("add_offset", 0)))
        return values * scale + offset

    def text(self, name: str) -> str:
        """The text of an attribute; empty if it is missing or not a text."""
        value = self.attributes.get(name, "")
        return value if isinstance(value, str) else ""


@contextmanager
def netcdf(path: Path) -> Iterator[dict[str, Variable]]:
    """Variables of a file by their names, to be used within the block; FileError if it is not NetCDF or damaged."""
    with opened(path, limited=False) as stream:
        start = stream.peek(8)[:8]
        if not start.startswith(CLASSIC) and start != HDF:
            raise FileError("is no NetCDF file")
        try:
            with _classic(stream) if start.startswith(CLASSIC) else _hdf(stream) as found:
                yield found
        except (BubblemeshError, MemoryError):
            raise
        except Exception as error:  # damaged files fail in any way
            raise FileError(f"is a damaged NetCDF file ({cause(error, 200)})") from error


@contextmanager
def _hdf(stream: BufferedReader) -> Iterator[dict[str, Variable]]:
    """Variables of the root group of a file of version 4."""
    import h5py  # here, so that cases without such files do not wait for it

    with h5py.File(stream, "r") as file:
        links = {name: file.get(name, getlink=True) for name in file}
        parts = {name: file[name] for name, link in links.items() if isinstance(link, h5py.HardLink)}
        yield {name: _of_dataset(part) for name, part in parts.items() if isinstance(part, h5py.Dataset)}


def _of_dataset(data: Any) -> Variable:
    def part(window: Window) -> NDArray[Any]:
        if data.external or data.is_virtual:
            raise FileError(f"{data.name} is in another file: write all into one")
        if math.prod(data.chunks or (1,)) > MOST_VALUES:
            raise LimitError(f"{data.name} is in pieces of more than {MOST_VALUES:,} values: write smaller chunks")
        return np.asarray(data[window])

    own = data.name.strip("/")
    names = [dim[0].name.strip("/") if len(dim) else (own if data.ndim == 1 else "") for dim in data.dims]
    attributes = {name: _plain(data.attrs[name]) for name in data.attrs if name not in HIDDEN}
    return Variable(tuple(names), tuple(data.shape or ()), data.dtype.kind, attributes, part)


HIDDEN = ("DIMENSION_LIST", "REFERENCE_LIST", "CLASS", "NAME", "_Netcdf4Dimid", "_Netcdf4Coordinates")


def _plain(value: Any) -> Any:
    """The value of an attribute as a text, a number or an array of numbers."""
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.ravel()[0]
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else value


class _Header:
    """Reader of the numbers and names in a header, one after the other."""

    def __init__(self, content: mmap.mmap, wide: bool) -> None:
        self.content, self.place = content, 4
        self.count_type = ">i8" if wide else ">i4"

    def values(self, kind: str, count: int) -> NDArray[Any]:
        """The next ``count`` values; they are padded to a multiple of four bytes."""
        size = count * np.dtype(kind).itemsize
        if count < 0 or self.place + size > len(self.content):
            raise ValueError("its header ends too early")
        found = np.frombuffer(self.content[self.place : self.place + size], kind)
        self.place += -(-size // 4) * 4
        return found

    def number(self, kind: str = ">i4") -> int:
        return int(self.values(kind, 1)[0])

    def count(self) -> int:
        return self.number(self.count_type)

    def name(self) -> str:
        return self.values("S1", self.count()).tobytes().decode("utf-8", "replace")

    def entries(self, tag: int) -> range:
        """The indices of the entries of a list of the header (dimensions, attributes or variables).

        Its tag comes first; ValueError if that is another one.
        """
        found, count = self.number(), self.count()
        if found not in (0, tag) or not 0 <= count <= MOST_NAMES:
            raise ValueError("a list of its header has another tag")
        return range(count)

    def attributes(self) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for _ in self.entries(ATTRIBUTE):
            name = self.name()
            values = self.values(TYPES[self.number()], self.count())
            text = values.dtype.kind == "S"
            found[name] = values.tobytes().decode("utf-8", "replace") if text else _plain(values)
        return found


class _Placed(NamedTuple):
    """Position of the values of a variable in the file."""

    dimensions: list[int]
    attributes: dict[str, Any]
    kind: str
    begin: int


@contextmanager
def _classic(stream: BufferedReader) -> Iterator[dict[str, Variable]]:
    with mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as content:
        yield _classic_variables(content)


def _classic_variables(content: mmap.mmap) -> dict[str, Variable]:
    """Variables of a file in a classic format, by its header."""
    version = content[3]
    header = _Header(content, wide=version == 5)
    records = header.count()
    dimensions = [(header.name(), header.count()) for _ in header.entries(DIMENSION)]
    header.attributes()
    placed: dict[str, _Placed] = {}
    for _ in header.entries(VARIABLE):
        name = header.name()
        numbers = header.values(header.count_type, header.count()).tolist()
        attributes, kind = header.attributes(), TYPES[header.number()]
        header.count()  # its size, which is not needed
        placed[name] = _Placed(numbers, attributes, kind, header.number(">i4" if version == 1 else ">i8"))
    sizes = [size for _, size in dimensions]
    recorded = {name for name, each in placed.items() if each.dimensions and sizes[each.dimensions[0]] == 0}
    step = sum(_bytes(placed[name], sizes, padded=len(recorded) > 1) for name in recorded)
    found = {}
    for name, each in placed.items():
        shape = [sizes[k] for k in each.dimensions]
        row = _bytes(each, sizes, padded=False)
        size = row
        if name in recorded:
            known = records if records >= 0 else (len(content) - each.begin) // max(step, 1)
            shape[0], size = known, max(known - 1, 0) * step + row * (known > 0)
        if min(shape, default=0) < 0 or each.begin < 0 or each.begin + size > len(content):
            raise ValueError(f"{name} is not all there")
        part = _part_of(content, each, shape, step if name in recorded else None)
        names = tuple(dimensions[k][0] for k in each.dimensions)
        found[name] = Variable(names, tuple(shape), np.dtype(each.kind).kind, each.attributes, part)
    return found


def _bytes(each: _Placed, sizes: list[int], *, padded: bool) -> int:
    """Size of a variable in bytes; that of one record if it has records."""
    size = math.prod(sizes[k] or 1 for k in each.dimensions) * np.dtype(each.kind).itemsize
    return -(-size // 4) * 4 if padded else size


def _part_of(content: mmap.mmap, each: _Placed, shape: list[int], step: int | None) -> Callable[[Window], NDArray[Any]]:
    """Function that reads a window of a variable; ``step`` is the number of bytes from record to record."""
    dtype = np.dtype(each.kind)
    strides = [dtype.itemsize * math.prod(shape[k + 1 :]) for k in range(len(shape))]
    if step is not None:
        strides[0] = step

    def part(window: Window) -> NDArray[Any]:
        # A copy, since the file cannot be closed while there is a view of it.
        return np.ndarray(tuple(shape), dtype, content, each.begin, tuple(strides))[window].copy()

    return part
