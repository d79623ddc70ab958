"""Meshes of Gmsh (.msh) in the versions 2.2, 4.0 and 4.1 of its format, as text and in binary form."""

import re
import shlex
from codecs import BOM_UTF8
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import FileError
from bubblemesh.files import read_bytes
from bubblemesh.meshfiles.groups import PARTITION
from bubblemesh.meshfiles.sources.freefem import is_freefem, read_freefem
from bubblemesh.meshfiles.sources.layers import GROUP
from bubblemesh.meshfiles.sources.msh_data import CORNERS, ELEMENTS, NODES, data_at
from bubblemesh.meshfiles.sources.msh_sections import (
    Binary,
    Form,
    Numbers,
    Section,
    Text,
    first_line,
    form_of,
    sections,
)
from bubblemesh.meshfiles.sources.source import Block, Data, Numbering, Source, wholes
from bubblemesh.messages import shown

AFFINE = re.compile(rb"^\s*Affine[^\n]*\n", re.MULTILINE)
SHIFT = 16  # numbers of the map from a periodic side to the other one
CURVE = 1  # dimension
NOWHERE = -1, -1  # not an entity

Entity = tuple[int, int]  # dimension and tag
Sections = defaultdict[str, list[Section]]  # by their names


class _Entities(NamedTuple):
    """Groups and parts of the entities of a file of version 4; entities outside of a partition have no part."""

    group: Mapping[Entity, int]
    part: Mapping[Entity, int]


class _Elements(NamedTuple):
    """Elements of one kind, and of one entity in version 4."""

    kind: str  # by meshio's name
    numbers: Integers  # (m,)
    nodes: Integers  # (m, k) by their numbers
    group: Integers  # (m,) 0 for none
    entity: Entity = NOWHERE


def read_msh(path: Path) -> Source:
    """Mesh of Gmsh or FreeFEM, whose files have the same ending, with its data; FileError if it cannot be read."""
    if is_freefem(path):
        return read_freefem(path)
    data = read_bytes(path).removeprefix(BOM_UTF8)
    form = form_of(data)
    found = Sections(list)
    for section in sections(data):
        found[section.name].append(section)
    for name in ("Nodes", "Elements"):
        if not found[name]:
            raise FileError(f"has no ${name}: it is cut off, or holds no mesh")
    entities = _entities(found, form)
    points, numbers = _nodes(found["Nodes"][0], form)
    nodes = Numbering(numbers)
    elements = list(_elements(found["Elements"][0], form, entities))
    cells = [Block(block.kind, _ordered(block.kind, nodes.places(block.nodes))) for block in elements]
    of_nodes, notes = data_at(found[NODES], form, nodes)
    of_elements, more = _data_of_elements(found, form, elements, entities)
    matching = [nodes.places(pairs) for section in found["Periodic"] for pairs in _periodic(section, form)]
    names = _names(found["PhysicalNames"])
    told = tuple(dict.fromkeys([*notes, *more]))
    return Source(points, cells, of_nodes, of_elements, names, matching=matching, notes=told)


def _data_of_elements(
    found: Sections, form: Form, elements: Sequence[_Elements], entities: _Entities
) -> tuple[dict[str, Sequence[Data]], list[str]]:
    """Data of each block of elements, with its groups and parts, and notes on what is not read."""
    counts = [len(block.numbers) for block in elements]
    numbers = np.concatenate([np.zeros(0, np.int64), *(block.numbers for block in elements)])
    of_all, notes = data_at(found[ELEMENTS], form, Numbering(numbers, "element"))
    data: dict[str, Sequence[Data]] = {name: np.split(each, np.cumsum(counts)[:-1]) for name, each in of_all.items()}
    if any(block.group.any() for block in elements):
        data[GROUP] = [block.group for block in elements]
    if entities.part:
        parts = [entities.part[block.entity] for block in elements]
        data[PARTITION] = [np.full(count, part) for count, part in zip(counts, parts, strict=True)]
    if found[CORNERS]:
        notes.append(f"data at the corners of each element (${CORNERS}) are left out")
    return data, notes


