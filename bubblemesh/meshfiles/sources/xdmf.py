"""XDMF: grids, which may refer to each other and have times; the numbers are in HDF5 files or in the file itself."""

import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from bubblemesh.arrays import Integers
from bubblemesh.errors import FileError
from bubblemesh.files import opened, read_bytes
from bubblemesh.meshfiles.sources.source import Block, Data, Source, reals
from bubblemesh.messages import shown

Element = ElementTree.Element

INCLUDES = tuple(f"{{http://www.w3.org/{year}/XInclude}}include" for year in (2001, 2003))  # meshio writes the second
PARTS = ("Topology", "Geometry", "Attribute", "Time", "Information", *INCLUDES)  # elements of grids that are read
POINTER = re.compile(r"xpointer\((?P<path>/.*?)(/\*\[(?P<names>.*)\])?\)")
STEP = re.compile(r"(/{1,2})(\w+)((?:\[[^\]]*\])*)")
CONDITION = re.compile(r"\[\s*(?:@(\w+)\s*=\s*['\"]([^'\"]*)['\"]|(\d+))\s*\]")
# meshio's names of the kinds of cells, by those of XDMF in small letters, and their numbers in mixed lists.
KINDS = {
    "polyvertex": ("vertex", 0x1),
    "polyline": ("line", 0x2),
    "triangle": ("triangle", 0x4),
    "quadrilateral": ("quad", 0x5),
    "tetrahedron": ("tetra", 0x6),
    "pyramid": ("pyramid", 0x7),
    "wedge": ("wedge", 0x8),
    "hexahedron": ("hexahedron", 0x9),
    "edge_3": ("line3", 0x22),
    "triangle_6": ("triangle6", 0x24),
    "tri_6": ("triangle6", 0x24),
    "quadrilateral_9": ("quad9", 0x23),
    "quad_9": ("quad9", 0x23),
    "quadrilateral_8": ("quad8", 0x25),
    "quad_8": ("quad8", 0x25),
}
WIDTHS = {"vertex": 1, "line": 2, "triangle": 3, "quad": 4, "tetra": 4, "pyramid": 5, "wedge": 6, "hexahedron": 8}
WIDTHS |= {"line3": 3, "triangle6": 6, "quad9": 9, "quad8": 8}
COUNTED = {"vertex", "line"}  # in a mixed list the number of their nodes follows the kind
FACES = ("triangle", "triangle6", "quad", "quad8", "quad9")


def read_xdmf(path: Path) -> Source:
    """The first mesh of faces in the file, with all of its data at the last time; FileError if it cannot be read."""
    try:
        root = ElementTree.fromstring(read_bytes(path))
    except ElementTree.ParseError as error:
        raise FileError(f"is no XML: {error}") from None
    grids, notes = _latest(root)
    shapes = [(grid, _part(root, grid, "Topology"), _part(root, grid, "Geometry")) for grid in grids]
    whole = [
        (grid, topology, geometry)
        for grid, topology, geometry in shapes
        if topology is not None and geometry is not None
    ]
    others = _not_read(grids)
    if len(whole) < len(grids) and others:
        raise FileError(f"holds a grid without nodes or cells, but with what is not read: {others}")
    if not whole:
        raise FileError("holds no grid with nodes and cells")
    notes = (*notes, f"parts of grids are left out: {others}") if others else notes
    base = next((each for each in whole if _has_faces(each[1])), whole[0])
    numbers = _Numbers(path)
    points = numbers.of(base[2])
    if points.ndim == 1:
        points = points.reshape(-1, 2 if base[2].get("GeometryType", base[2].get("Type")) == "XY" else 3)
    mine = [(grid, topology) for grid, topology, geometry in whole if _same(geometry, base[2])]
    return _assembled(numbers, points, mine, _names(root), notes)


def _not_read(grids: Iterable[Element]) -> str:
    """Names of parts of grids that are not read."""
    return shown(", ".join(dict.fromkeys(part.tag for grid in grids for part in grid if part.tag not in PARTS)))


