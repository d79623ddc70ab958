"""Lists of VTK's files: the times of a solution (.pvd), and the parts of a grid, one for each process (.pvtu)."""

from dataclasses import replace
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree

import numpy as np

from bubblemesh.errors import FileError, prefixed
from bubblemesh.files import read_bytes
from bubblemesh.meshfiles.containment import Unpacking
from bubblemesh.meshfiles.groups import GLOBAL_NODE
from bubblemesh.meshfiles.sources.source import Block, Source
from bubblemesh.meshfiles.sources.vtu import Piece, joined_pieces, pieces_of

MOST_FILES = 10_000  # of one grid


def read_pvtu(path: Path) -> Source:
    """The parts of a grid as one; the same errors as `read_vtu`.

    Nodes with the same ``GlobalNodeId`` become one, if all that have it are in the same place.
    """
    source = joined_pieces(_pieces(files_of_pvtu(path)))
    ids = source.point_data.get(GLOBAL_NODE, np.zeros(0))
    if ids.dtype.kind not in "iu" or len(ids) != len(source.points):
        return source
    _, first, node = np.unique(ids, return_index=True, return_inverse=True)
    if not np.array_equal(source.points[first[node]], source.points):
        return source
    blocks = [Block(block.type, node[block.data]) for block in source.cells]
    data = {name: values[first] for name, values in source.point_data.items()}
    return replace(source, points=source.points[first], cells=blocks, point_data=data)


def read_pvd(path: Path) -> Source:
    """The grid of the last time; the same errors as `read_vtu`."""
    times, last, files = _last(path)
    # Each process may have a part of its own; a first file of the same time and part may hold the mesh alone.
    parts = [part for file in files for part in (files_of_pvtu(file) if file.suffix.lower() == ".pvtu" else [file])]
    notes = (f"holds {times} times: the last one, {last:g}, is read",) if times > 1 else ()
    return replace(joined_pieces(_pieces(parts)), notes=notes)


def files_of_pvd(path: Path) -> list[Path]:
    """The files of the last time in a list; FileError if it is not such a list."""
    return _last(path)[2]


def _last(path: Path) -> tuple[int, float, list[Path]]:
    """Number of times, the last one, and its files."""
    entries = [(float(entry.get("timestep") or 0), entry) for entry in _root(path).iterfind("Collection/DataSet")]
    if not entries:
        raise FileError("lists no files")
    last = max(time for time, _ in entries)
    names = {entry.get("part", "0"): entry.get("file", "") for time, entry in entries if time == last}
    return len({time for time, _ in entries}), last, [_beside(path, name) for name in names.values()]


def files_of_pvtu(path: Path) -> list[Path]:
    """The files of the parts of a grid; FileError if there are none, or too many."""
    names = dict.fromkeys(part.get("Source", "") for part in _root(path).iterfind("PUnstructuredGrid/Piece"))
    if not names or len(names) > MOST_FILES:
        raise FileError(f"lists {len(names):,} files of a grid: from 1 to {MOST_FILES:,} are read")
    return [_beside(path, name) for name in names]


def _pieces(paths: list[Path]) -> list[Piece]:
    unpacking, found = Unpacking(), []
    for path in paths:
        with prefixed(path.name):
            found += pieces_of(path, unpacking)
    return found


def _root(path: Path) -> ElementTree.Element:
    try:
        return ElementTree.fromstring(read_bytes(path))
    except ElementTree.ParseError as error:
        raise FileError(f"is no XML: {error}") from None


def _beside(path: Path, name: str) -> Path:
    """Path of a file that a list names, which may not be outside of the list's folder."""
    other = PurePosixPath(name)
    if not name or other.is_absolute() or ".." in other.parts:
        raise FileError(f"lists the file {name!r}, which is not below its own folder: put it there")
    return path.parent / other
