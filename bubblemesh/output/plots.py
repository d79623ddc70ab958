"""Pictures of meshes. The module imports matplotlib, and is to be imported where a picture is drawn."""

from pathlib import Path
from typing import Any, Literal

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure

from bubblemesh.arrays import Floats
from bubblemesh.errors import CaseError
from bubblemesh.meshes import Mesh
from bubblemesh.output.atomic import transaction
from bubblemesh.quality import radius_ratios

__all__ = ["draw_mesh", "mesh_figure"]

_ENDINGS = (".png", ".svg")
_MAX_LEGEND = 8
_MAX_VECTORS = 5000
_POINTS_PER_INCH = 72
_LONG_SIDE = 7.5
_WIDE = 1.6
_INK = "#22303c"
_PLAIN = "#eef3f6"
# Good triangles are pale and calm, so that the bad ones and the boundary are what one sees.
_QUALITIES = LinearSegmentedColormap.from_list("quality", ["#a50f3c", "#e8683f", "#fbc66a", "#d8ebe4", "#7fb8c4"])
_LABELS = ("#1f5fa8", "#d1495b", "#2e8b57", "#8e44ad", "#c9820a", "#00798c", "#7f4f24", "#4a4e69")


def draw_mesh(
    mesh: Mesh, path: Path, *, color: Literal["quality", "plain"] = "quality", title: str | None = None
) -> None:
    """Draw a mesh: its triangles coloured by radius ratio, its boundary by label.

    Parameters
    ----------
    mesh : Mesh
    path : Path
        Ends with ``.png`` or ``.svg``; large meshes become a bitmap inside the svg.
    color : {"quality", "plain"}
        What the colour of the triangles shows.
    title : str, optional

    Raises
    ------
    CaseError
        If the path has another ending.
    FileError
        If the file cannot be written.
    """
    if path.suffix not in _ENDINGS:
        raise CaseError(f"{path}: unknown ending {path.suffix!r} for a picture: choose one of {', '.join(_ENDINGS)}")
    figure = mesh_figure(mesh, color=color, title=title)
    # Without a date and with fixed ids the same mesh gives the same bytes.
    metadata = {"Date": None} if path.suffix == ".svg" else {}
    with mpl.rc_context({"svg.hashsalt": "bubblemesh"}), transaction(path.parent) as staging:
        figure.savefig(staging / path.name, dpi=120, metadata=metadata, bbox_inches="tight", pad_inches=0.12)


def mesh_figure(mesh: Mesh, *, color: Literal["quality", "plain"] = "quality", title: str | None = None) -> Figure:
    """Picture of a mesh, as `draw_mesh` writes it."""
    width, height = np.ptp(mesh.points, axis=0)
    inches_per_unit = _LONG_SIDE / max(width, height)
    # Room for colour bar and legend; what stays empty is cut off on saving.
    size = (max(width * inches_per_unit, 2.5) + 1.2, max(height * inches_per_unit, 2.0) + 1.0)
    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    edge = inches_per_unit * _POINTS_PER_INCH * _typical_edge(mesh)
    _add_triangles(figure, axes, mesh, color, line_width=float(np.clip(0.025 * edge, 0.08, 0.5)))
    _add_boundary(axes, mesh, line_width=float(np.clip(0.15 * edge, 1.2, 2.2)))
    _arrange(axes, mesh, title)
    return figure


def _typical_edge(mesh: Mesh) -> float:
    sides = mesh.points[mesh.triangles[:, 1]] - mesh.points[mesh.triangles[:, 0]]
    return float(np.median(np.hypot(sides[:, 0], sides[:, 1])))


def _add_triangles(figure: Figure, axes: Axes, mesh: Mesh, color: str, line_width: float) -> None:
    # An array is drawn much faster than a list of arrays, but matplotlib's annotations do not know it.
    corners: Any = mesh.points[mesh.triangles[:, :3]]
    triangles = PolyCollection(corners, edgecolors=_INK, linewidths=line_width)
    triangles.set_rasterized(len(mesh.triangles) > _MAX_VECTORS)
    axes.add_collection(triangles)
    if color == "plain":
        triangles.set_facecolor(_PLAIN)
        return
    ratios = radius_ratios(mesh.points, mesh.triangles[:, :3])
    triangles.set(array=ratios, cmap=_QUALITIES, norm=Normalize(_lowest_shown(ratios), 1))
    below = bool(ratios.min() < _lowest_shown(ratios))
    width, height = np.ptp(mesh.points, axis=0)
    bar = figure.colorbar(
        triangles,
        ax=axes,
        location="bottom" if width > _WIDE * height else "right",
        shrink=0.7,
        aspect=30,
        pad=0.02,
        extend="min" if below else "neither",
    )
    bar.set_label(f"radius ratio   (mean {ratios.mean():.3f}, min {ratios.min():.3f})", color=_INK)
    bar.outline.set_visible(False)
    bar.ax.tick_params(color=_INK, labelcolor=_INK, labelsize=9)


def _lowest_shown(ratios: Floats) -> float:
    """Return a round number below nearly all ratios, so that the colours spread over what the mesh has."""
    return float(np.clip(np.floor(10 * np.quantile(ratios, 0.01)) / 10, 0, 0.8))


def _add_boundary(axes: Axes, mesh: Mesh, line_width: float) -> None:
    told_apart = len(mesh.labels) <= _MAX_LEGEND
    for index, label in enumerate(mesh.labels):
        sides: Any = mesh.points[mesh.facets[mesh.facet_labels == index, :2]]
        lines = LineCollection(
            sides,
            colors=_LABELS[index] if told_apart else _INK,
            linewidths=line_width,
            capstyle="round",
            label=label,
        )
        axes.add_collection(lines)
    if told_apart:
        columns = len(mesh.labels) if len(mesh.labels) <= _MAX_LEGEND - 3 else _MAX_LEGEND // 2
        legend = axes.legend(
            loc="upper center", bbox_to_anchor=(0.5, -0.005), ncols=columns, frameon=False, labelcolor=_INK
        )
        for line, text in zip(legend.get_lines(), legend.get_texts(), strict=True):
            line.set_linewidth(2.2)
            text.set_parse_math(False)


def _arrange(axes: Axes, mesh: Mesh, title: str | None) -> None:
    axes.set_aspect("equal")
    axes.margins(0.01)
    axes.autoscale_view()
    axes.set_axis_off()
    if title is not None:
        axes.set_title(title, color=_INK, fontsize=13, pad=8, parse_math=False)