def _assembled(
    numbers: "_Numbers",
    points: Data,
    grids: list[tuple[Element, Element]],
    names: dict[str, Any],
    notes: tuple[str, ...],
) -> Source:
    """Source of grids with the same points, each with its topology."""
    blocks: list[list[Block]] = []
    topologies: list[Element] = []
    point_data: dict[str, Data] = {}
    cell_data: dict[str, dict[int, Data]] = {}
    for grid, topology in grids:
        at = next((k for k, known in enumerate(topologies) if _same(known, topology)), len(topologies))
        if at == len(topologies):
            topologies.append(topology)
            blocks.append(_blocks(topology, numbers.of(topology)))
        for attribute in grid.iterfind("Attribute"):
            name, center = attribute.get("Name", "data"), attribute.get("Center", "Node")
            if len(attribute.findall("DataItem")) != 1:
                raise FileError(
                    f"its data {name} is no plain array: write it at the nodes of the mesh (write_function)"
                )
            values = numbers.of(attribute)
            values = values[:, 0] if values.ndim == 2 and values.shape[1] == 1 else values
            if center == "Node" and len(values) == len(points):
                point_data[name] = values
            elif center == "Cell" and len(values) == sum(len(block.data) for block in blocks[at]):
                cell_data.setdefault(name, {})[at] = values
            else:
                raise FileError(f"its data {name} has another length than the nodes or cells that it is of")
    named = {name: _per_block(blocks, values) for name, values in cell_data.items()}
    return Source(points, [block for group in blocks for block in group], point_data, named, names, notes=notes)


def _per_block(blocks: list[list[Block]], values: dict[int, Data]) -> list[Data]:
    """Values of each block; those of a topology without the data are NaN."""
    found = []
    for at, group in enumerate(blocks):
        counts = [len(block.data) for block in group]
        whole = values.get(at, np.full(sum(counts), np.nan))
        found += np.split(whole, np.cumsum(counts)[:-1])
    return found


def _latest(root: Element) -> tuple[list[Element], tuple[str, ...]]:
    """Grids that are not collections, and notes; of several times, those of the last one."""
    found, notes = [], []
    queue = list(root.iterfind("Domain/Grid"))
    while queue:
        grid = queue.pop(0)
        if grid.get("GridType", "Uniform") != "Collection":
            found.append(grid)
            continue
        inner = grid.findall("Grid")
        if grid.get("CollectionType") != "Temporal":
            raise FileError("holds a grid in several pieces: write it as one")
        times = [_time(each) for each in inner]
        if inner:
            last = max(range(len(inner)), key=lambda k: (times[k], k))
            queue.insert(0, inner[last])
        if len(inner) > 1:
            notes.append(f"holds {len(inner)} times: the last one, {times[last]:g}, is read")
    return found, tuple(dict.fromkeys(notes))


def _time(grid: Element) -> float:
    time = grid.find("Time")
    return 0.0 if time is None else float(reals([time.get("Value", "0")], "times")[0])


def _part(root: Element, grid: Element, name: str) -> Element | None:
    """The topology or geometry of a grid: its own, or one that it includes or to which it refers."""
    own = grid.find(name)
    if own is not None:
        reference = own.get("Reference")
        if reference is None:
            return own
        return _pointed(root, (own.text or "").strip() if reference == "XML" else reference)
    for include in (part for part in grid if part.tag in INCLUDES):
        pointer = include.get("xpointer", "")
        if include.get("href"):
            raise FileError(f"includes another file, {include.get('href')}: write all into one")
        found = POINTER.fullmatch(pointer)
        target = None if found is None else _pointed(root, found["path"])
        if found is None or target is None:
            raise FileError(f"includes {pointer!r}, which is nowhere in it")
        if found["names"] is None and target.tag == name:
            return target
        if found["names"] is None or name in found["names"]:
            part = target.find(name)
            if part is not None:
                return part
    return None


def _pointed(root: Element, path: str) -> Element | None:
    """The element at a path such as /Xdmf/Domain/Grid[@GridType='Uniform'][1]."""
    steps = STEP.findall(path)
    if "".join(map("".join, steps)) != path:
        raise FileError(f"refers to {path!r}, which is not understood")
    within = ElementTree.Element("document")
    within.append(root)
    found: list[Element] = [within]
    for slashes, name, conditions in steps:
        groups = [list(each.iter(name)) if slashes == "//" else each.findall(name) for each in found]
        found = [each for group in groups for each in _chosen(group, conditions)]
    return found[0] if found else None


