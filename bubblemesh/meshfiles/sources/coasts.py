"""Text formats of models of coasts: ADCIRC's fort.14, SCHISM's .gr3, SMS's .2dm."""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from bubblemesh.arrays import Integers
from bubblemesh.errors import FileError
from bubblemesh.files import read_bytes
from bubblemesh.meshfiles.sources.source import (
    Block,
    Data,
    Numbering,
    Source,
    reals,
    require_length,
    wholes,
    with_named_edges,
)

DEPTH, ELEVATION = "depth", "elevation"  # data at nodes
CELLS = {3: "triangle", 4: "quad"}  # by the number of nodes
SMS_CELLS = {
    b"E3T": ("triangle", 3),
    b"E4Q": ("quad", 4),
    b"E6T": ("triangle6", 6),
    b"E8Q": ("quad8", 8),
    b"E9Q": ("quad9", 9),
}
LABEL = re.compile(rb"boundary \d+: (.+)")  # in the remarks that this package writes
ISLANDS, WEIRS, PAIRS = (1, 11, 21), (3, 13, 23), (4, 24, 5, 25)  # numbers of boundaries
OPEN, LAND, ISLAND, WEIR = "open", "land", "island", "weir"
GROUP = "material"

Rows = Iterator[list[bytes]]


def read_grid(path: Path) -> Source:
    """Cells with the depth at their nodes, and the boundaries as edges with their labels, or the names of their kinds.

    FileError if the file is not one of ADCIRC or SCHISM, or is damaged.
    """
    lines = read_bytes(path).splitlines()
    require_length(len(lines), 2, "lines")
    counts = wholes(lines[1].split()[:2], "counts of elements and nodes").tolist()
    if len(counts) < 2 or min(counts) < 0:
        raise FileError("has no counts of elements and nodes in its second line: it is no grid of ADCIRC or SCHISM")
    elements, nodes = counts
    require_length(len(lines) - 2, nodes + elements, "lines of nodes and elements")
    table = reals(_rows(lines[2 : 2 + nodes], 4, "node"), "nodes").reshape(-1, 4)
    index = Numbering(table[:, 0].astype(np.int64))
    faces = list(_cells(lines[2 + nodes : 2 + nodes + elements], index))
    edges, opened = _boundaries(iter(lines[2 + nodes + elements :]), index)
    return with_named_edges(table[:, 1:3], faces, edges, point_data={DEPTH: table[:, 3]}, open_sets=opened)


def _rows(lines: list[bytes], width: int, what: str) -> list[list[bytes]]:
    """The first words of each line."""
    rows = [line.split()[:width] for line in lines]
    if any(len(row) < width for row in rows):
        raise FileError(f"has a {what} with fewer than {width} numbers in its line")
    return rows


def _cells(lines: list[bytes], index: Numbering) -> Iterator[Block]:
    """Blocks of the elements by the number of their nodes."""
    by_width: dict[bytes, list[list[bytes]]] = {}
    for row in map(bytes.split, lines):
        by_width.setdefault(row[1] if len(row) > 1 else b"", []).append(row[2:])
    for word, rows in by_width.items():
        width = int(wholes([word or b"0"], "numbers of nodes of elements")[0])
        if width not in CELLS:
            raise FileError(f"has elements of {width} nodes: only those of 3 and 4 are plane cells")
        if any(len(row) < width for row in rows):
            raise FileError(f"has an element with fewer than {width} nodes")
        nodes = wholes([row[:width] for row in rows], "nodes of elements").reshape(-1, width)
        yield Block(CELLS[width], index.places(nodes))


def _boundaries(lines: Iterator[bytes], index: Numbering) -> tuple[dict[str, Integers], tuple[str, ...]]:
    """Edges (m, 2) of each boundary's label, and the labels of open ones; empty if the file ends before."""
    found: dict[str, list[Integers]] = {}
    open_labels = dict[str, None]()
    for opened in (True, False):
        count = _count(next(lines, b""))
        next(lines, b"")  # the number of nodes of all boundaries
        for _ in range(count):
            head = next(lines, None)
            if head is None:
                raise FileError("ends too early: a boundary is missing")
            words = wholes(head.split()[: 1 if opened else 2], "numbers of boundary nodes").tolist()
            words += [0, 0]
            for label, edges in _boundary(lines, words[0], None if opened else words[1], index):
                own = LABEL.search(head)
                name = own[1].decode("utf-8", "replace").strip() if own else label
                found.setdefault(name, []).append(edges)
                open_labels.update({name: None} if opened else {})
    return {name: np.concatenate(edges) for name, edges in found.items()}, tuple(open_labels)


