"""Views of Gmsh as text (.pos), which set the sizes of its meshes: the metric at corners of triangles, or sizes."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.quality import TARGET_SPACING, Measures
from bubblemesh.meshes.tensors import axes
from bubblemesh.meshfiles.groups import Fields
from bubblemesh.meshfiles.text import lines, write_text


def write_pos(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write triangles with the metric at their corners, or with their spacing if the mesh has no metric.

    Triangles without a known spacing get the mean length of their sides.
    """
    if len(mesh.metric):
        write_text(path, _tensors(mesh))
    else:
        sizes = fields.get(TARGET_SPACING)
        if sizes is None:
            sizes = np.mean(Measures(mesh.points, mesh.triangles).sides, axis=0)
        write_text(path, _sizes(mesh, sizes))


def _tensors(mesh: Mesh) -> Iterator[str]:
    """A view of tensors, whose third axis is as long as the ellipses."""
    (m11, m12, m22), none = mesh.metric.T, np.zeros(len(mesh.metric))
    upright = axes(mesh.metric).along ** -2.0
    whole = np.column_stack([m11, m12, none, m12, m22, none, none, none, upright])
    yield 'View "metric" {\n'
    yield from lines(f"TT({_listed(9)}){{{_listed(27)}}};", _corners(mesh), whole[mesh.triangles].reshape(-1, 27))
    yield "};\n"


def _sizes(mesh: Mesh, spacing: Floats) -> Iterator[str]:
    yield f'View "{TARGET_SPACING}" {{\n'
    yield from lines(f"ST({_listed(9)}){{{_listed(3)}}};", _corners(mesh), np.repeat(spacing[:, None], 3, axis=1))
    yield "};\n"


def _listed(count: int) -> str:
    return ",".join(["%r"] * count)


def _corners(mesh: Mesh) -> Floats:
    """Coordinates (t, 9) of the corners of triangles."""
    return np.insert(mesh.points, 2, 0.0, axis=1)[mesh.triangles].reshape(-1, 9)
