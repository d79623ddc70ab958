"""Results of CalculiX (.frd), as text."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from bubblemesh.errors import FileError
from bubblemesh.files import read_bytes
from bubblemesh.meshfiles.sources.source import Block, Data, Numbering, Source, reals, wholes

# meshio's name and the number of nodes of each kind of elements, by CalculiX's number.
KINDS = {
    1: ("hexahedron", 8),
    2: ("wedge", 6),
    3: ("tetra", 4),
    4: ("hexahedron20", 20),
    5: ("wedge15", 15),
    6: ("tetra10", 10),
    7: ("triangle", 3),
    8: ("triangle6", 6),
    9: ("quad", 4),
    10: ("quad8", 8),
    11: ("line", 2),
    12: ("line3", 3),
}
NODES, ELEMENTS, RESULTS, END = "    2C", "    3C", "  100C", " -3"
SHORT, LONG = 5, 10  # letters of the numbers of nodes and elements
NUMBER = 12  # letters of a real number
VALUES = 6  # of a node in a line; more follow in lines of their own


def read_frd(path: Path) -> Source:
    """Nodes, elements, and the results of the last step, each by its name, as DISP; FileError if it cannot be read."""
    text = iter(read_bytes(path).decode("ascii", "replace").splitlines())
    points, numbers = np.zeros((0, 3)), np.zeros(0, np.int64)
    blocks: list[Block] = []
    materials: list[Data] = []
    results: dict[str, Data] = {}
    times: dict[str, None] = {}
    for line in text:
        if line.startswith(NODES):
            numbers, points = _table(text, _width(line), 3)
        elif line.startswith(ELEMENTS):
            blocks, materials = _elements(text, _width(line), numbers)
        elif line.startswith(RESULTS):
            times[line[12:24].strip()] = None
            name, at, values = _result(text, _width(line))
            results[name] = _at_nodes(numbers, at, values)
    if not len(points):
        raise FileError("holds no nodes of a result file of CalculiX")
    last = [*times][-1:]
    notes = (f"holds {len(times)} times: the last one, {float(last[0]):g}, is read",) if len(times) > 1 else ()
    return Source(points, blocks, results, {"material": materials} if blocks else {}, notes=notes)


def _width(head: str) -> int:
    """Width, in letters, of the numbers of a block's nodes and elements, by its first line."""
    form = head[73:75].strip() or "1"
    if form not in ("0", "1"):
        raise FileError("is binary: have CalculiX write text (without OUTPUT=BINARY, or by *NODE FILE)")
    return LONG if form == "1" else SHORT


def _body(text: Iterator[str]) -> Iterator[str]:
    """Lines of a block up to its end."""
    for line in text:
        if line.startswith(END):
            return
        yield line
    raise FileError("ends within a block: did the run end early?")


def _table(text: Iterator[str], width: int, count: int) -> tuple[Data, Data]:
    """Numbers (n,) of nodes, and ``count`` values (n, count) of each."""
    lines = [line for line in _body(text) if line.startswith(" -")]
    heads = [line for line in lines if line.startswith(" -1")]
    first = 3 + width
    per_node = -(-count // VALUES)
    if len(lines) != per_node * len(heads):
        raise FileError("a node has more or fewer values than its block tells: the file is damaged")
    words = [
        lines[k][first + NUMBER * j : first + NUMBER * (j + 1)]
        for start in range(0, len(lines), per_node)
        for k in range(start, start + per_node)
        for j in range(min(VALUES, count - VALUES * (k - start)))
    ]
    return wholes([line[3:first] for line in heads], "numbers of nodes"), reals(words, "values").reshape(-1, count)


def _elements(text: Iterator[str], width: int, numbers: Data) -> tuple[list[Block], list[Data]]:
    """Blocks of elements, with the material of each."""
    found: dict[int, tuple[list[str], list[str]]] = {}  # words of the nodes, and of the materials, by kind
    nodes: list[str] = []
    for line in _body(text):
        if line.startswith(" -1"):
            kind = int(wholes([line[3 + width : 8 + width]], "kinds of elements")[0])
            if kind not in KINDS:
                raise FileError(f"holds elements of the kind {kind}, which is not read")
            nodes, materials = found.setdefault(kind, ([], []))
            materials.append(line[13 + width : 18 + width])
        else:
            nodes += [line[k : k + width] for k in range(3, len(line.rstrip()), width)]
    blocks = []
    for kind, (words, _) in found.items():
        name, count = KINDS[kind]
        given = wholes(words, "numbers of nodes")
        if len(given) != count * len(found[kind][1]):
            raise FileError(f"an element of the kind {kind} has not {count} nodes: the file is damaged")
        blocks.append(Block(name, Numbering(numbers).places(given).reshape(-1, count)))
    return blocks, [wholes(materials, "materials") for _, materials in found.values()]


def _result(text: Iterator[str], width: int) -> tuple[str, Data, Data]:
    """Name of a result, numbers (m,) of its nodes, and its values (m, k)."""
    name, components = "", 0
    head: list[str] = []
    for line in text:
        if line.startswith(" -4"):
            name = line[5:13].strip()
        elif line.startswith(" -5"):
            components += line[33:38].strip() != "1"  # 1 marks one that readers compute from the others
        else:
            head = [line]
            break
    rest = (line for part in (head, text) for line in part)
    at, values = _table(rest, width, max(components, 1))
    return name, at, values


def _at_nodes(numbers: Data, at: Data, values: Data) -> Data:
    """Values (n,) or (n, k) at all nodes, NaN where they are missing."""
    found = np.full((len(numbers), values.shape[1]), np.nan)
    found[Numbering(numbers).places(at)] = values
    return found[:, 0] if values.shape[1] == 1 else found