def _count(line: bytes) -> int:
    words = line.split()[:1]
    return int(wholes(words, "numbers of boundaries")[0]) if words else 0


def _boundary(lines: Iterator[bytes], count: int, kind: int | None, index: Numbering) -> Iterator[tuple[str, Integers]]:
    """Edges of a boundary with ``count`` nodes, and the name of its kind; for inner barriers, those of both sides."""
    rows = [line.split() for _, line in zip(range(count), lines, strict=False)]
    require_length(len(rows), count, "nodes of a boundary")
    sides = 2 if kind in PAIRS else 1
    if any(len(row) < sides for row in rows):
        raise FileError("has a boundary with an empty line in place of a node")
    nodes = index.places(wholes([row[:sides] for row in rows], "boundary nodes").reshape(-1, sides))
    name = OPEN if kind is None else ISLAND if kind in ISLANDS else WEIR if kind in (*WEIRS, *PAIRS) else LAND
    for along in nodes.T:
        if kind in ISLANDS and len(along) and along[0] != along[-1]:
            along = np.append(along, along[0])
        yield name, np.column_stack([along[:-1], along[1:]])


def read_sms(path: Path) -> Source:
    """Cells with the numbers of their materials, nodes with their height, and the edges of node strings.

    FileError if the file is not a mesh of SMS, or is damaged.
    """
    cells: dict[bytes, list[list[bytes]]] = {}
    nodes: list[list[bytes]] = []
    strings: list[bytes] = []
    for line in read_bytes(path).splitlines():
        word, *rest = line.split() or [b""]
        if word in SMS_CELLS:
            cells.setdefault(word, []).append(rest)
        elif word == b"ND":
            nodes.append(rest)
        elif word == b"NS":
            strings += [*rest, b"|"]
    if not nodes or not cells:
        raise FileError("has no ND or no E3T and E4Q: it is no mesh of SMS")
    if any(len(row) < 4 for row in nodes):
        raise FileError("has a node with fewer than 4 numbers in its line")
    table = reals([row[:4] for row in nodes], "nodes").reshape(-1, 4)
    index = Numbering(table[:, 0].astype(np.int64))
    blocks, groups = [], list[Data]()
    for word, rows in cells.items():
        kind, width = SMS_CELLS[word]
        if any(len(row) < width + 1 for row in rows):
            raise FileError(f"has a cell {word.decode()} with fewer than {width} nodes")
        blocks.append(Block(kind, index.places(wholes([row[1 : width + 1] for row in rows], "nodes of cells"))))
        materials = [(row[width + 1 : width + 2] or [b"0"])[0] for row in rows]
        groups.append(reals(materials, "materials").astype(np.int64))
    edges, numbers = _strings(strings, index)
    data = {GROUP: [*groups, numbers]}
    return Source(table[:, 1:3], [*blocks, Block("line", edges)], {ELEVATION: table[:, 3]}, data)


def _strings(words: list[bytes], index: Numbering) -> tuple[Integers, Integers]:
    """Edges (m, 2) of node strings, whose last node is negative, and the number (m,) of the string of each edge.

    The number of a string may follow in the same line; otherwise strings are counted.
    """
    edges, numbers = [np.zeros((0, 2), np.int64)], [np.zeros(0, np.int64)]
    chain: list[int] = []
    count = 0
    places = iter(enumerate(words))
    for at, word in places:
        if word == b"|":
            continue
        node = int(wholes([word], "nodes of node strings")[0])
        chain.append(abs(node))
        if node < 0:
            count += 1
            own = words[at + 1]
            number = int(own) if own.isdigit() else count
            if own != b"|":
                next(places)
            along = index.places(np.array(chain))
            edges.append(np.column_stack([along[:-1], along[1:]]))
            numbers.append(np.full(len(along) - 1, number))
            chain = []
    return np.concatenate(edges), np.concatenate(numbers)
