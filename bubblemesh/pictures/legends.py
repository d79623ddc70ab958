"""Legend and colour bar of a picture."""

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from bubblemesh.pictures.colouring import Colouring
from bubblemesh.pictures.styles import INK, Style

MOST = 24  # entries
IN_A_ROW = 5
LINE = 2.2  # points


def add_legend(axes: Axes, outlines: Sequence[tuple[str, LineCollection]], colouring: Colouring | None) -> None:
    """Add what the colours of lines and regions are called."""
    entries: list[tuple[str, Artist]] = []
    if colouring is not None and colouring.names:
        entries += [
            (name, Patch(facecolor=colouring.colormap(k), edgecolor=INK, linewidth=0.4))
            for k, name in enumerate(colouring.names)
        ]
    entries += [(name, _sample(lines)) for name, lines in outlines]
    if not entries:
        return
    if len(entries) > MOST:
        entries = [*entries[: MOST - 1], (f"and {len(entries) - MOST + 1} more", Line2D([], [], linewidth=0))]
    columns = len(entries) if len(entries) <= IN_A_ROW else IN_A_ROW - 1
    while _legend(axes, entries, columns).get_window_extent().width > axes.figure.bbox.width and columns > 1:
        columns -= 1


def _legend(axes: Axes, entries: Sequence[tuple[str, Artist]], columns: int) -> Legend:
    legend = axes.legend(
        [handle for _, handle in entries],
        [name for name, _ in entries],
        loc="upper center",
        bbox_to_anchor=(0.5, -0.005),
        ncols=columns,
        frameon=False,
        labelcolor=INK,
        handlelength=1.8,
        columnspacing=1.6,
    )
    for text in legend.get_texts():
        text.set_parse_math(False)
    return legend


def _sample(lines: LineCollection) -> Line2D:
    color, dash = lines.get_colors()[0], lines.get_linestyle()[0]
    return Line2D([], [], color=color, linewidth=LINE, linestyle=dash)  # type: ignore[arg-type]


def add_colour_bar(
    figure: Figure, axes: Axes, triangles: ScalarMappable, colouring: Colouring, style: Style, *, aside: bool
) -> None:
    """Add the scale of the colours, beside the mesh or below it."""
    values, (low, high) = colouring.values, colouring.limits
    below, above = bool(np.nanmin(values) < low), bool(np.nanmax(values) > high)
    bar = figure.colorbar(
        triangles,
        ax=axes,
        location="right" if aside else "bottom",
        shrink=0.7,
        aspect=style.bar,
        pad=0.02,
        extend={(True, True): "both", (True, False): "min", (False, True): "max"}.get((below, above), "neither"),
    )
    told = f"   (mean {np.nanmean(values):.3f}, min {np.nanmin(values):.3f})" if style.figures else ""
    bar.set_label(colouring.title + told, color=INK, parse_math=False)
    # Else matplotlib makes a bitmap of the scale; edges of the faces' own colour close the hairlines in it.
    bar.solids.set(rasterized=False, edgecolor="face")  # type: ignore[union-attr]
    bar.outline.set_visible(False)
    size = 0.9 * float(mpl.rcParams["font.size"])
    bar.ax.tick_params(color=INK, labelcolor=INK, labelsize=size, width=0.5)
