"""Files of Gmsh, which meshio reads but for the entities of a partition in format 4.1."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from bubblemesh.arrays import Integers
from bubblemesh.errors import FileError
from bubblemesh.files import opened, read_bytes, temporary_folder
from bubblemesh.meshfiles.groups import PARTITION
from bubblemesh.meshfiles.sources.freefem import is_freefem, read_freefem
from bubblemesh.meshfiles.sources.other import read_other
from bubblemesh.meshfiles.sources.source import NodeNumbers, Source

FORMAT = b"$MeshFormat"
WHOLE, PARTS = b"$Entities", b"$PartitionedEntities"
NODES = b"$Nodes"
DIMENSIONS = {"vertex": 0, "line": 1, "line3": 1}  # of kinds of cells; of all others 2


def read_msh(path: Path) -> Source:
    """Mesh of Gmsh or of FreeFEM, which have the same ending; errors as of `read_other`."""
    if is_freefem(path):
        return read_freefem(path)
    return read_partitioned(path) if is_partitioned(path) else _read(path)


def is_partitioned(path: Path) -> bool:
    """Whether a file of Gmsh has entities that are parts of others, which come before the nodes."""
    with opened(path) as stream:
        return any(line.startswith(PARTS) for line in _until_nodes(stream))


def _until_nodes(stream: Iterable[bytes]) -> Iterator[bytes]:
    for line in stream:
        if line.startswith(NODES):
            return
        yield line


def read_partitioned(path: Path) -> Source:
    """Mesh of a file with a partition, with the part of each cell, from 0; errors as of `read_other`.

    meshio gets the file with the parts of entities as whole ones, which they are with respect to nodes and cells.
    Ghosts, of which files of one part alone have cells, are left out: they are copies of cells of other parts.
    """
    lines = read_bytes(path).splitlines(keepends=True)
    if lines[1].split()[1:2] != [b"0"]:
        raise FileError("has a partition in binary form, which is not read: let Gmsh write it as text")
    names = [line.strip() for line in lines]
    begin, end = names.index(PARTS), names.index(b"$EndPartitionedEntities")
    ghosts = [row.split()[0] for row in names[begin + 3 : begin + 3 + int(names[begin + 2])]]
    counts, *rows = names[begin + 3 + len(ghosts) : end]
    entities, part = list[bytes](), dict[tuple[int, int], int]()
    numbers = [int(count) for count in counts.split()]
    for dimension, row in zip(np.repeat(range(4), numbers).tolist(), rows, strict=True):
        words = row.split()
        parents = 4 + int(words[3])  # words: a tag, dimension and tag of the parent, a number of parts, and these
        part[dimension, int(words[0])] = int(words[4]) - 1
        entities.append(b" ".join([words[0], *words[parents:]]))
    # A box, and a group, without which meshio would give the wrong groups to the others.
    entities += [tag + b" 0 0 0 0 0 0 1 0 0" for tag in ghosts]
    numbers[2] += len(ghosts)
    text = b"\n".join([b"%d %d %d %d" % tuple(numbers), *entities]) + b"\n"
    first, last = names.index(WHOLE), names.index(b"$EndEntities")
    with temporary_folder() as folder:
        plain = Path(folder, path.name)
        plain.write_bytes(b"".join([*lines[: first + 1], text, *lines[last:begin], *lines[end + 1 :]]))
        source = _read(plain)
    return _with_parts(source, part)


def _read(path: Path) -> Source:
    """Mesh as meshio reads it, but for nodes of periodic sides: these it gives by their numbers in the file less 1."""
    source = read_other(path, "gmsh")  # without the format it would try ANSYS first
    if not source.matching:
        return source
    numbers = NodeNumbers(_numbers_of_nodes(path))
    return replace(source, matching=[numbers.places(nodes + 1) for nodes in source.matching])


def _numbers_of_nodes(path: Path) -> Integers:
    """Numbers (n,) of the nodes in their order in a file that meshio has read."""
    from meshio.gmsh import _gmsh41, main

    with opened(path) as stream:
        while not stream.readline().startswith(FORMAT):
            pass
        version, size, is_text = main._read_header(stream)
        reader = main._readers.get(version) or main._readers[version.partition(".")[0]]
        while not stream.readline().startswith(NODES):
            pass
        if reader is _gmsh41:  # which counts from 0 by itself
            return np.asarray(reader._read_nodes(stream, is_text, size)[1]) + 1
        return np.asarray(reader._read_nodes(stream, is_text)[1]).astype(np.int64)


def _with_parts(source: Source, part: Mapping[tuple[int, int], int]) -> Source:
    """The source with the part of each cell, by the entity that all cells of its block are on; others are left out."""
    entities = [
        (DIMENSIONS.get(block.type, 2), int(tags[0]) if len(tags) else -1)
        for block, tags in zip(source.cells, source.cell_data["gmsh:geometrical"], strict=True)
    ]
    own = [k for k, entity in enumerate(entities) if entity in part]
    blocks = [source.cells[k] for k in own]
    data = {name: [values[k] for k in own] for name, values in source.cell_data.items()}
    data[PARTITION] = [np.full(len(source.cells[k].data), part[entities[k]]) for k in own]
    sets = {name: [chosen[k] for k in own] for name, chosen in source.cell_sets.items()}
    return replace(source, cells=blocks, cell_data=data, cell_sets=sets)
