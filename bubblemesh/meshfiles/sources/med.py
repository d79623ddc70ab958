"""MED files of Salome, Code_Aster and Gmsh: HDF files of a mesh, whose groups are by families, and of fields on it."""

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from bubblemesh.errors import FileError
from bubblemesh.files import opened
from bubblemesh.meshfiles.containment import require_little
from bubblemesh.meshfiles.sources.source import Block, Data, Source
from bubblemesh.messages import shown

# meshio's name and the number of nodes of each kind of cells, by MED's name.
KINDS = {
    "PO1": ("vertex", 1),
    "SE2": ("line", 2),
    "SE3": ("line3", 3),
    "TR3": ("triangle", 3),
    "TR6": ("triangle6", 6),
    "QU4": ("quad", 4),
    "QU8": ("quad8", 8),
    "QU9": ("quad9", 9),
    "TE4": ("tetra", 4),
    "T10": ("tetra10", 10),
    "HE8": ("hexahedron", 8),
    "H20": ("hexahedron20", 20),
    "PY5": ("pyramid", 5),
    "P13": ("pyramid13", 13),
    "PE6": ("wedge", 6),
    "P15": ("wedge15", 15),
}
NODES = "NOE"
ALL = b"MED_NO_PROFILE_INTERNAL"  # the profile of data that are of all nodes or cells
CELL_TAGS, POINT_TAGS = "cell_tags", "point_tags"  # data: the number of the family of each cell, or node


def read_med(path: Path) -> Source:
    """The mesh of a file, with its families and its fields; FileError if it has not one mesh, or is damaged.

    A field of several times has the time in the names of its data. Cells of kinds that a field is not on have NaN.
    """
    import h5py  # here, so that other files do not wait for it

    with opened(path) as stream, h5py.File(stream, "r") as file:
        name, mesh = _only(file["ENS_MAA"], "meshes")
        _, step = (name, mesh) if NODES in mesh else _only(mesh, "times of its mesh")
        nodes, cells = step[NODES], step["MAI"]
        points = _rows(nodes["COO"], mesh.attrs["ESP"])
        blocks = {kind: _block(*KINDS[kind], part) for kind, part in cells.items()}
        at_nodes, of_cells, notes = _fields(file, len(points), blocks)
        tags = {kind: _family_numbers(part, len(blocks[kind].data)) for kind, part in cells.items() if "FAM" in part}
        stored = step["FAS"] if "FAS" in step else file["FAS"][name]
        return Source(
            points,
            [*blocks.values()],
            ({POINT_TAGS: _family_numbers(nodes, len(points))} if "FAM" in nodes else {}) | at_nodes,
            ({CELL_TAGS: _of_blocks(tags, blocks, 0)} if tags else {}) | of_cells,
            cell_tags=families(stored.get("ELEME", {})),
            node_sets=tuple(sorted({name for names in families(stored.get("NOEUD", {})).values() for name in names})),
            notes=notes,
        )


def _only(group: Any, what: str) -> tuple[str, Any]:
    """Name and content of the only item of a group; FileError if there are none or several."""
    if len(group) != 1:
        raise FileError(f"holds {len(group)} {what}: write a file with one")
    (item,) = group.items()
    return item


def _block(kind: str, width: int, part: Any) -> Block:
    """Cells of a kind, whose nodes a file counts from 1."""
    return Block(kind, _rows(part["NOD"], width) - 1)


def _rows(data: Any, width: int) -> Data:
    """Numbers (n, width) of which a file holds one column after the other."""
    values = data[()]
    if values.dtype.kind not in "iuf":
        raise FileError(f"{data.name} holds no numbers: the file is damaged")
    return np.asarray(values.reshape((data.attrs["NBR"], width), order="F"))


