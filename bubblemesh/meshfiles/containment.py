"""Checks of hostile mesh files before they are read: data in files elsewhere, small files that unpack to large ones."""

import gzip
import lzma
import re
import zlib
from collections.abc import Callable, Iterable, Iterator
from contextlib import nullcontext
from io import SEEK_END
from pathlib import Path, PurePath
from typing import Any, BinaryIO

from bubblemesh.errors import FileError, LimitError, prefixed
from bubblemesh.files import opened, read_bytes, require_readable

MOST_UNPACKED = 1_000_000_000  # bytes
GZIP, HDF = b"\x1f\x8b", b"\x89HDF\r\n\x1a\n"  # with which files begin
CHUNK = 1 << 20
INCLUDE = re.compile(rb"^[ \t]*\*[* \t]*include", re.IGNORECASE | re.MULTILINE)


def check_content(path: Path) -> None:
    """Check a file of any format by what is in it: one that is HDF by `check_hdf`, a compressed one by `check_gzip`."""
    with opened(path) as stream:
        is_compressed, is_hdf = _has(stream, 0, GZIP), any(_has(stream, place, HDF) for place in _hdf_starts(stream))
    if is_hdf:
        check_hdf(path)
    if is_compressed:
        check_gzip(path)


def _has(stream: BinaryIO, place: int, mark: bytes) -> bool:
    """Whether these bytes are in a file at a place."""
    stream.seek(place)
    return stream.read(len(mark)) == mark


def _hdf_starts(stream: BinaryIO) -> Iterator[int]:
    """Places where an HDF file may begin, in the same file after anything else: 0, 512, 1024, 2048 and so on."""
    size, place = stream.seek(0, SEEK_END), 0
    while place < size:
        yield place
        place = max(512, 2 * place)


def check_hdf(path: Path) -> None:
    """Check an HDF file: FileError if a part is in another file, LimitError for too much data."""
    require_little(sum(_sizes(path).values()))


def _sizes(path: Path) -> dict[str, int]:
    """Sizes in bytes of all data sets of an HDF file, by their names; FileError if one is in another file."""
    import h5py

    sizes: dict[str, int] = {}

    def look(group: Any) -> None:
        for name in group:
            link = group.get(name, getlink=True)
            if isinstance(link, h5py.ExternalLink):
                raise FileError(f"{group.name}: {name} is in another file: write all into one")
            part = group[name] if isinstance(link, h5py.HardLink) else None
            if isinstance(part, h5py.Dataset):
                if part.external or part.is_virtual:
                    raise FileError(f"{part.name} is in another file: write all into one")
                sizes[part.name.strip("/")] = 0 if part.shape is None else part.nbytes

    with opened(path) as stream, h5py.File(stream, "r") as file:
        look(file)
        file.visititems(lambda _, part: look(part) if isinstance(part, h5py.Group) else None)
    return sizes


def check_xdmf(path: Path) -> None:
    """Check an XDMF file: FileError if data are neither in it nor in an HDF file beside it, LimitError for too much."""
    sizes: dict[Path, dict[str, int]] = {}
    total = 0
    for other, inside in _parts_of_xdmf(path):
        if other not in sizes:
            sizes[other] = _sizes(other)
        total += sizes[other].get(inside.strip("/"), 0)
    require_little(total)


def _parts_of_xdmf(path: Path) -> Iterator[tuple[Path, str]]:
    """The files with data of an XDMF file, and the data sets within these."""
    from xml.etree import ElementTree  # here, so that cases without mesh files do not wait for it

    for item in ElementTree.fromstring(read_bytes(path)).iter("DataItem"):
        kind = item.get("Format", "XML")
        if kind not in ("HDF", "XML"):
            raise FileError(f"its data are in the form {kind!r}: write them as HDF, or into the file itself")
        name, _, inside = (item.text or "").strip().partition(":") if kind == "HDF" else ("", "", "")
        if PurePath(name).name != name:
            raise FileError("its data are in a file in another folder: put the two into one folder")
        if name:
            yield path.parent / name, inside


def files_of_xdmf(path: Path) -> Iterator[Path]:
    """The files with data of an XDMF file; the same errors as `check_xdmf`, and those of the reader of XML."""
    return (other for other, _ in _parts_of_xdmf(path))


def check_include(path: Path) -> None:
    """Check an input file of Abaqus: FileError if it includes another one."""
    if INCLUDE.search(read_bytes(path)):
        raise FileError("it includes another file: write all into one")


def all_readable(beside: Callable[[Path], Iterable[Path]]) -> Callable[[Path], None]:
    """Check of a file that those which belong to it can be read, and lie in the folders that may be.

    Its errors name the other file.
    """

    def check(path: Path) -> None:
        for other in beside(path):
            with prefixed(f"{other.name} beside it") if other != path else nullcontext():
                require_readable(other)

    return check


def check_gzip(path: Path) -> None:
    """Check a compressed file: LimitError if it unpacks to too much."""
    size = 0
    with opened(path) as stream, gzip.open(stream) as unpacked:
        while chunk := unpacked.read(CHUNK):
            size += len(chunk)
            require_little(size)


class Unpacking:
    """Count of the bytes to which a file has been unpacked so far, with a limit."""

    def __init__(self) -> None:
        self._size = 0  # bytes

    def unpacked(self, unpacker: Any, data: bytes) -> bytes:
        """The data of one block; LimitError if it is too much, FileError if it is incomplete."""
        try:
            found: bytes = unpacker.decompress(data, MOST_UNPACKED - self._size + 1)
        except (zlib.error, lzma.LZMAError) as error:
            raise FileError(f"compressed data are damaged: {error}") from None
        self.count(len(found))
        if not unpacker.eof:
            raise FileError("compressed data are not whole")
        return found

    def count(self, size: int) -> None:
        """Count further bytes; LimitError if it is too much."""
        self._size += size
        require_little(self._size)


def require_little(size: int) -> None:
    """Check a number of bytes to which a file is unpacked; LimitError if it is too much."""
    if size > MOST_UNPACKED:
        advice = "write only what the case needs"
        raise LimitError(f"it unpacks to more than the {MOST_UNPACKED / 1e6:,.0f} MB that are read: {advice}")