def _numbers(section: Section, form: Form) -> Numbers:
    """Numbers of a section; periodic sides are always text in version 2.2, and may have lines of words."""
    if section.name == "Periodic" and (form.version == "2.2" or not form.binary):
        return Text(AFFINE.sub(b"", section.body), section.name)
    return Binary(section.body, section.name, form) if form.binary else Text(section.body, section.name)


def _names(stored: Iterable[Section]) -> dict[str, Integers]:
    """Number and dimension of each named group."""
    found = {}
    for section in stored:
        for row in section.body.decode("utf-8", "replace").strip().splitlines()[1:]:
            words = shlex.split(row)
            if len(words) != 3:
                raise FileError(f"has a name of a group in a line {shown(repr(row))}, which is not as it should be")
            found[words[2]] = np.array([int(words[1]), int(words[0])])
    return found


def _entities(found: Sections, form: Form) -> _Entities:
    """Groups of all entities, and the part, from 0, of those cut by a partition."""
    group, part = dict[Entity, int](), dict[Entity, int]()
    for section in found["Entities"]:
        for entity, _, groups in _rows_of_entities(_numbers(section, form), form, cut=False):
            group[entity] = abs(groups[0]) if groups else 0
    for section in found["PartitionedEntities"]:
        numbers = _numbers(section, form)
        _, ghosts = numbers.sizes(2).tolist()
        numbers.ints(2 * ghosts)  # copies of cells of other parts
        for entity, first, groups in _rows_of_entities(numbers, form, cut=True):
            group[entity] = abs(groups[0]) if groups else 0
            part[entity] = first - 1
    return _Entities(group, part)


def _rows_of_entities(numbers: Numbers, form: Form, cut: bool) -> Iterator[tuple[Entity, int, list[int]]]:
    """Entities, the first part that contains each, and its groups, which are negative for a reversed entity."""
    for dimension, count in enumerate(numbers.sizes(4).tolist()):
        for _ in range(count):
            tag, first = int(numbers.ints(1)[0]), 0
            if cut:
                numbers.ints(2)  # its parent
                first = int(numbers.ints(int(numbers.sizes(1)[0]))[0])
            numbers.reals(3 if dimension == 0 and form.version == "4.1" else 6)  # its box
            groups = numbers.ints(int(numbers.sizes(1)[0])).tolist()
            if dimension > 0:
                numbers.ints(int(numbers.sizes(1)[0]))  # entities around it
            yield (dimension, tag), first, groups


def _nodes(section: Section, form: Form) -> tuple[Floats, Integers]:
    """Points (n, 3) and the numbers (n,) of nodes, in the order of the file."""
    if form.version == "2.2":
        first, body = first_line(section.body)
        rows, points = _numbers(section._replace(body=body), form).rows(_count(first, "nodes"), 3)
        return points, rows
    numbers = _numbers(section, form)
    blocks = int(numbers.sizes(2 if form.version == "4.0" else 4)[0])
    found = [(np.zeros((0, 3)), np.zeros(0, np.int64))]
    for _ in range(blocks):
        (dimension, _), parametric = _head(numbers, form)
        count = int(numbers.sizes(1)[0])
        width = 3 + (dimension if parametric else 0)
        if form.version == "4.0":
            tags, table = numbers.rows(count, width)
        else:
            tags, table = numbers.tags(count), numbers.reals(count * width).reshape(count, width)
        found.append((table[:, :3], tags))
    return np.concatenate([points for points, _ in found]), np.concatenate([tags for _, tags in found])


def _head(numbers: Numbers, form: Form) -> tuple[Entity, int]:
    """Entity of the next nodes or elements, and the number after it."""
    one, other, more = numbers.ints(3).tolist()
    return ((other, one) if form.version == "4.0" else (one, other)), more


