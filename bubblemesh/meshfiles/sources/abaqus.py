"""Meshes of Abaqus and CalculiX (.inp): nodes, elements, sets of elements, and surfaces along sides of elements."""

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Integers, each_once
from bubblemesh.errors import FileError
from bubblemesh.files import read_bytes
from bubblemesh.meshfiles.groups import ALL_ELEMENTS, ALL_NODES
from bubblemesh.meshfiles.sources.source import Block, Numbering, Source, reals, wholes, with_named_edges
from bubblemesh.messages import shown

# Plane elements by their families, which the number of their nodes follows: stress, strain, with an axis, heat,
# membranes and shells. meshio has a table of the others.
PLANE = re.compile(r"(?:CPS|CPEG|CPE|CAX|CGAX|DC2D|DCAX|M3D|S)([34689])(?:R|H|RH|M|T)?\Z")
PLANE_KINDS = {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8", 9: "quad9"}
CORNERS = {"triangle": 3, "triangle6": 3, "quad": 4, "quad8": 4, "quad9": 4}
SIDE = re.compile(r"S([1-4])\Z", re.IGNORECASE)  # S1 is the side from the first corner to the second

LISTS = "NODE", "ELEMENT", "NSET", "ELSET", "SURFACE"  # keywords that nobody writes without lines
BY_GMSH = "******* E L E M E N T S *************"  # the line above the elements in decks that Gmsh writes

Sets = dict[str, list[int]]
"""Numbers of the elements of each set, by its name in capitals: names have no case."""


class KeywordBlock(NamedTuple):
    """A keyword with its options, whose names are capitals, and the words of each line that follows."""

    keyword: str
    options: Mapping[str, str]
    lines: Sequence[Sequence[str]]

    @property
    def words(self) -> list[str]:
        """Words of all lines."""
        return [word for line in self.lines for word in line]

    def option(self, name: str) -> str:
        """Value of an option in capitals; empty if it is left out."""
        return self.options.get(name, "").upper()


class Elements(NamedTuple):
    """Elements (m,) of a section: meshio's name of their kind, their numbers and those (m, k) of their nodes, a set."""

    kind: str
    numbers: Integers
    nodes: Integers
    of_set: str  # in capitals; empty for none


def read_inp(path: Path) -> Source:
    """Mesh of a deck, with its surfaces as sets of edges; FileError if it has none, or is damaged."""
    text = read_bytes(path).decode()
    sections = list(_sections(text))
    rows = [line for section in sections if section.keyword == "NODE" for line in section.lines]
    nodes = _numbering(wholes([row[0] for row in rows], "numbers of nodes"), "node")
    points = reals([(*row[1:4], "0", "0", "0")[:3] for row in rows], "coordinates").reshape(-1, 3)
    elements = [_elements(section) for section in sections if section.keyword == "ELEMENT"]
    if not elements:
        raise FileError("holds no *ELEMENT: it is no mesh of Abaqus or CalculiX")
    cells = _numbering(np.concatenate([part.numbers for part in elements]), "element")
    sets = _sets(sections, elements)
    by_gmsh = BY_GMSH in text
    groups = _with_rest_of_entities(sections, sets) if by_gmsh else sets

    def in_blocks(name: str) -> list[Integers]:
        """Elements of a set in each block."""
        found = cells.places(np.array(sorted(set(groups[name.upper()])), np.int64))
        return [found[(found >= first) & (found < end)] - first for first, end in _spans(elements)]

    blocks = [Block(part.kind, nodes.places(part.nodes)) for part in elements]
    surfaces = _surfaces(sections, sets, elements, cells)
    of_nodes = {section.options["NSET"] for section in sections if section.option("NSET") not in ("", ALL_NODES)}
    return with_named_edges(
        points,
        blocks,
        {name: nodes.places(sides) for name, sides in surfaces.items()},
        {name: in_blocks(name) for name in _set_names(sections)},
        node_sets=tuple(sorted(of_nodes - surfaces.keys())),  # a label may be both
        notes=(
            *_signs_of_a_cut(text, sections[-1], len(rows) - len(_used(blocks))),
            *(_torn_entities(sections, sets, groups) if by_gmsh else ()),
        ),
    )


def _used(blocks: Sequence[Block]) -> Integers:
    """The nodes (k,) of all cells, each once."""
    return each_once(np.concatenate([block.data.ravel() for block in blocks]))


def _signs_of_a_cut(text: str, last: KeywordBlock, unused: int) -> Iterator[str]:
    """Notes on what may show that a deck was cut off: as it has no counts, nothing is missing for sure.

    The signs are in the text, in its last section, and in the number of nodes that no element uses.
    """
    if last.keyword in LISTS and not last.lines:
        yield f"ends with *{last.keyword} and none of its lines: is the file cut off?"
    lists_by_gmsh = BY_GMSH in text and last.keyword in ("ELSET", "NSET")  # all of their lines end with a comma
    if text.rstrip().endswith(",") and not (lists_by_gmsh and text.endswith("\n")):
        yield "ends with a comma, as if a line followed: is the file cut off?"
    if unused:
        what = "1 node is" if unused == 1 else f"{unused:,} nodes are"
        yield f"{what} in no element: is the file cut off?"


def _with_rest_of_entities(sections: Sequence[KeywordBlock], sets: Sets) -> Sets:
    """Sets of a deck of Gmsh, in which those of geometrical entities hold only what is in no physical group.

    Gmsh names the set of each entity (``Line1``, ``Surface2``) where it lists its elements, and groups in lists of
    their own, each of whole entities. Names of groups count, as in its ``.msh`` files.
    """
    named = {section.option("ELSET") for section in sections if section.keyword == "ELSET"}
    grouped = {number for name in named for number in sets[name]}
    return {
        name: numbers if name in named else [number for number in numbers if number not in grouped]
        for name, numbers in sets.items()
    }


def _torn_entities(sections: Sequence[KeywordBlock], sets: Sets, groups: Sets) -> Iterator[str]:
    """Notes on entities of Gmsh of which the last group of a deck has a part only: groups have all or nothing of one.

    ``groups`` are the sets as `_with_rest_of_entities` gives them.
    """
    last = sections[-1]
    listed = set(sets[last.option("ELSET")]) if last.keyword == "ELSET" else set()
    for name in _set_names(sections):
        rest, numbers = len(groups[name.upper()]), sets[name.upper()]
        if 0 < rest < len(numbers) and not listed.isdisjoint(numbers):
            yield f"of the {len(numbers):,} elements of {name} {rest:,} are in no group: is the file cut off?"


def _sections(text: str) -> Iterator[KeywordBlock]:
    """All keywords of a deck, without comments."""
    keyword, options, lines = "", dict[str, str](), list[list[str]]()
    for line in text.splitlines():
        if line.startswith("**") or not line.strip():
            continue
        words = [word.strip() for word in line.split(",")]
        if not line.startswith("*"):
            lines.append([word for word in words if word])
            continue
        yield KeywordBlock(keyword, options, lines)
        keyword, lines = words[0].lstrip("*").upper(), []
        pairs = (word.partition("=") for word in words[1:])
        options = {name.strip().upper(): value.strip().strip('"') for name, _, value in pairs}
    yield KeywordBlock(keyword, options, lines)


def _spans(elements: Sequence[Elements]) -> Iterator[tuple[int, int]]:
    """Place of the first element of each section among all, and the place after its last one."""
    return pairwise(np.cumsum([0, *(len(part.numbers) for part in elements)]).tolist())


def _numbering(numbers: Integers, what: str) -> Numbering:
    """Numbering of the nodes or elements of a deck; FileError if two have the same number."""
    different, count = np.unique(numbers, return_counts=True)
    if (count > 1).any():
        twice = different[count > 1][0]
        raise FileError(f"has the {what} {twice} twice: of several parts with numbers of their own write one alone")
    return Numbering(numbers, what)


def _elements(section: KeywordBlock) -> Elements:
    """Elements of a section; FileError if their type is not known, or the last one is not whole."""
    kind, width = _kind(section.option("TYPE"))
    words = wholes(section.words, "elements")
    if len(words) % (width + 1):
        raise FileError(f"an element of the type {section.option('TYPE')} has more or fewer than {width} nodes")
    rows = words.reshape(-1, width + 1)
    return Elements(kind, rows[:, 0], rows[:, 1:], section.option("ELSET"))


def _kind(of_type: str) -> tuple[str, int]:
    """meshio's name of a type of elements, and the number of their nodes."""
    if plane := PLANE.match(of_type):
        return PLANE_KINDS[int(plane[1])], int(plane[1])
    from meshio._common import num_nodes_per_cell
    from meshio.abaqus._abaqus import abaqus_to_meshio_type

    kind = abaqus_to_meshio_type.get(of_type)
    if kind not in num_nodes_per_cell:
        raise FileError(f"has elements of the type {shown(of_type)}, which is not known here")
    return kind, num_nodes_per_cell[kind]


def _set_names(sections: Sequence[KeywordBlock]) -> list[str]:
    """Names of the sets of elements as they are written first, without those that Abaqus/CAE makes for surfaces."""
    naming = [section for section in sections if section.keyword in ("ELEMENT", "ELSET") and section.option("ELSET")]
    named = [section.options for section in naming if "INTERNAL" not in section.options]
    first = {options["ELSET"].upper(): options["ELSET"] for options in reversed(named)}
    return [first[name] for name in reversed(first) if name != ALL_ELEMENTS]


def _sets(sections: Sequence[KeywordBlock], elements: Sequence[Elements]) -> Sets:
    """All sets of elements; FileError if one is damaged."""
    sets = Sets()
    for part in elements:
        sets.setdefault(part.of_set, []).extend(part.numbers.tolist())
    numbers = [number for part in elements for number in part.numbers.tolist()]
    for section in sections:
        if section.keyword == "ELSET":
            sets.setdefault(section.option("ELSET"), []).extend(_members(section, sets, numbers))
    return sets


def _members(section: KeywordBlock, sets: Sets, numbers: Sequence[int]) -> list[int]:
    """Elements that a set names: one by one, by other sets, or by their first, last, and step; ``numbers`` are all."""
    if "GENERATE" not in section.options:
        return [number for word in section.words for number in _named(word, sets)]
    ranges = (wholes((*line, "1")[:3], "ranges of a set").tolist() for line in section.lines)
    chosen = [range(first, last + 1, max(step, 1)) for first, last, step in ranges]
    return [number for number in numbers if any(number in some for some in chosen)]


def _named(word: str, sets: Sets) -> Sequence[int]:
    """Elements that a word stands for: one by its number, or those of a set."""
    return (int(word),) if word.isdecimal() else sets.get(word.upper(), ())


def _surfaces(
    sections: Sequence[KeywordBlock], sets: Sets, elements: Sequence[Elements], cells: Numbering
) -> dict[str, Integers]:
    """Sides (m, 2) of the plane elements of each surface, by the numbers of their nodes."""
    count = np.concatenate([np.full(len(part.numbers), CORNERS.get(part.kind, 0)) for part in elements])
    corners = np.zeros((len(count), max(CORNERS.values())), np.int64)
    for part, (first, end) in zip(elements, _spans(elements), strict=True):
        width = CORNERS.get(part.kind, 0)
        corners[first:end, :width] = part.nodes[:, :width]
    surfaces = dict[str, Integers]()
    for section in sections:
        if section.keyword != "SURFACE" or section.option("TYPE") not in ("", "ELEMENT"):
            continue
        named = [(line[0], int(line[1][1])) for line in section.lines if len(line) > 1 and SIDE.match(line[1])]
        found = [(number, side) for word, side in named for number in _named(word, sets)]
        number, side = np.array(found, np.int64).reshape(-1, 2).T
        place = cells.places(number)
        place, side = place[side <= count[place]], side[side <= count[place]]  # faces of solids are no edges
        if len(place):
            surfaces[section.options.get("NAME", "")] = np.column_stack(
                [corners[place, side - 1], corners[place, side % count[place]]]
            )
    return surfaces
