"""Telemac's SERAFIN files, single and double precision, big-endian or little: a mesh with its data of the last time.

The labels are those of the file of boundary conditions of the same name, if that is beside it.
"""

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Integers
from bubblemesh.errors import FileError
from bubblemesh.files import read_bytes
from bubblemesh.meshes.edges import directed_sides, one_sided
from bubblemesh.meshfiles.sources.source import Block, Data, Source, require_length, wholes, with_named_edges

TITLE, NAME = 80, 16  # bytes
CELLS = {3: "triangle", 4: "quad"}
MOST_VARIABLES = 1000
REMARK = re.compile(rb"# (?:open|land|island): (.+)")  # as this package writes it
OPEN, LAND = "open", "land"
WALL = 2  # code of the depth at a node of a wall
NODE = 11  # column of a node's number


class _Records:
    """Records of a sequential file of Fortran, one after the other, each with its length before and after it."""

    def __init__(self, content: bytes) -> None:
        self.content, self.place = content, 0
        self.order = next((order for order in "><" if content[:4] == np.array(TITLE, f"{order}i4").tobytes()), "")
        if not self.order:
            raise FileError("does not begin with a title of 80 letters: it is no SERAFIN file")

    @property
    def left(self) -> int:
        """Number of bytes that are left."""
        return len(self.content) - self.place

    def next(self, size: int | None = None) -> bytes:
        """The next record; FileError if it is missing, or not of the given size."""
        start = self.place + 4
        if start > len(self.content):
            raise FileError("ends too early: a record is missing")
        length = int(np.frombuffer(self.content, f"{self.order}i4", 1, self.place)[0])
        end = start + length
        ends = self.content[end : end + 4]
        if length < 0 or ends != self.content[self.place : start] or size not in (None, length):
            raise FileError("has a record whose length is not what it should be: the file is damaged")
        self.place = end + 4
        return self.content[start:end]

    def integers(self, count: int | None = None) -> Integers:
        """The next record as whole numbers."""
        record = self.next(None if count is None else 4 * count)
        if len(record) % 4:
            raise FileError("has a record whose length is not what it should be: the file is damaged")
        return np.frombuffer(record, f"{self.order}i4").astype(np.int64)


def read_serafin(path: Path) -> Source:
    """Cells, data at nodes, and labelled edges of the boundary; FileError if the file is not 2D, or is damaged."""
    records = _Records(read_bytes(path))
    records.next(TITLE)
    variables = int(records.integers(2).sum())
    if not 0 <= variables <= MOST_VARIABLES:
        raise FileError(f"has {variables} variables: the file is damaged")
    names = [records.next(2 * NAME)[:NAME].decode("latin-1").strip() for _ in range(variables)]
    settings = records.integers(10).tolist()
    if settings[6] > 1:
        raise FileError(f"has {settings[6]} levels: only results in 2D are read")
    if settings[9] == 1:
        records.next()  # the date
    elements, nodes, width, _ = records.integers(4).tolist()
    if width not in CELLS or min(elements, nodes) < 0:
        raise FileError(f"has cells of {width} nodes: only those of 3 and 4 are plane cells")
    cells = records.integers(elements * width).reshape(-1, width) - 1
    if cells.size and (cells.min() < 0 or cells.max() >= nodes):
        raise FileError("a cell has a node that is not there: the file is damaged")
    records.integers(nodes)
    x, y = (_reals(records, nodes) for _ in range(2))
    points = np.column_stack([x + settings[2], y + settings[3]])
    data, notes = _last(records, names, nodes)
    faces = [Block(CELLS[width], cells)]
    beside = path.with_suffix(".cli")
    if not beside.is_file():
        return with_named_edges(points, faces, {}, point_data=data, notes=notes)
    ends = _Nodes.of(read_bytes(beside), nodes)
    opened = tuple(label for label, is_open in zip(ends.labels, ends.opened, strict=True) if is_open)
    return with_named_edges(points, faces, _labelled(cells, ends), point_data=data, open_sets=opened, notes=notes)


def _reals(records: _Records, count: int) -> Data:
    """The next record as numbers (count,) of single or double precision."""
    record = records.next()
    size = len(record) // max(count, 1)
    if size not in (4, 8) or len(record) != size * count:
        raise FileError("has a record whose length is not what it should be: the file is damaged")
    return np.frombuffer(record, f"{records.order}f{size}").astype(float)


def _last(records: _Records, names: list[str], nodes: int) -> tuple[dict[str, Data], tuple[str, ...]]:
    """Data of the last time, by names in lower case, and a note if there are several times."""
    values: list[Data] = []
    times = 0
    while records.left:
        records.next()
        values = [_reals(records, nodes) for _ in names]
        times += 1
    data = {name.lower(): each for name, each in zip(names, values, strict=False)}
    return data, (f"has data of {times} times: the last one is taken",) if times > 1 else ()


class _Nodes(NamedTuple):
    """Labels of boundary nodes."""

    labels: tuple[str, ...]
    of_node: Integers  # (n,): index into the labels, -1 for others
    opened: tuple[bool, ...]

    @classmethod
    def of(cls, content: bytes, count: int) -> "_Nodes":
        """Labels by the lines of a file of boundary conditions."""
        names: dict[str, bool] = {}
        of_node = np.full(count, -1)
        for line in content.splitlines():
            words = line.split()
            if not words:
                continue
            require_length(len(words), NODE + 1, "numbers in a line of the .cli file")
            code, number = wholes([words[0], words[NODE]], "codes of the .cli file").tolist()
            if not 1 <= number <= count:
                raise FileError("the .cli file names a node that is not there: it is of another mesh")
            remark = REMARK.search(line)
            name = remark[1].decode("utf-8", "replace").strip() if remark else LAND if code == WALL else OPEN
            names.setdefault(name, code != WALL)
            of_node[number - 1] = list(names).index(name) if len(names) > 1 else 0
        return cls(tuple(names), of_node, tuple(names.values()))


def _labelled(cells: Integers, nodes: _Nodes) -> dict[str, Integers]:
    """Edges (m, 2) of each label: that of their nodes; if the nodes have different ones, the closed one."""
    triangles = cells[:, :3] if cells.shape[1] == 3 else np.vstack([cells[:, :3], cells[:, [0, 2, 3]]])
    sides = directed_sides(triangles)
    rim = sides[one_sided(sides, len(nodes.of_node))]
    first, second = nodes.of_node[rim].T
    opened = np.array([*nodes.opened, False])  # the last one is for nodes without a line
    label = np.where(opened[first] & ~opened[second], second, first)
    return {name: rim[label == k] for k, name in enumerate(nodes.labels) if (label == k).any()}
