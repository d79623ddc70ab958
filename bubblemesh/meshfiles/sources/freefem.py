"""FreeFEM's own meshes, which share the ending .msh with Gmsh's."""

from codecs import BOM_UTF8
from pathlib import Path

import numpy as np

from bubblemesh.errors import FileError
from bubblemesh.files import opened, read_bytes
from bubblemesh.meshfiles.sources.source import Block, Source, reals, require_length, wholes

GROUP = "medit:ref"


def is_freefem(path: Path) -> bool:
    """Whether a file begins with three counts, and not with a section of Gmsh."""
    with opened(path) as stream:
        words = stream.readline(200).removeprefix(BOM_UTF8).split()
    return len(words) == 3 and all(word.isdigit() for word in words)


def read_freefem(path: Path) -> Source:
    """Nodes, triangles and boundary edges, with the numbers of their groups; FileError if it cannot be read."""
    words = read_bytes(path).removeprefix(BOM_UTF8).split()
    nodes, triangles, edges = wholes(words[:3], "counts").tolist()
    widths = np.repeat([3, 4, 3], [nodes, triangles, edges]) if max(nodes, triangles, edges) <= len(words) else [0]
    require_length(len(words) - 3, 3 * nodes + 4 * triangles + 3 * edges, "numbers")
    if len(words) - 3 > int(np.sum(widths)):
        raise FileError("has more numbers than a plane mesh of FreeFEM: only meshes in the xy plane are read")
    first, second = 3 + 3 * nodes, 3 + 3 * nodes + 4 * triangles
    points = reals(words[3:first], "nodes").reshape(-1, 3)
    cells = wholes(words[first:second], "triangles").reshape(-1, 4)
    lines = wholes(words[second:], "edges").reshape(-1, 3)
    blocks = [Block("triangle", cells[:, :3] - 1), Block("line", lines[:, :2] - 1)]
    return Source(points[:, :2], blocks, {}, {GROUP: [cells[:, 3], lines[:, 2]]})
