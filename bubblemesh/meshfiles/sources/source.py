"""Content of a mesh file, whatever its format."""

from collections.abc import Mapping, Sequence
from dataclasses import field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bubblemesh.arrays import Integers
from bubblemesh.errors import FileError
from bubblemesh.meshes.edges import find_keys
from bubblemesh.messages import shown
from bubblemesh.records import record

Data = NDArray[Any]
NO_SETS: Mapping[str, Any] = {}
NO_CELLS = "gmsh:bounding_entities"  # called a set by meshio, but holds numbers of Gmsh's entities


@record
class Block:
    """Cells (m, k) of one kind, by meshio's name of it."""

    type: str
    data: Integers


@record
class Source:
    """Nodes, blocks of cells, and data of a file; the fields have the names and the forms of a `meshio.Mesh`."""

    points: Data  # (n, 2) or (n, 3)
    cells: Sequence[Block]
    point_data: Mapping[str, Data] = field(default_factory=dict)  # (n,) or (n, k)
    cell_data: Mapping[str, Sequence[Data]] = field(default_factory=dict)  # (m,) or (m, k) for each block
    field_data: Mapping[str, Any] = field(default_factory=dict)  # number and dimension of each named group
    cell_sets: Mapping[str, Sequence[Any]] = field(default_factory=dict)  # cells of each block, by the set's name
    cell_tags: Mapping[int, Sequence[str]] = field(default_factory=dict)  # names of each group, by its number
    open_sets: tuple[str, ...] = ()  # names of sets of edges that are open boundaries of coasts
    matching: Sequence[Integers] = ()  # for each pair of periodic sides, the matching nodes (k, 2)
    node_sets: tuple[str, ...] = ()  # names of sets of nodes, which are not read
    geographic: bool = False  # whether the file says that points are longitudes and latitudes
    notes: tuple[str, ...] = ()  # on choices of the reader, such as the last of several times

    @classmethod
    def of(cls, mesh: Any) -> "Source":
        """Source of a `meshio.Mesh`; FileError if one of its sets has cells that do not exist."""
        blocks = [Block(block.type, block.data) for block in mesh.cells]
        sets = {name: chosen for name, chosen in mesh.cell_sets.items() if name != NO_CELLS}
        for name, chosen in sets.items():
            if not _fits(chosen, blocks):
                raise FileError(f"its set {shown(repr(name))} has cells that are not there: the file is damaged")
        tags = getattr(mesh, "cell_tags", {})  # of MED files
        named = {*mesh.point_sets, *(name for names in getattr(mesh, "point_tags", {}).values() for name in names)}
        matching = [nodes for dimension, _, _, nodes in mesh.gmsh_periodic or () if dimension == 1]
        data = mesh.points, blocks, mesh.point_data, mesh.cell_data, mesh.field_data
        return cls(*data, sets, tags, matching=matching, node_sets=tuple(sorted(named)))


class Numbering:
    """Index of the nodes, or other items, of a file by the numbers (n,) that the file gives them."""

    def __init__(self, numbers: Integers, what: str = "node") -> None:
        self._what = what
        self._order = np.argsort(numbers, kind="stable")
        self._sorted = numbers[self._order]

    def __len__(self) -> int:
        return len(self._order)

    def places(self, asked: Integers) -> Integers:
        """Indices of the items with the given numbers, in an array of the same shape; FileError for a missing one."""
        found = find_keys(self._sorted, asked) if len(self) else np.full(asked.shape, -1)
        missing = asked[found < 0]
        if missing.size:
            raise FileError(f"names the {self._what} {missing[0]}, which is not there: the file is damaged")
        return self._order[found]


def _fits(chosen: Sequence[Any], blocks: Sequence[Block]) -> bool:
    """Whether a set has numbers of cells, or None, for each block."""
    if len(chosen) != len(blocks):
        return False
    rows = [(np.asarray(some), len(block.data)) for some, block in zip(chosen, blocks, strict=True) if some is not None]
    return all(len(some) == 0 or (some.dtype.kind in "iu" and 0 <= some.min() <= some.max() < n) for some, n in rows)


def with_named_edges(
    points: Data,
    faces: Sequence[Block],
    edges: Mapping[str, Integers],
    face_sets: Mapping[str, Sequence[Integers]] = NO_SETS,
    **more: Any,
) -> Source:
    """Source with blocks of faces, of which there may be named sets, and edges (m, 2) as named sets."""
    none: list[Integers | None] = [None] * len(faces)
    ends = np.cumsum([0, *map(len, edges.values())])
    spans = dict(zip(edges, pairwise(ends.tolist()), strict=True))
    sets: dict[str, list[Any]] = {name: [*chosen, None] for name, chosen in face_sets.items()}
    sets |= {name: [*face_sets.get(name, none), np.arange(*span)] for name, span in spans.items()}
    lines = Block("line", np.concatenate([np.zeros((0, 2), np.int64), *edges.values()]))
    return Source(points, [*faces, lines], cell_sets=sets, **more)


def reals(words: Sequence[Any], what: str) -> Data:
    """Real numbers (n,) from words; FileError if one is not a number."""
    try:
        return np.array(words, float)
    except ValueError as error:
        raise FileError(f"its {what} are no numbers ({error})") from None


def wholes(words: Sequence[Any], what: str) -> Integers:
    """Whole numbers (n,) from words; FileError if one is not a whole number."""
    try:
        return np.array(words, np.int64)
    except (ValueError, OverflowError) as error:
        raise FileError(f"its {what} are no whole numbers ({error})") from None


def require_length(found: int, needed: int, what: str) -> None:
    """Check that a file holds as many items as it says; FileError if not."""
    if found < needed:
        raise FileError(f"it ends too early: it has {found} of {needed} {what}")