def _family_numbers(part: Any, count: int) -> Data:
    """Numbers (count,) of the families of nodes or cells."""
    numbers = np.asarray(part["FAM"][()])
    if numbers.shape != (count,) or numbers.dtype.kind not in "iu":
        raise FileError(f"{part.name}/FAM is not one whole number for each node or cell: the file is damaged")
    return numbers


def families(stored: Mapping[str, Any]) -> dict[int, list[str]]:
    """Names of the groups of each family in a file, by the number of the family."""
    return {family.attrs["NUM"]: _groups(family) for family in stored.values()}


def _groups(family: Mapping[str, Any]) -> list[str]:
    """Names of the groups of a family: a row of bytes each, which Gmsh leaves out if there is none."""
    rows = family["GRO"]["NOM"][()] if "GRO" in family else ()
    return [_decoded(bytes(row.tobytes()).rstrip(b"\0 ")).strip() for row in rows]


def _decoded(name: bytes) -> str:
    try:
        return name.decode()
    except UnicodeDecodeError:
        return name.decode("latin-1")


def _fields(
    file: Any, nodes: int, blocks: Mapping[str, Block]
) -> tuple[dict[str, Data], dict[str, list[Data]], tuple[str, ...]]:
    """Data at the nodes, data of the cells of each block, and a note on those that are left out."""
    at_nodes, of_kinds = dict[str, Data](), dict[str, dict[str, Data]]()
    for name, support, part in _parts_of_fields(file.get("CHA", {})):
        if support == NODES:
            at_nodes[name] = _values(file, part, nodes)
        else:
            kind = support.partition(".")[2]
            of_kinds.setdefault(name, {})[kind] = _values(file, part, len(blocks[kind].data))
    uneven = [name for name, of in of_kinds.items() if len({values.shape[1:] for values in of.values()}) > 1]
    of_cells = {name: _of_blocks(of, blocks, np.nan) for name, of in of_kinds.items() if name not in uneven}
    why = "cells of one kind have more values than those of another"
    return at_nodes, of_cells, (f"data are left out ({shown(', '.join(uneven))}): {why}",) if uneven else ()


def _parts_of_fields(fields: Mapping[str, Any]) -> Iterator[tuple[str, str, Any]]:
    """Name of the data, support and content of all parts of the fields; supports are as NOE, MAI.TR3 and NOE.TR3."""
    for name, field in fields.items():
        steps = sorted(field)
        for k, step in enumerate(steps):
            timed = name if len(steps) == 1 else f"{name}[{k}] - {field[step].attrs['PDT']:g}"
            for support, part in field[step].items():
                yield timed, support, part


def _values(file: Any, part: Any, count: int) -> Data:
    """Values (count,) or (count, k) of nodes or cells, or (count, g, k) at g points of each.

    Those that the profile of the data leaves out are NaN.
    """
    profile = part.attrs["PFL"]
    content = part[profile]
    points, column = content.attrs.get("NGA", 1), content["CO"][()]
    if profile == ALL:
        values = column.reshape((count, points, -1), order="F")
    else:
        places = file["PROFILS"][profile]["PFL"][()] - 1
        known = column.reshape((len(places), points, -1), order="F")
        values = _all(count, known.shape[1:], np.nan)
        values[places] = known
    if points > 1:
        return np.asarray(values)
    return np.asarray(values[:, 0, 0] if values.shape[2] == 1 else values[:, 0])


def _of_blocks(of_kinds: Mapping[str, Data], blocks: Mapping[str, Block], missing: float) -> list[Data]:
    """Data of the cells of each block, by those of some kinds of cells; others have the value that is ``missing``."""
    shape = next(iter(of_kinds.values())).shape[1:]
    return [
        of_kinds[kind] if kind in of_kinds else _all(len(block.data), shape, missing) for kind, block in blocks.items()
    ]


def _all(count: int, shape: tuple[int, ...], value: float) -> Data:
    """Array (count, *shape) with one value; LimitError if it is too large."""
    require_little(8 * count * math.prod(shape))
    return np.full((count, *shape), value)
