"""The boundary and the labelled edges in a picture, and the legend of lines and regions."""

from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.transforms import ScaledTranslation

from bubblemesh.arrays import Floats, Integers
from bubblemesh.meshes.edges import edge_keys, unique_edges
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.pictures.colouring import Colouring
from bubblemesh.pictures.styles import INK, LABEL_COLOURS

MOST_APART = 8  # labels that have colours of their own by default
MOST_ENTRIES = 24  # of a legend
IN_A_ROW = 5
LINE = 2.2  # points, in the legend
DASHES: tuple[Any, ...] = ("solid", (0, (4, 1.5)), (0, (1, 1)))


def add_outlines(
    axes: Axes, mesh: Mesh, box: Floats, *, told_apart: bool, all_labels: bool, width: float
) -> list[tuple[str, LineCollection]]:
    """Draw the boundary and the labelled edges, and return name and lines of each label with a colour of its own.

    Parameters
    ----------
    axes
        Where to draw.
    mesh
        The mesh.
    box
        Lower left and upper right corner (2, 2) of what is shown; labels outside are left out.
    told_apart
        Whether labels get colours of their own, if they are few.
    all_labels
        Whether they get them however many they are; lines are dashed when the colours are used up.
    width
        Width of the lines in points.
    """
    if not told_apart or (len(mesh.labels) > MOST_APART and not all_labels):
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
    """Boundary edges (b, 2) that are not facets."""
    pairs, counts = unique_edges(mesh.triangles[:, :3])
    boundary, n = pairs[counts == 1], len(mesh.points)
    labelled = edge_keys(np.sort(mesh.facets[:, :2], axis=1), n)
    return boundary[~np.isin(edge_keys(boundary, n), labelled)]


def add_legend(axes: Axes, outlines: Sequence[tuple[str, LineCollection]], colouring: Colouring | None) -> None:
    """Add a legend with the names of lines and regions."""
    entries: list[tuple[str, Artist]] = []
    if colouring is not None and colouring.names:
        entries += [
            (name, Patch(facecolor=colouring.colormap(k), edgecolor=INK, linewidth=0.4))
            for k, name in enumerate(colouring.names)
        ]
    entries += [(name, _sample(lines)) for name, lines in outlines]
    if not entries:
        return
    if len(entries) > MOST_ENTRIES:
        more = f"and {len(entries) - MOST_ENTRIES + 1} more"
        entries = [*entries[: MOST_ENTRIES - 1], (more, Line2D([], [], linewidth=0))]
    columns = len(entries) if len(entries) <= IN_A_ROW else IN_A_ROW - 1
    while _legend(axes, entries, columns).get_window_extent().width > axes.figure.bbox.width and columns > 1:
        columns -= 1


def _legend(axes: Axes, entries: Sequence[tuple[str, Artist]], columns: int) -> Legend:
    """Legend of names and artists below the axes, in some columns."""
    legend = axes.legend(
        [handle for _, handle in entries],
        [name for name, _ in entries],
        loc="upper center",
        bbox_to_anchor=(0.5, 0),
        bbox_transform=axes.transAxes + ScaledTranslation(0, -_below(axes) / 72, axes.figure.dpi_scale_trans),
        ncols=columns,
        frameon=False,
        labelcolor=INK,
        handlelength=1.8,
        columnspacing=1.6,
    )
    for text in legend.get_texts():
        text.set_parse_math(False)
    return legend


def _below(axes: Axes) -> float:
    """Distance in points below the axes from which on there is room."""
    return 2 + (1.6 * float(mpl.rcParams["font.size"]) if axes.axison else 0)


def _sample(lines: LineCollection) -> Line2D:
    color, dash = lines.get_colors()[0], lines.get_linestyle()[0]
    return Line2D([], [], color=color, linewidth=LINE, linestyle=dash)  # type: ignore[arg-type]
