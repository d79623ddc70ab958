"""The input format of Abaqus and CalculiX: plane elements, and sets for boundary conditions and materials."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bubblemesh.arrays import Floats
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles.groups import Fields
from bubblemesh.meshfiles.names import plain_words
from bubblemesh.meshfiles.text import lines, listed, numbered, write_text

PER_LINE = 16  # numbers in a line of a set, at most
FIELD = 20  # characters of a number; CalculiX drops the others, be they an exponent


def write_inp(mesh: Mesh, fields: Fields, path: Path, *, element: str) -> None:
    """Write nodes and elements of the kind ``element`` and the number of its nodes; there is no place for fields.

    Each region is an ELSET, each label an NSET and, for loads on edges, a SURFACE of the same name; the surface of an
    inner line is its left side. Each labelled point is an NSET. All nodes are in the NSET ``NALL`` and all elements
    in the ELSET ``EALL``.
    """
    write_text(path, _parts(mesh, element))


write_plane_stress = partial(write_inp, element="CPS")
write_plane_strain = partial(write_inp, element="CPE")


def set_names(mesh: Mesh) -> dict[str, str]:
    """Return the name of each group's set."""
    return plain_words(mesh, reserved=("NALL", "EALL"))


def _short(points: Floats) -> NDArray[np.object_]:
    """Coordinates (n, 2) as text that fits a field: exact where it can be, else to 14 digits or more."""
    texts = [text if len(text := repr(x)) <= FIELD else _cut(x) for x in points.ravel().tolist()]
    return np.array(texts, object).reshape(points.shape)


def _cut(x: float) -> str:
    return next(text for digits in range(16, 0, -1) if len(text := f"{x:.{digits}g}") <= FIELD)


def _parts(mesh: Mesh, element: str) -> Iterator[str]:
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
