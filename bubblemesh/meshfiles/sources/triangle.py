"""Meshes of the Triangle program: nodes in a ``.node`` file, triangles in an ``.ele`` file beside it."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import FileError, prefixed
from bubblemesh.files import read_bytes
from bubblemesh.meshfiles.sources.source import Block, Data, Source, reals, require_length, wholes

ATTRIBUTE, MARKER = "attribute", "marker"
KINDS = {3: "triangle", 6: "triangle6"}
AS_VTK = [0, 1, 2, 5, 3, 4]  # nodes halfway: Triangle names each by the corner across


class _Table(NamedTuple):
    """Further numbers of the first line of a file, and the rows that it announces."""

    head: list[int]
    rows: Floats


def read_pair(path: Path) -> Source:
    """Triangles with the data in both files; FileError if one of them is damaged, or not plane.

    Attributes of nodes, their marker, and attributes of triangles become data by these names, with numbers from the
    second attribute on.
    """
    nodes = _table(path.with_suffix(".node"), "nodes")
    dimension, attributes, markers = [*nodes.head, *[2, 0, 0][len(nodes.head) :]][:3]
    if dimension != 2:
        raise FileError(f"has nodes of {dimension} dimensions: only meshes of the plane are read")
    if min(attributes, markers) < 0:
        raise FileError("has a negative number of attributes or markers")
    require_length(nodes.rows.shape[1], 3 + attributes + markers, "numbers in each row of nodes")
    cells = _table(path.with_suffix(".ele"), "triangles")
    corners = cells.head[0] if cells.head else 3
    if corners not in KINDS:
        raise FileError(f"has cells of {corners} nodes: Triangle has triangles of 3 or 6")
    require_length(cells.rows.shape[1], 1 + corners, "numbers in each row of triangles")
    number = cells.rows[:, 1 : 1 + corners] - nodes.rows[:1, :1]  # numbers begin with that of the first node, 0 or 1
    if (nodes.rows[:, 0] != nodes.rows[0, 0] + np.arange(len(nodes.rows))).any() or (number != np.rint(number)).any():
        raise FileError("does not number its nodes one after the other by whole numbers")
    triangles = number.astype(np.int64)[:, AS_VTK[:corners]]
    beside = nodes.rows[:, 3 : 3 + attributes + markers]
    point_data = _named(beside[:, :attributes], ATTRIBUTE) | _named(beside[:, attributes:], MARKER)
    cell_data = {name: [values] for name, values in _named(cells.rows[:, 1 + corners :], ATTRIBUTE).items()}
    return Source(nodes.rows[:, 1:3], [Block(KINDS[corners], triangles)], point_data, cell_data)


def _named(columns: Floats, name: str) -> dict[str, Data]:
    """Columns (n, k) by their names."""
    return {f"{name}-{k}" if k > 1 else name: column for k, column in enumerate(columns.T, start=1)}


def _table(path: Path, what: str) -> _Table:
    """Rows of a file, as many as its first line announces; FileError if they are missing or not numbers."""
    with prefixed(path.name):
        lines = [words for line in read_bytes(path).splitlines() if (words := line.partition(b"#")[0].split())]
        if not lines:
            raise FileError(f"has no line with the number of {what}")
        count, *head = wholes(lines[0], f"numbers of {what}").tolist()
        if count < 1:
            raise FileError(f"has no {what}")
        rows = lines[1 : 1 + count]
        require_length(len(rows), count, what)
        if len(set(map(len, rows))) > 1:
            raise FileError("has rows of unequal length")
        return _Table(head, reals(rows, what).reshape(count, -1))
