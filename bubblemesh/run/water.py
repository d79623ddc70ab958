"""Figures of a mesh with depths: what models of tides ask of it."""

from typing import Self

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.meshes.cell_means import cell_means
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.shores import closed_facets, cut_off, dead_ends
from bubblemesh.records import record
from bubblemesh.spacing.terms.depth import NodeDepth, wave_speed


def depths_of(mesh: Mesh, depth: NodeDepth) -> Floats:
    """Depths (n,) at the nodes of a mesh; where they are means over cells, those on edges have that of both ends."""
    if depth.over is None:
        return np.asarray(depth.function(*mesh.points.T), float)
    corners = mesh.triangles[:, :3]
    means = cell_means(mesh.points, corners, depth.function, depth.over)
    for number, middle in enumerate(mesh.triangles[:, 3:].T):
        means[middle] = means[corners[:, [number, (number + 1) % 3]]].mean(axis=1)
    return means


def sea_figures(mesh: Mesh) -> dict[str, int]:
    """Numbers of triangles that are dead ends of a sea, and that are cut off from it."""
    return {"dead_ends": int(dead_ends(mesh).sum()), "cut_off": int(cut_off(mesh).sum())}


@record
class WaterRow:
    """Depths, the time step, neighbours, and triangles that water does not flow through.

    ``time_step`` is that in which long waves pass the edge that they pass first, in seconds: at a Courant number of 1;
    ``time_step_at`` the middle of that edge. ``land_triangles`` have all of their nodes on closed boundaries,
    ``dead_ends`` two sides; ``cut_off`` are those that are joined to the open sea by a point only. ``dry`` is the share
    of the nodes that are not below the water's level.
    """

    depth: tuple[float, float]
    dry: float
    time_step: float | None  # none where all is dry
    time_step_at: tuple[float, float] | None
    most_neighbours: int
    land_triangles: int
    dead_ends: int
    cut_off: int

    @classmethod
    def of(cls, mesh: Mesh) -> Self:
        """Figures of a mesh that has depths at its nodes, and whose lengths are metres."""
        corners, depth = mesh.triangles[:, :3], mesh.depth
        edges, _ = unique_edges(corners)
        ends = mesh.points[edges]
        deepest = depth[edges].max(axis=1)
        wet = deepest > 0
        times = np.full(len(edges), np.inf)
        times[wet] = np.hypot(*(ends[wet, 1] - ends[wet, 0]).T) / wave_speed(deepest[wet])
        first = int(np.argmin(times))
        x, y = ends[first].mean(axis=0).tolist()
        closed = np.zeros(len(mesh.points), bool)
        closed[closed_facets(mesh)] = True
        return cls(
            (float(depth.min()), float(depth.max())),
            float((depth <= 0).mean()),
            float(times[first]) if wet.any() else None,
            (x, y) if wet.any() else None,
            int(np.bincount(edges.ravel()).max()),
            int(closed[corners].all(axis=1).sum()),
            **sea_figures(mesh),
        )