def _elements(section: Section, form: Form, entities: _Entities) -> Iterator[_Elements]:
    """Elements in the order of the file, without copies for other parts of a partition."""
    if form.version == "2.2":
        yield from _merged(_old_elements(section, form))
        return
    numbers = _numbers(section, form)
    for _ in range(int(numbers.sizes(2 if form.version == "4.0" else 4)[0])):
        entity, kind = _head(numbers, form)
        count, (name, width) = int(numbers.sizes(1)[0]), _kind(kind)
        table = numbers.tags(count * (1 + width)).reshape(count, 1 + width)
        if not entities.part or entity in entities.part:
            yield _Elements(name, table[:, 0], table[:, 1:], np.full(count, entities.group.get(entity, 0)), entity)


def _old_elements(section: Section, form: Form) -> Iterator[_Elements]:
    """Elements of version 2.2, which have tags of their own, the first of which is the group."""
    first, body = first_line(section.body)
    left = _count(first, "elements")
    numbers = _numbers(section._replace(body=body), form)
    while left > 0:
        if isinstance(numbers, Text):
            (_, kind, tags), count = numbers.ahead(3).tolist(), 1
        else:
            kind, count, tags = numbers.ints(3).tolist()
        if count < 1 or tags < 0:
            raise FileError("its elements are not as Gmsh writes them: the file is damaged")
        name, width = _kind(kind)
        if isinstance(numbers, Text):
            table = np.delete(numbers.alike(3 + tags + width, slice(1, 3)), [1, 2], axis=1)
        else:
            table = numbers.ints(count * (1 + tags + width)).reshape(count, 1 + tags + width)
        left -= len(table)
        group = table[:, 1] if tags else np.zeros(len(table), np.int64)
        yield _Elements(name, table[:, 0], table[:, 1 + tags :], group)


def _merged(elements: Iterable[_Elements]) -> Iterator[_Elements]:
    """Elements with consecutive ones of the same kind merged into one block."""
    for name, blocks in groupby(elements, key=lambda block: block.kind):
        numbers, nodes, group = zip(*((block.numbers, block.nodes, block.group) for block in blocks), strict=True)
        yield _Elements(name, np.concatenate(numbers), np.concatenate(nodes), np.concatenate(group))


def _count(text: bytes, what: str) -> int:
    return int(wholes([text], f"counts of {what}")[0])


def _kind(number: int) -> tuple[str, int]:
    """meshio's name of a kind of elements, by Gmsh's number, and the number of their nodes."""
    from meshio._common import num_nodes_per_cell
    from meshio.gmsh.common import _gmsh_to_meshio_type

    name = _gmsh_to_meshio_type.get(number)
    if name is None:
        raise FileError(f"has elements of the kind {number} of Gmsh, which is not known here")
    return name, num_nodes_per_cell[name]


def _ordered(kind: str, cells: Integers) -> Integers:
    """Cells (m, k) with their nodes in the order in which meshio has them."""
    from meshio.gmsh.common import _gmsh_to_meshio_order

    return np.asarray(_gmsh_to_meshio_order(kind, cells))


def _periodic(section: Section, form: Form) -> Iterator[Integers]:
    """For each pair of periodic curves, the numbers (k, 2) of their matching nodes."""
    numbers = _numbers(section, form)
    for _ in range(int((numbers.sizes if form.version == "4.1" else numbers.ints)(1)[0])):
        dimension = int(numbers.ints(3)[0])
        count = int(numbers.sizes(1)[0])
        if form.version == "4.1":
            numbers.reals(count)
            count = int(numbers.sizes(1)[0])
        elif count < 0:  # which announces a map
            numbers.reals(SHIFT)
            count = int(numbers.sizes(1)[0])
        pairs = numbers.tags(2 * count).reshape(-1, 2)
        if dimension == CURVE:
            yield pairs
