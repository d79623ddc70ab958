"""SU2's own mesh format, with the names of its markers."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from bubblemesh.arrays import Integers
from bubblemesh.errors import FileError
from bubblemesh.files import read_bytes
from bubblemesh.meshfiles.sources.source import Block, Source, reals, require_length, wholes, with_named_edges

# Kinds of cells with the number of their nodes, by VTK's numbers.
KINDS = {3: ("line", 2), 5: ("triangle", 3), 9: ("quad", 4)}
PARALLEL = "SEND_RECEIVE"  # a marker of points that processes share

NONE = np.zeros((0, 2), np.int64)

Lines = list[bytes]


def read_su2(path: Path) -> Source:
    """Cells of a plane mesh, and its markers as sets of edges; FileError if it is not such a mesh, or is damaged."""
    cells: dict[str, list[Integers]] = {}
    markers: dict[str, Integers] = {}
    points, marker = None, ""
    for word, value, lines in _sections(read_bytes(path)):
        if (word == b"NDIME" and value != b"2") or (word == b"NZONE" and value != b"1"):
            raise FileError("is a mesh in space or of several zones: only one plane mesh is read")
        if word == b"NELEM":
            for kind, found in _cells(_counted(lines, value, "elements")).items():
                cells.setdefault(kind, []).append(found)
        elif word == b"NPOIN":
            rows = [line.split()[:2] for line in _counted(lines, value, "points")]
            points = reals(rows, "coordinates").reshape(-1, 2)
        elif word == b"MARKER_TAG":
            marker = value.decode("utf-8", "replace")
        elif word == b"MARKER_ELEMS" and marker != PARALLEL:
            markers[marker] = _cells(_counted(lines, value, f"edges of the marker {marker}")).get("line", NONE)
    if points is None or not cells:
        raise FileError("has no NPOIN or no NELEM: it is no mesh of SU2's format")
    faces = [Block(kind, np.concatenate(found)) for kind, found in cells.items()]
    return with_named_edges(points, faces, markers)


def _sections(content: bytes) -> Iterator[tuple[bytes, bytes, Lines]]:
    """Keyword, value and the lines that follow, without comments, of each section."""
    word = value = b""
    lines: Lines = []
    for line in content.splitlines():
        text = line.partition(b"%")[0].strip()
        if b"=" in text:
            yield word, value, lines
            word, value = (part.strip() for part in text.split(b"=", 1))
            word, lines = word.upper(), []
        elif text:
            lines.append(text)
    yield word, value, lines


def _counted(lines: Lines, value: bytes, what: str) -> Lines:
    """The first lines, as many as the number after a keyword; FileError if there are fewer."""
    count = int(wholes((value.split() or [b""])[:1], f"counts of {what}")[0])
    require_length(len(lines), count, what)
    return lines[: max(count, 0)]


def _cells(lines: Lines) -> dict[str, Integers]:
    """Nodes (m, k) of the cells of each kind."""
    by_kind: dict[bytes, list[list[bytes]]] = {}
    for line in lines:
        number, *nodes = line.split()
        by_kind.setdefault(number, []).append(nodes)
    found: dict[str, Integers] = {}
    for number, rows in by_kind.items():
        known = KINDS.get(int(wholes([number], "kinds of elements")[0]))
        if known is None:
            raise FileError(f"has elements of the kind {number.decode()}, which is none of a plane mesh")
        name, count = known
        if any(len(row) < count for row in rows):
            raise FileError(f"has a {name} with fewer than {count} nodes")
        found[name] = wholes([row[:count] for row in rows], "nodes of elements").reshape(-1, count)
    return found
