"""Meshes of the Triangle program: nodes in a ``.node`` file, triangles in an ``.ele`` file beside it.

Boundary markers are in a third file, ``.edge`` or ``.poly``, if Triangle was asked to write one: 0 is that of edges
inside, and 1 that of edges of the boundary, if they are on no segment with another one
(https://www.cs.cmu.edu/~quake/triangle.markers.html).
"""

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.errors import CaseError, FileError, prefixed
from bubblemesh.meshes.edges import find_sides
from bubblemesh.meshfiles.groups import LARGEST_TAG
from bubblemesh.meshfiles.sources.source import Block, Data, Source, with_named_edges
from bubblemesh.readers.features import text_of_number
from bubblemesh.readers.triangle_rows import NumberedRow, numbered_rows, section_head, section_rows

ATTRIBUTE, MARKER = "attribute", "marker"
KINDS = {3: "triangle", 6: "triangle6"}
AS_VTK = [0, 1, 2, 5, 3, 4]  # nodes halfway: Triangle names each by the corner across
SAME_PLACE = 1e-9  # of the extent

Groups = dict[str, Integers]


class _Table(NamedTuple):
    """Rows (n, k) of a section of a file, and the line (n,) of each."""

    lines: Integers
    rows: Floats


class NumberedNodes(NamedTuple):
    """Nodes (n, 2), and the number of the first one; the others follow one after the other."""

    points: Floats
    first: int

    def places(self, table: _Table, columns: slice) -> Integers:
        """Indices (n, k) of the nodes that some columns of a table name; FileError if one is not there."""
        named = table.rows[:, columns]
        index = named - self.first
        missing = ~((index >= 0) & (index < len(self.points)) & (index == np.rint(index)))
        for row, column in np.argwhere(missing):
            number, last = text_of_number(named[row, column]), self.first + len(self.points) - 1
            raise FileError(
                f"line {table.lines[row]}: there is no node {number}: they have the numbers {self.first} to {last}"
            )
        return index.astype(np.int64)


def read_pair(path: Path) -> Source:
    """Triangles with the data in all files of the mesh; FileError if one of them is damaged, or not plane.

    Attributes of nodes, their marker, and attributes of triangles become data by these names, with numbers from the
    second attribute on. The first attribute of triangles is their region, too, if it is a whole number everywhere, as
    that of Triangle's option -A. Edges with a marker other than 0 have a label.
    """
    with _rows(path, ".node") as rows:
        nodes, point_data = _nodes(rows)
    with _rows(path, ".ele") as rows:
        cells, attributes = _triangles(rows, nodes)
    labels, notes = _labels(path, nodes, cells[:, :3])
    return with_named_edges(
        nodes.points,
        [Block(KINDS[cells.shape[1]], cells)],
        labels,
        {name: [triangles] for name, triangles in _regions(attributes).items()},
        point_data=point_data,
        cell_data={
            name: [values, np.full(sum(map(len, labels.values())), np.nan)]
            for name, values in _named(attributes, ATTRIBUTE).items()
        },
        notes=notes,
    )


@contextmanager
def _rows(path: Path, ending: str) -> Iterator[Iterator[NumberedRow]]:
    """Rows of the file of a mesh with this ending; errors within the block are FileErrors that name it."""
    file = path.with_suffix(ending)
    with nullcontext() if file == path else prefixed(file.name):
        try:
            yield numbered_rows(file)
        except CaseError as error:
            raise FileError(str(error)) from None


def _table(rows: Iterator[NumberedRow], count: int, columns: int, what: str) -> _Table:
    """Rows of a section, without further columns."""
    lines = list[int]()

    def numbers() -> Iterator[float]:
        for line, row in section_rows(rows, count, what, columns):
            lines.append(line)
            yield from row[:columns]

    table = np.fromiter(numbers(), float).reshape(-1, columns)  # as lists of numbers large files take much memory
    return _Table(np.array(lines, np.int64), table)


def _nodes(rows: Iterator[NumberedRow]) -> tuple[NumberedNodes, dict[str, Data]]:
    """Nodes of a file, and the data at them."""
    count, head = section_head(rows, "the number of nodes")
    dimension, attributes, markers = [*head, *[2, 0, 0][len(head) :]][:3]
    if count < 1:
        raise FileError("has no nodes")
    if dimension != 2:
        raise FileError(f"has nodes of {dimension} dimensions: only meshes of the plane are read")
    table = _table(rows, count, 3 + attributes + markers, "a node: its number, x, y, its attributes and marker")
    numbers = table.rows[:, 0]
    for row in np.flatnonzero(numbers != np.rint(numbers[0]) + np.arange(count)):
        raise FileError(
            f"line {table.lines[row]}: {text_of_number(numbers[row])} is not the number of the next node: it does not "
            "number its nodes one after the other by whole numbers"
        )
    data = _named(table.rows[:, 3 : 3 + attributes], ATTRIBUTE) | _named(table.rows[:, 3 + attributes :], MARKER)
    return NumberedNodes(table.rows[:, 1:3], int(numbers[0])), data


