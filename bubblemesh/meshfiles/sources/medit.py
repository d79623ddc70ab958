"""Medit's text files, as Mmg, FreeFEM and this package write them: meshes (.mesh) with a solution beside (.sol)."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from bubblemesh.errors import FileError
from bubblemesh.files import read_bytes, require_readable
from bubblemesh.meshfiles.sources.source import Block, Data, Source, reals, require_length, wholes

# Nodes of the cells of each kind, by the words of the file; all have a number of their group after them.
CELLS = {
    "Edges": ("line", 2),
    "EdgesP2": ("line3", 3),
    "Triangles": ("triangle", 3),
    "TrianglesP2": ("triangle6", 6),
    "Quadrilaterals": ("quad", 4),
    "Tetrahedra": ("tetra", 4),
    "Hexahedra": ("hexahedron", 8),
    "Hexaedra": ("hexahedron", 8),
    "Prisms": ("wedge", 6),
}
FOREIGN = {b"MFEM": "write the solution as ParaView data (.vtu) by MFEM's ParaViewDataCollection"}
NO_NUMBERS = b"nan", b"inf"  # written by programs in place of a number
SOLUTION = "solution"
GROUP = "medit:ref"


def read_medit(path: Path) -> Source:
    """Mesh of a .mesh file, with the solution of the .sol file of the same name, if there is one.

    Its data is called solution, or solution-1, solution-2 ... FileError if a file cannot be read.
    """
    content = read_bytes(path)
    for start, advice in FOREIGN.items():
        if content.startswith(start):
            raise FileError(f"is a mesh of {start.decode()}'s own format, which is not read: {advice}")
    sections = dict(_sections(content))
    dimension = _dimension(sections)
    if "Vertices" not in sections:
        raise FileError("has no Vertices: it is no mesh of Medit's format")
    table = _rows(sections["Vertices"], dimension + 1, "Vertices")
    blocks, groups = [], []
    for word, (kind, count) in CELLS.items():
        if word in sections:
            rows = _rows(sections[word], count + 1, word).astype(np.int64)
            blocks.append(Block(kind, rows[:, :-1] - 1))
            groups.append(rows[:, -1])
    beside = path.with_suffix(".sol")
    data = {GROUP: table[:, -1].astype(np.int64)} | (_solution(beside, len(table)) if beside.exists() else {})
    return Source(table[:, :-1], blocks, data, {GROUP: groups} if blocks else {})


def read_solution(path: Path) -> Source:
    """The mesh beside a .sol file, with its solution; the same errors as `read_medit`."""
    mesh = path.with_suffix(".mesh")
    if not mesh.exists():
        raise FileError(f"is a solution without a mesh: put {mesh.name} beside it")
    require_readable(path)
    return read_medit(mesh)


def _solution(path: Path, nodes: int) -> dict[str, Data]:
    """Data at the nodes in a .sol file, by name; empty if there is no such file."""
    sections = dict(_sections(read_bytes(path)))
    if "SolAtVertices" not in sections:
        raise FileError(f"{path.name}: has no SolAtVertices")
    dimension, words = _dimension(sections), sections["SolAtVertices"]
    require_length(len(words), 2, "numbers of SolAtVertices")
    count, kinds = wholes(words[:2], "numbers of SolAtVertices").tolist()
    if count != nodes:
        raise FileError(f"{path.name}: is for {count:,} nodes, the mesh beside it has {nodes:,}")
    widths = {1: 1, 2: dimension, 3: dimension * (dimension + 1) // 2}
    sizes = [widths.get(int(kind), 0) for kind in wholes(words[2 : 2 + kinds], "kinds of solutions")]
    total = sum(sizes)
    require_length(len(words) - 2 - kinds, count * total, "values of SolAtVertices")
    values = reals(words[2 + kinds : 2 + kinds + count * total], "values").reshape(count, total)
    parts = np.split(values, np.cumsum(sizes)[:-1], axis=1)
    names = [SOLUTION] if len(parts) == 1 else [f"{SOLUTION}-{k}" for k in range(1, len(parts) + 1)]
    return {name: part[:, 0] if part.shape[1] == 1 else part for name, part in zip(names, parts, strict=True)}


def _sections(content: bytes) -> Iterator[tuple[str, list[bytes]]]:
    """Words after each keyword, which begins with a letter; a text in quotes is one word, comments are left out."""
    lines = (line.partition(b"#")[0].strip() for line in content.splitlines())
    name = ""
    words: list[bytes] = []
    for line in lines:
        if line[:1].isalpha() and not line.lower().startswith(NO_NUMBERS):
            if name:
                yield name, words
            first, *words = line.split()
            name = first.decode("ascii", "replace")
        else:
            words += line.split()
    if name:
        yield name, words


def _dimension(sections: dict[str, list[bytes]]) -> int:
    words = sections.get("Dimension", [])
    if words[:1] not in ([b"2"], [b"3"]):
        raise FileError("has no Dimension 2 or 3: it is no text file of Medit's format")
    return int(words[0])


def _rows(words: list[bytes], width: int, what: str) -> Data:
    """Rows (n, width) of a section, whose first word is n."""
    count = int(wholes(words[:1] or [b"0"], f"counts of {what}")[0])
    require_length(len(words) - 1, count * width, f"numbers of {what}")
    return reals(words[1 : 1 + max(count, 0) * width], what).reshape(-1, width)