def _chosen(elements: Sequence[Element], conditions: str) -> list[Element]:
    """The elements that meet all conditions, applied from left to right."""
    chosen = list(elements)
    for key, value, number in CONDITION.findall(conditions):
        chosen = [each for each in chosen if each.get(key) == value] if key else chosen[int(number) - 1 : int(number)]
    return chosen


def _kind(topology: Element) -> str:
    return (topology.get("TopologyType") or topology.get("Type") or "").lower()


def _has_faces(topology: Element) -> bool:
    kind = _kind(topology)
    return kind == "mixed" or KINDS.get(kind, ("", 0))[0] in FACES


def _same(one: Element, other: Element) -> bool:
    """Whether two elements hold the same numbers: they are identical, or name the same data set in a file."""
    if one is other:
        return True
    items = [each.find("DataItem") for each in (one, other)]
    return (
        all(item is not None and item.get("Format") == "HDF" for item in items)
        and len({(item.text or "").strip() for item in items if item is not None}) == 1
    )


def _blocks(topology: Element, cells: Data) -> list[Block]:
    kind = _kind(topology)
    if kind == "mixed":
        return _mixed(cells.ravel().astype(np.int64).tolist())
    if kind not in KINDS:
        raise FileError(f"holds cells of the kind {topology.get('TopologyType')!r}, which is not read")
    name = KINDS[kind][0]
    cells = cells.astype(np.int64)
    return [Block(name, cells if cells.ndim == 2 else cells.reshape(-1, WIDTHS[name]))]


def _mixed(numbers: list[int]) -> list[Block]:
    """Blocks from a list that has the kind of each cell before its nodes."""
    kinds = {number: name for name, number in KINDS.values()}
    found: list[tuple[str, list[list[int]]]] = []
    at = 0
    while at < len(numbers):
        name = kinds.get(numbers[at])
        if name is None:
            raise FileError(f"holds cells of the kind {numbers[at]}, which is not read")
        at += 2 if name in COUNTED else 1
        if not found or found[-1][0] != name:
            found.append((name, []))
        found[-1][1].append(numbers[at : at + WIDTHS[name]])
        at += WIDTHS[name]
    if found and len(found[-1][1][-1]) != WIDTHS[found[-1][0]]:
        raise FileError("its list of cells ends too early: the file is damaged")
    return [Block(name, np.array(cells, np.int64)) for name, cells in found]


def _names(root: Element) -> dict[str, Integers]:
    """Number and dimension of each named group, as meshio and this package write them."""
    for information in root.iter("Information"):
        try:
            tree = ElementTree.fromstring(information.text or "")
        except ElementTree.ParseError:
            continue
        if tree.tag == "main":
            entries: Iterable[Element] = tree.iterfind("map")
            return {each.get("key", ""): np.array([int(each.text or 0), int(each.get("dim", 0))]) for each in entries}
    return {}


class _Numbers:
    """Reader of the numbers of elements, from HDF5 files beside or the XML itself."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def of(self, element: Element) -> Data:
        """Numbers of the only item of an element."""
        item = element.find("DataItem")
        if item is None:
            raise FileError(f"its {element.tag} has no numbers")
        if item.get("ItemType", "Uniform") != "Uniform":
            raise FileError(f"its {element.tag} is a {item.get('ItemType')} of numbers: write them as they are")
        text = (item.text or "").strip()
        if item.get("Format", "XML") != "HDF":
            values = reals(text.split(), element.tag.lower())
            shape = [int(size) for size in item.get("Dimensions", "").split()]
            return values.reshape(shape) if shape and np.prod(shape) == len(values) else values
        name, _, inside = text.partition(":")
        return self._stored(name, inside)

    def _stored(self, name: str, inside: str) -> Data:
        import h5py

        with opened(self._path.parent / name) as stream, h5py.File(stream, "r") as file:
            part = file.get(inside)
            if not isinstance(part, h5py.Dataset):
                raise FileError(f"{name} has no numbers at {inside}")
            values: Data = part[()]
            return values
