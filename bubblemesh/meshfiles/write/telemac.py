"""Telemac's geometry file in the SERAFIN format (.slf), with its file of boundary conditions (.cli).

References
----------
EDF R&D, "TELEMAC-2D User Manual", appendices on the SERAFIN format and the file of boundary conditions.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bubblemesh.arrays import Floats, Integers
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.shores import Stretch, boundary_rings, stretch_of_nodes, stretches
from bubblemesh.meshfiles.groups import Fields
from bubblemesh.meshfiles.text import lines, write_text
from bubblemesh.meshfiles.write.coasts import depths

TITLE, NAME = 72, 16  # characters
SINGLE, DOUBLE = "SERAFIN ", "SERAFIND"
BOTTOM = f"{'BOTTOM':{NAME}}{'M':{NAME}}"
MOST_MOVED = 1e-4  # of the shortest edge at a node, by which single precision may move it
# Codes of depth, velocities and tracer: a wall, and water whose level is prescribed.
WALL, OPEN = (2, 2, 2, 2), (5, 4, 4, 4)


def write_telemac(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write triangles with the height of the bed, and beside them the conditions and labels of boundary nodes.

    Numbers have double precision where single precision would move a node by more than 1e-4 of its shortest edge.
    Regions, inner lines, labelled points and fields are not written.
    """
    found = stretches(mesh)
    boundary = _boundary_nodes(mesh)
    path.write_bytes(_serafin(mesh, boundary))
    write_text(path.with_suffix(".cli"), _conditions(mesh, found, boundary))


def _boundary_nodes(mesh: Mesh) -> Integers:
    """Boundary nodes (b,) ring by ring, each once; the first ring begins with its node of least x + y."""
    first, *others = [mesh.facets[ring, 0] for ring in boundary_rings(mesh)]
    start = int(np.argmin(mesh.points[first].sum(axis=1)))
    nodes = np.concatenate([np.roll(first, -start), *others])
    return np.array(list(dict.fromkeys(nodes.tolist())), np.int64)


def _serafin(mesh: Mesh, boundary: Integers) -> bytes:
    """Content of the geometry file."""
    number, count = (">f8", len(mesh.points)) if _needs_double(mesh) else (">f4", len(mesh.points))
    on_boundary = np.zeros(count, np.int64)
    on_boundary[boundary] = np.arange(1, len(boundary) + 1)
    records = [
        f"{'mesh by bubblemesh':{TITLE}}{DOUBLE if number == '>f8' else SINGLE}".encode("ascii"),
        np.array([1, 0], ">i4"),
        BOTTOM.encode("ascii"),
        np.array([1, 0, 0, 0, 0, 0, 0, len(boundary), 0, 0], ">i4"),
        np.array([len(mesh.triangles), count, 3, 1], ">i4"),
        (mesh.triangles + 1).astype(">i4"),
        on_boundary.astype(">i4"),
        *(values.astype(number) for values in mesh.points.T),
        np.zeros(1, number),
        (0 - depths(mesh)).astype(number),
    ]
    return b"".join(map(_record, records))


def _record(content: bytes | NDArray[np.generic]) -> bytes:
    """A record of a sequential file of Fortran: its length comes before and after it."""
    data = content if isinstance(content, bytes) else content.tobytes()
    length = np.array(len(data), ">i4").tobytes()
    return length + data + length


def _needs_double(mesh: Mesh) -> bool:
    moved = np.hypot(*(mesh.points.astype(np.float32) - mesh.points).T)
    shortest = _shortest_edges(mesh.points, mesh.triangles)
    return bool((moved > MOST_MOVED * shortest).any())


def _shortest_edges(points: Floats, triangles: Integers) -> Floats:
    """Length (n,) of the shortest edge at each node."""
    shortest = np.full(len(points), np.inf)
    for k in range(3):
        ends = triangles[:, [k, (k + 1) % 3]]
        length = np.hypot(*(points[ends[:, 1]] - points[ends[:, 0]]).T)
        for end in ends.T:
            np.minimum.at(shortest, end, length)
    return shortest


def _conditions(mesh: Mesh, found: list[Stretch], boundary: Integers) -> list[str]:
    """A line for each boundary node: its codes, values of 0, its number, its place, and a remark with its label."""
    of_node = stretch_of_nodes(found, len(mesh.points))[boundary]
    codes = np.array([OPEN if each.kind == "open" else WALL for each in found])[of_node]
    remarks = np.array([f"{each.kind}: {each.label}" for each in found], object)[of_node]
    form = "%d %d %d 0.0 0.0 0.0 0.0 %d 0.0 0.0 0.0 %d %d # %s"
    return list(lines(form, codes, boundary + 1, np.arange(1, len(boundary) + 1), remarks))
