"""Pictures of a spacing. The module imports matplotlib: import it only where a picture is drawn."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import ListedColormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from bubblemesh.arrays import Floats
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.pictures.colouring import FIELD, WIDE, Colouring, add_colour_bar
from bubblemesh.pictures.names import add_names
from bubblemesh.pictures.outlines import add_legend
from bubblemesh.pictures.plots import box_of, is_tall, mesh_figure, require_picture, save_figure
from bubblemesh.pictures.styles import INK, PlotOptions

UNIFORM = 1e-6  # relative difference up to which all values have one colour
ASIDE = 9  # points from a mark to its text
LITTLE = 0.01  # share of the area
# Colours of what sets the spacing: they also differ in lightness, for colour-blind readers.
SETTERS = (
    "#88ccee", "#ddcc77", "#117733", "#cc6677", "#332288", "#aa4499", "#44aa99", "#999933", "#882255", "#bbbbbb",
    "#661100", "#6699cc",
)  # fmt: skip

Extreme = tuple[float, tuple[float, float]]


def draw_spacing(
    mesh: Mesh, spacing: Floats, extremes: tuple[Extreme, Extreme], path: Path, title: str, ruling: Sequence[str] = ()
) -> None:
    """Draw a spacing into a file; the arguments of `spacing_figure`, the errors of `save_figure`."""
    require_picture(path)
    save_figure(spacing_figure(mesh, spacing, extremes, title, ruling), path)


def spacing_figure(
    mesh: Mesh,
    spacing: Floats,
    extremes: tuple[Extreme, Extreme],
    title: str | None = None,
    ruling: Sequence[str] = (),
) -> Figure:
    """Filled colour map of a spacing, with the boundary and the names of labels, regions and points.

    Parameters
    ----------
    mesh
        A mesh that is fine enough to show the spacing.
    spacing
        Values (n,) at its nodes.
    extremes
        The least and the largest value with their places (x, y), which are marked if they differ.
    title
        Title of the figure.
    ruling
        Names (t,) of what sets the spacing in each triangle; they have a panel of their own if they differ.
    """
    options = PlotOptions(color="label" if mesh.labels else "none", edges=False, title=title)
    divided = len(set(ruling)) > 1
    figure = mesh_figure(mesh, options, also=[PlotOptions(color="none", edges=False, labels=False)] if divided else [])
    axes = figure.axes[0]
    if divided:
        _colour_by_name(figure.axes[1], mesh, ruling, options)
    (low, _), (high, _) = extremes
    uniform = high - low <= UNIFORM * high
    norm = LogNorm(low, high) if high > WIDE * low else Normalize(low, high)
    if uniform:  # rounding errors must not fill the scale
        norm = Normalize(0.99 * low, 1.01 * high)
    triangles = Triangulation(mesh.points[:, 0], mesh.points[:, 1], mesh.triangles)
    colours = axes.tripcolor(triangles, spacing, shading="gouraud", cmap=FIELD, norm=norm, rasterized=True, zorder=1.5)
    colouring = Colouring(spacing, "", mpl.colormaps[FIELD], (low, high), logarithmic=isinstance(norm, LogNorm))
    add_colour_bar(axes, colours, colouring, options.look, aside=is_tall(box_of(mesh), options))
    bar: Any = colours.colorbar
    bar.set_label("spacing d", color=INK)
    add_names(axes, mesh)
    for (value, place), marker, what in zip(extremes, "vo", ("least", "largest"), strict=True):
        if not uniform:
            _mark(axes, place, marker, f"{what} {value:.4g}")
    return figure


def _colour_by_name(axes: Axes, mesh: Mesh, names: Sequence[str], options: PlotOptions) -> None:
    """Colour triangles by names (t,), with their shares of the area in the legend, the largest first."""
    area = signed_areas(mesh.points, mesh.triangles[:, :3])
    known, number = np.unique(names, return_inverse=True)
    share = np.bincount(number, area) / area.sum()
    order = np.argsort(-share, kind="stable")
    rank = np.argsort(order)[number]
    colours = ListedColormap([SETTERS[k % len(SETTERS)] for k in range(len(known))])
    told = tuple(f"{known[k]} {_percent(share[k])}" for k in order.tolist())
    colouring = Colouring(rank.astype(float), "", colours, (-0.5, len(known) - 0.5), told)
    triangles: Any = mesh.points[mesh.triangles[:, :3]]
    shown = PolyCollection(triangles, array=colouring.values, cmap=colours, norm=colouring.norm, zorder=1.5)
    shown.set(edgecolors="face", linewidths=0.1, rasterized=len(rank) > options.look.most_vectors)
    axes.add_collection(shown)
    axes.set_title("what sets it", color=INK, fontsize=float(mpl.rcParams["font.size"]), pad=6)
    add_legend(axes, [], colouring)


def _percent(share: float) -> str:
    return f"{share:.0%}" if share >= LITTLE else f"< {LITTLE:.0%}"


def _mark(axes: Axes, place: tuple[float, float], marker: str, text: str) -> None:
    """Add a mark, with its text on the side where there is room."""
    axes.plot(*place, marker, color="white", markersize=7, markeredgecolor=INK, markeredgewidth=1.2, zorder=5)
    (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()
    right, up = place[0] < (x0 + x1) / 2, place[1] < (y0 + y1) / 2
    axes.annotate(
        text,
        place,
        xytext=(ASIDE if right else -ASIDE, ASIDE if up else -ASIDE),
        textcoords="offset points",
        ha="left" if right else "right",
        va="bottom" if up else "top",
        color=INK,
        bbox={"boxstyle": "round,pad=0.25", "facecolor": "white", "edgecolor": "none", "alpha": 0.8},
        zorder=5,
        parse_math=False,
    )