def _triangles(rows: Iterator[NumberedRow], nodes: NumberedNodes) -> tuple[Integers, Floats]:
    """Nodes (t, 3) or (t, 6) of the triangles of a file, in the order of VTK, and their attributes (t, k)."""
    count, head = section_head(rows, "the number of triangles")
    corners, attributes = [*head, *[3, 0][len(head) :]][:2]
    if count < 1:
        raise FileError("has no triangles")
    if corners not in KINDS:
        raise FileError(f"has cells of {corners} nodes: Triangle has triangles of 3 or 6")
    what = f"a triangle: its number, {corners} nodes and its attributes"
    table = _table(rows, count, 1 + corners + attributes, what)
    cells = nodes.places(table, slice(1, 1 + corners))
    return cells[:, AS_VTK[:corners]], table.rows[:, 1 + corners :]


def _named(columns: Floats, name: str) -> dict[str, Data]:
    """Columns (n, k) by their names."""
    return {f"{name}-{k}" if k > 1 else name: column for k, column in enumerate(columns.T, start=1)}


def _regions(attributes: Floats) -> Groups:
    """Triangles of each region, by the first of their attributes (t, k); none if that is not a whole number."""
    first = attributes[:, :1].ravel()
    return _by_number(first, "region") if _are_whole(first).all() else {}


def _are_whole(numbers: Floats) -> Booleans:
    return (np.abs(numbers) <= LARGEST_TAG) & (numbers == np.rint(numbers))


def _by_number(numbers: Floats, noun: str) -> Groups:
    """Indices of each of the numbers (n,), in ascending order, as groups without names are called."""
    different, counts = np.unique(numbers, return_counts=True)
    *members, _ = np.split(np.argsort(numbers, kind="stable"), np.cumsum(counts))
    return {f"{noun} {int(number)}": some for number, some in zip(different, members, strict=True)}


def _labels(path: Path, nodes: NumberedNodes, triangles: Integers) -> tuple[Groups, tuple[str, ...]]:
    """Edges (m, 2) of each marker other than 0, from the file that has any, and notes on what is left out.

    FileError if the file does not belong to the triangles (t, 3).
    """
    for ending, read in ((".edge", _marked_edges), (".poly", _marked_segments)):
        if path.with_suffix(ending).is_file():
            with _rows(path, ending) as rows:
                labels, notes = read(rows, nodes, triangles)
            if labels or notes:
                return labels, tuple(f"{path.with_suffix(ending).name} beside it {note}" for note in notes)
    return {}, ()


def _marked_edges(
    rows: Iterator[NumberedRow], nodes: NumberedNodes, triangles: Integers, what: str = "an edge"
) -> tuple[Groups, tuple[str, ...]]:
    """Edges (m, 2) of each marker other than 0 in the next section of a file."""
    count, head = section_head(rows, f"the number of {what.split()[1]}s")
    marked = min([*head, 0][0], 1)
    table = _table(rows, count, 3 + marked, f"{what}: its number, two nodes{' and its marker' if marked else ''}")
    edges, markers = nodes.places(table, slice(1, 3)), table.rows[:, 3:].ravel()
    one, other = (find_sides(triangles, len(nodes.points), pairs)[0] for pairs in (edges, edges[:, ::-1]))
    for row in np.flatnonzero(np.maximum(one, other) < 0):
        ends = " to ".join(map(text_of_number, table.rows[row, 1:3]))
        raise FileError(f"line {table.lines[row]}: there is no edge of the mesh from {ends}: is it of another mesh?")
    for row in np.flatnonzero(~_are_whole(markers)):
        raise FileError(f"line {table.lines[row]}: its marker {text_of_number(markers[row])} is no whole number")
    own = np.flatnonzero(markers)
    return {name: edges[own[some]] for name, some in _by_number(markers[own], "label").items()}, ()


def _marked_segments(
    rows: Iterator[NumberedRow], nodes: NumberedNodes, triangles: Integers
) -> tuple[Groups, tuple[str, ...]]:
    """Segments (m, 2) of each marker other than 0 in a file whose vertices are the nodes of the mesh.

    A file with vertices of its own is what Triangle began with, in which segments may be longer than edges: if one is,
    all are left out, with a note.
    """
    count, _ = section_head(rows, "the number of vertices")
    own = _table(rows, count, 3, "a vertex: its number, x and y")
    try:
        _require_places(own, nodes)
        return _marked_edges(rows, nodes, triangles, "a segment")
    except FileError as error:
        if count == 0:
            raise
        return {}, (f"has markers of other edges, which are left out; triangle -e writes those of the mesh: {error}",)


def _require_places(vertices: _Table, nodes: NumberedNodes) -> None:
    """Check that vertices are where the nodes with their numbers are; FileError if not."""
    index = nodes.places(vertices, slice(0, 1)).ravel()
    apart = np.abs(nodes.points[index] - vertices.rows[:, 1:3]).max(axis=1, initial=0)
    for row in np.flatnonzero(~(apart <= SAME_PLACE * np.ptp(nodes.points, axis=0).max())):
        number = text_of_number(vertices.rows[row, 0])
        raise FileError(f"line {vertices.lines[row]}: the node {number} is in another place")
