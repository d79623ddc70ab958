"""Pictures of rings before and after a repair. The module imports matplotlib: import it only where one is drawn."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from bubblemesh.arrays import Floats
from bubblemesh.pictures.plots import save_figure
from bubblemesh.pictures.styles import BARE, INK, LABEL_COLOURS

LONG_SIDE = 6.0  # inches
CHANGED = LABEL_COLOURS[1]
MOST_MARKS = 200
MARGIN_SHARE = 0.03  # of the size


def draw_repairs(
    domain: shapely.Geometry, before: Sequence[Floats], places: Sequence[tuple[float, float]], path: Path
) -> None:
    """Draw rings (m, 2) before a repair and the domain after it, with the places of changes.

    CaseError if the path does not have the ending of a picture, FileError if it cannot be written.
    """
    save_figure(repairs_figure(domain, before, places), path)


def repairs_figure(domain: shapely.Geometry, before: Sequence[Floats], places: Sequence[tuple[float, float]]) -> Figure:
    """Figure of the rings that a repair changed, beside the domain after it, with marks at the places of changes."""
    points = np.concatenate([shapely.get_coordinates(domain), *before])
    (x0, y0), (x1, y1) = points.min(axis=0), points.max(axis=0)
    margin = MARGIN_SHARE * max(x1 - x0, y1 - y0)
    width, height = x1 - x0 + 2 * margin, y1 - y0 + 2 * margin
    inches = LONG_SIDE / max(width, height)
    side_by_side = height >= width / 2
    size = (2 * width * inches, height * inches + 0.4) if side_by_side else (width * inches, 2 * height * inches + 0.8)
    figure = Figure(figsize=(max(size[0], 3.0), max(size[1], 2.0)), layout="constrained")
    FigureCanvasAgg(figure)
    first, second = figure.subplots(1, 2) if side_by_side else figure.subplots(2, 1)
    rims = [shapely.get_coordinates(ring) for ring in shapely.get_rings(domain)]
    _lines(first, rims, INK, 0.4)
    _lines(first, [np.vstack([ring, ring[:1]]) for ring in before], CHANGED, 1.0)
    filled: Any = [_path_of(part) for part in shapely.get_parts(domain)]
    second.add_collection(PolyCollection(filled, facecolors=BARE, edgecolors="none"))
    _lines(second, rims, INK, 0.8)
    for axes, title in ((first, "before: what was changed"), (second, "after")):
        x, y = zip(*places[:MOST_MARKS], strict=True)
        axes.plot(x, y, "o", markersize=7, markerfacecolor="none", markeredgecolor=CHANGED, markeredgewidth=1.0)
        axes.set_aspect("equal")
        axes.set(xlim=(x0 - margin, x1 + margin), ylim=(y0 - margin, y1 + margin))
        axes.set_axis_off()
        axes.set_title(title, color=INK, fontsize=9)
    return figure


def _lines(axes: Axes, rings: Sequence[Floats], color: str, width: float) -> None:
    lines: Any = rings
    axes.add_collection(LineCollection(lines, colors=color, linewidths=width))


def _path_of(polygon: shapely.Polygon) -> Floats:
    """The outer ring of a polygon and its holes as one line (m, 2), which fills no hole."""
    outer = shapely.get_coordinates(polygon.exterior)
    holes = [np.vstack([shapely.get_coordinates(hole), outer[-1:]]) for hole in polygon.normalize().interiors]
    return np.vstack([outer, *holes])
