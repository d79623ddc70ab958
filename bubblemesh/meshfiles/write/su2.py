"""SU2's format: markers with names, no regions."""

from collections.abc import Iterator
from pathlib import Path

from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles.groups import Fields
from bubblemesh.meshfiles.names import plain_words
from bubblemesh.meshfiles.text import lines, write_text

LINE, TRIANGLE = 3, 5  # VTK's numbers of the kinds of cells


def write_su2(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write triangles, nodes and one marker for each label; the format has no place for regions and fields.

    Labels of inner edges become markers too, for SU2's option ``MARKER_INTERNAL``.
    """
    write_text(path, _parts(mesh))


def marker_names(mesh: Mesh) -> dict[str, str]:
    """Return the name of each label's marker."""
    return plain_words(mesh, dimensions=(1,))


def _parts(mesh: Mesh) -> Iterator[str]:
    words = marker_names(mesh)
    yield f"NDIME= 2\nNELEM= {len(mesh.triangles)}\n"
    yield from lines(f"{TRIANGLE} %d %d %d", mesh.triangles)
    yield f"NPOIN= {len(mesh.points)}\n"
    yield from lines("%r %r", mesh.points)
    yield f"NMARK= {len(mesh.labels)}\n"
    for index, label in enumerate(mesh.labels):
        mine = mesh.facets[mesh.facet_labels == index]
        yield f"MARKER_TAG= {words[label]}\nMARKER_ELEMS= {len(mine)}\n"
        yield from lines(f"{LINE} %d %d", mine)
