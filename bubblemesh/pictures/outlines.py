"""The boundary and the labelled edges in a picture."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from bubblemesh.arrays import Floats, Integers
from bubblemesh.meshes.edges import edge_keys, unique_edges
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.pictures.styles import INK, LABEL_COLOURS

MOST = 8  # labels that are told apart unless asked for
DASHES: tuple[Any, ...] = ("solid", (0, (4, 1.5)), (0, (1, 1)))


def add_outlines(
    axes: Axes, mesh: Mesh, box: Floats, *, told_apart: bool, all_labels: bool, width: float
) -> list[tuple[str, LineCollection]]:
    """Draw the boundary and the labelled edges.

    Parameters
    ----------
    axes : Axes
    mesh : Mesh
    box : (2, 2)
        Lower left and upper right corner of the part that is shown; labels elsewhere are left out.
    told_apart : bool
        Whether each label has a colour of its own, if there are few.
    all_labels : bool
        Whether that holds for many of them as well; then lines are dashed once the colours are used up.
    width : float
        Of the lines, in points.

    Returns
    -------
    list of tuple
        Name and lines of each label that has a colour of its own.
    """
    if not told_apart or (len(mesh.labels) > MOST and not all_labels):
        _add(axes, mesh, np.concatenate([mesh.facets[:, :2], _unlabelled(mesh)]), width, INK)
        return []
    _add(axes, mesh, _unlabelled(mesh), width, INK)
    found = []
    for index, label in enumerate(mesh.labels):
        turn, color = divmod(index, len(LABEL_COLOURS))
        mine = mesh.facets[mesh.facet_labels == index, :2]
        ends = mesh.points[mine]
        if ((ends.max(axis=1) >= box[0]) & (ends.min(axis=1) <= box[1])).all(axis=1).any():
            found.append((label, _add(axes, mesh, mine, width, LABEL_COLOURS[color], DASHES[turn % len(DASHES)])))
    return found


def _add(axes: Axes, mesh: Mesh, pairs: Integers, width: float, color: str, dash: Any = "solid") -> LineCollection:
    sides: Any = mesh.points[pairs]
    ends = "round" if dash == "solid" else "butt"
    lines = LineCollection(sides, colors=color, linewidths=width, capstyle=ends, linestyles=dash)
    axes.add_collection(lines)
    return lines


def _unlabelled(mesh: Mesh) -> Integers:
    """Boundary edges (b, 2) that are no facets."""
    pairs, counts = unique_edges(mesh.triangles[:, :3])
    boundary, n = pairs[counts == 1], len(mesh.points)
    labelled = edge_keys(np.sort(mesh.facets[:, :2], axis=1), n)
    return boundary[~np.isin(edge_keys(boundary, n), labelled)]
