"""Formats of finite element programs: Medit (FreeFEM, Mmg), MED (Salome, Code_Aster), inp (Abaqus, CalculiX)."""

from collections.abc import Iterator
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bubblemesh.arrays import Floats
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles.groups import (
    Fields,
    cell_kinds,
    facet_ids,
    group_names,
    node_ids,
    plain_words,
    point_ids,
    region_ids,
)
from bubblemesh.meshfiles.text import lines, listed, numbered, write_text

PER_LINE = 16  # numbers in a line of a set of Abaqus, at most
FIELD = 20  # characters of a number; CalculiX drops the others, be they an exponent


def write_medit(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write nodes, edges and triangles with their ids; the format has no place for names and fields."""
    write_text(path, _medit_text(mesh))


def _medit_text(mesh: Mesh) -> Iterator[str]:
    yield f"MeshVersionFormatted 2\nDimension 2\n\nVertices\n{len(mesh.points)}\n"
    yield from lines("%r %r %d", mesh.points, point_ids(mesh))
    yield f"\nEdges\n{len(mesh.facets)}\n"
    yield from lines("%d %d %d", mesh.facets + 1, facet_ids(mesh))
    yield f"\nTriangles\n{len(mesh.triangles)}\n"
    yield from lines("%d %d %d %d", mesh.triangles + 1, region_ids(mesh))
    if len(mesh.labelled_nodes):
        # Mmg keeps the points that are named here.
        yield f"\nRequiredVertices\n{len(mesh.labelled_nodes)}\n"
        yield from lines("%d", mesh.labelled_nodes + 1)
    yield "\nEnd\n"


def write_med(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write edges and triangles with a named group for each label and region, and the groups of the labelled points."""
    import meshio

    line, triangle = cell_kinds(mesh)
    # MED numbers the families of cells downwards from -1 and those of nodes upwards from 1; 0 is none.
    data: dict[str, Any] = {"cell_tags": [-facet_ids(mesh), -region_ids(mesh)]}
    points = np.zeros(len(mesh.points), np.int64)
    points[mesh.labelled_nodes] = node_ids(mesh)
    result = meshio.Mesh(
        mesh.points, [(line, mesh.facets), (triangle, mesh.triangles)], {"point_tags": points}, cell_data=data
    )
    words = plain_words(mesh)
    families = [(words[name], group) for name, group in group_names(mesh).items()]
    result.cell_tags = {-group.id: [word] for word, group in families if group.dimension > 0}
    result.point_tags = {group.id: [word] for word, group in families if group.dimension == 0}
    # Built in memory, since HDF5 does not survive a full disk.
    file = BytesIO()
    result.write(file, file_format="med")
    path.write_bytes(file.getvalue())


def write_inp(mesh: Mesh, fields: Fields, path: Path, *, element: str) -> None:
    """Write nodes and elements of the kind ``element`` and the number of its nodes; there is no place for fields.

    Each region is an ELSET, each label an NSET and, for loads on edges, a SURFACE of the same name; the surface of an
    inner line is its left side. Each labelled point is an NSET. All nodes are in the NSET ``NALL`` and all elements
    in the ELSET ``EALL``.
    """
    write_text(path, _inp_text(mesh, element))


write_plane_stress = partial(write_inp, element="CPS")
write_plane_strain = partial(write_inp, element="CPE")


def set_names(mesh: Mesh) -> dict[str, str]:
    """Return the name of each group's set."""
    return plain_words(mesh, reserved=("NALL", "EALL"))


def _inp_text(mesh: Mesh, element: str) -> Iterator[str]:
    spelled = set_names(mesh)
    words = list(spelled.values())
    regions, points = words[len(mesh.labels) :], words[len(mesh.labels) + len(mesh.regions) :]
    width = mesh.triangles.shape[1]
    yield "*HEADING\nmesh by bubblemesh\n"
    yield from (f"** {word} stands for {name}\n" for name, word in spelled.items() if name != word)
    yield "*NODE, NSET=NALL\n"
    yield from lines("%d, %s, %s, 0.0", numbered(len(mesh.points)), _short(mesh.points))
    for index, word in enumerate(regions[: len(mesh.regions)]):
        mine = np.flatnonzero(mesh.triangle_regions == index)
        yield f"*ELEMENT, TYPE={element}{width}, ELSET={word}\n"
        yield from lines(", ".join(["%d"] * (width + 1)), mine + 1, mesh.triangles[mine] + 1)
    yield "*ELSET, ELSET=EALL\n" + "".join(f"{word}\n" for word in regions[: len(mesh.regions)])
    for index, word in enumerate(words[: len(mesh.labels)]):
        of_label = mesh.facet_labels == index
        yield f"*NSET, NSET={word}\n{listed(np.unique(mesh.facets[of_label]) + 1, PER_LINE)}"
        yield f"*SURFACE, NAME={word}, TYPE=ELEMENT\n"
        yield from lines("%d, S%d", mesh.sides[of_label] + 1)
    for index, word in enumerate(points):
        yield f"*NSET, NSET={word}\n{listed(mesh.labelled_nodes[mesh.node_labels == index] + 1, PER_LINE)}"


def _short(points: Floats) -> NDArray[np.object_]:
    """Coordinates (n, 2) as text that fits a field: exact where it can be, else to 14 digits or more."""
    texts = [text if len(text := repr(x)) <= FIELD else _cut(x) for x in points.ravel().tolist()]
    return np.array(texts, object).reshape(points.shape)


def _cut(x: float) -> str:
    return next(text for digits in range(16, 0, -1) if len(text := f"{x:.{digits}g}") <= FIELD)
