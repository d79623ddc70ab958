"""Formats of finite element programs: Medit (FreeFEM, Mmg), MED (Salome, Code_Aster), inp (Abaqus, CalculiX)."""

from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bubblemesh.arrays import Booleans, Floats, each_once
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.quads import Cells
from bubblemesh.meshfiles.groups import (
    CELL_KINDS,
    FACET_KINDS,
    Fields,
    cell_ids,
    facet_ids,
    facet_numbers,
    node_numbers,
    plain_words,
    point_ids,
    region_numbers,
)
from bubblemesh.meshfiles.text import lines, number_lines, write_text

MEDIT_KINDS = {3: "Triangles", 4: "Quadrilaterals"}  # by the number of nodes
PER_LINE = 16  # numbers in a line of a set of Abaqus, at most
FIELD = 20  # characters of a number; CalculiX drops further ones, even if they are an exponent


def write_medit(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write nodes, edges and cells with their ids, without names and fields; a metric is in a file beside."""
    write_text(path, _medit_text(mesh))


def _medit_text(mesh: Mesh) -> Iterator[str]:
    """Lines of the file of `write_medit`."""
    yield f"MeshVersionFormatted 2\nDimension 2\n\nVertices\n{len(mesh.points)}\n"
    yield from lines("%r %r %d", mesh.points, point_ids(mesh))
    yield f"\nEdges\n{len(mesh.facets)}\n"
    yield from lines("%d %d %d", mesh.facets + 1, facet_ids(mesh))
    for cells in mesh.cells:
        count, width = cells.nodes.shape
        yield f"\n{MEDIT_KINDS[width]}\n{count}\n"
        yield from lines("%d " * width + "%d", cells.nodes + 1, cell_ids(mesh, cells))
    if len(mesh.labelled_nodes):
        # Mmg keeps the points in this list.
        yield f"\nRequiredVertices\n{len(mesh.labelled_nodes)}\n"
        yield from lines("%d", mesh.labelled_nodes + 1)
    yield "\nEnd\n"


def medit_metric(mesh: Mesh) -> str | None:
    """Text of the .sol file with the metric at the nodes of a mesh, as Mmg reads it beside a .mesh file.

    None for a mesh without one.
    """
    if len(mesh.metric) == 0:
        return None
    head = f"MeshVersionFormatted 2\nDimension 2\n\nSolAtVertices\n{len(mesh.metric)}\n1 3\n"
    return "".join([head, *lines("%r %r %r", mesh.metric), "\nEnd\n"])


def write_med(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write edges and cells with a named group for each label and region, and the groups of the labelled points."""
    import meshio
    from meshio.med._med import meshio_to_med_type

    meshio_to_med_type.setdefault("quad9", "QU9")  # which the table lacks
    # MED numbers the families of cells downwards from -1 and those of nodes upwards from 1; 0 stands for no family.
    # Groups are known by their names: the families of edges and of cells need different numbers, ids of one's own not.
    families = [region_numbers(mesh)[cells.triangles[:, 0]] for cells in mesh.cells]
    data: dict[str, Any] = {"cell_tags": [-facet_numbers(mesh), *(-numbers for numbers in families)]}
    points = np.zeros(len(mesh.points), np.int64)
    points[mesh.labelled_nodes] = node_numbers(mesh)
    blocks = [(FACET_KINDS[mesh.facets.shape[1]], mesh.facets)]
    blocks += [(CELL_KINDS[cells.nodes.shape[1]], cells.nodes) for cells in mesh.cells]
    result = meshio.Mesh(mesh.points, blocks, {"point_tags": points}, cell_data=data)
    words = list(enumerate(plain_words(mesh).values(), start=1))
    cells = len(mesh.labels) + len(mesh.regions)
    result.cell_tags = {-number: [word] for number, word in words[:cells]}
    result.point_tags = {number: [word] for number, word in words[cells:]}
    # Built in memory, since HDF5 crashes on a full disk.
    file = BytesIO()
    result.write(file, file_format="med")
    path.write_bytes(file.getvalue())


def write_inp(mesh: Mesh, fields: Fields, path: Path, *, element: str) -> None:
    """Write nodes and elements, whose kinds are ``element`` and the number of their nodes; fields are not written.

    - Quadrilaterals of second order have eight nodes: the middle one is left out, the others keep their numbers.
    - Each region is an ELSET, each labelled point an NSET.
    - Each label is an NSET and, for loads on edges, a SURFACE of the same name: of the cells on the left of the facets.
    - All nodes are in the NSET ``NALL``, all elements in the ELSET ``EALL``.
    """
    write_text(path, _inp_text(mesh, element))


write_plane_stress = partial(write_inp, element="CPS")
write_plane_strain = partial(write_inp, element="CPE")


def set_names(mesh: Mesh) -> dict[str, str]:
    """Return the name of each group's set."""
    return plain_words(mesh, reserved=("NALL", "EALL"))


def _inp_text(mesh: Mesh, element: str) -> Iterator[str]:
    """Lines of the file of `write_inp`."""
    spelled = set_names(mesh)
    words = list(spelled.values())
    regions, points = words[len(mesh.labels) :], words[len(mesh.labels) + len(mesh.regions) :]
    blocks = [cells._replace(nodes=cells.nodes[:, :8]) for cells in mesh.cells]
    used = _used(len(mesh.points), blocks)
    yield "*HEADING\nmesh by bubblemesh\n"
    yield from (f"** {word} stands for {name}\n" for name, word in spelled.items() if name != word)
    yield "*NODE, NSET=NALL\n"
    yield from lines("%d, %s, %s, 0.0", np.flatnonzero(used) + 1, _short(mesh.points[used]))
    yield from _inp_elements(mesh, blocks, element, regions[: len(mesh.regions)])
    for index, word in enumerate(words[: len(mesh.labels)]):
        of_label = mesh.facet_labels == index
        yield f"*NSET, NSET={word}\n{number_lines(np.unique(mesh.facets[of_label]) + 1, PER_LINE)}"
        yield f"*SURFACE, NAME={word}, TYPE=ELEMENT\n"
        yield from lines("%d, S%d", mesh.cell_sides[of_label] + 1)
    for index, word in enumerate(points):
        yield f"*NSET, NSET={word}\n{number_lines(mesh.labelled_nodes[mesh.node_labels == index] + 1, PER_LINE)}"


def _inp_elements(mesh: Mesh, blocks: Sequence[Cells], element: str, regions: Sequence[str]) -> Iterator[str]:
    """Elements of all blocks by their regions, and the sets of these.

    Sets with two kinds of elements are lists of numbers, since meshio reads a set in ``*ELEMENT`` for one kind only.
    """
    one_kind = len(blocks) == 1
    for index, word in enumerate(regions):
        for nodes, triangles in blocks:
            mine, width = mesh.triangle_regions[triangles[:, 0]] == index, nodes.shape[1]
            if mine.any():
                yield f"*ELEMENT, TYPE={element}{width}{f', ELSET={word}' if one_kind else ''}\n"
                numbers = mesh.cell_numbers[triangles[mine, 0]] + 1
                yield from lines(", ".join(["%d"] * (width + 1)), numbers, nodes[mine] + 1)
    if one_kind:
        yield "*ELSET, ELSET=EALL\n" + "".join(f"{word}\n" for word in regions)
        return
    for index, word in enumerate(regions):
        numbers = each_once(mesh.cell_numbers[mesh.triangle_regions == index]) + 1
        yield f"*ELSET, ELSET={word}\n{number_lines(numbers, PER_LINE)}"
    yield f"*ELSET, ELSET=EALL\n{number_lines(each_once(mesh.cell_numbers) + 1, PER_LINE)}"


def _used(count: int, blocks: Iterable[Cells]) -> Booleans:
    """Mask (count,) of the nodes that cells use."""
    used = np.zeros(count, bool)
    for cells in blocks:
        used[cells.nodes] = True
    return used


def _short(points: Floats) -> NDArray[np.object_]:
    """Coordinates (n, 2) as texts that fit a field: exact if possible, else with 14 digits or more."""
    texts = [text if len(text := repr(x)) <= FIELD else _cut(x) for x in points.ravel().tolist()]
    return np.array(texts, object).reshape(points.shape)


def _cut(x: float) -> str:
    return next(text for digits in range(16, 0, -1) if len(text := f"{x:.{digits}g}") <= FIELD)
