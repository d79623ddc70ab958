"""Picture of how the meshes of many cases became good: quality over the steps of the packing."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from bubblemesh.arrays import Floats
from bubblemesh.pictures.plots import save_figure
from bubblemesh.pictures.styles import INK

MOST_NAMED = 20  # lines that the legend names
DASHES = ("-", "--", ":", "-.")
COLOURS = "cividis"


class Course(NamedTuple):
    """Mean quality (k,) of a case after so many steps (k,) of its packing."""

    name: str
    steps: Floats
    quality: Floats


def draw_convergence(courses: Sequence[Course], path: Path) -> None:
    """Draw the courses into a file; the same errors as `save_figure`."""
    save_figure(convergence_figure(courses), path)


def convergence_figure(courses: Sequence[Course]) -> Figure:
    """Figure with a line of 1 - q, on a logarithmic scale, for each course; the legend names the first ones."""
    named = len(courses) <= MOST_NAMED
    figure = Figure(figsize=(7.5 if named else 6.0, 4.2), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    colours = mpl.colormaps[COLOURS](np.linspace(0, 0.9, max(len(courses), 1)))
    for k, (name, steps, quality) in enumerate(courses):
        dash = DASHES[k % len(DASHES)]
        axes.plot(steps, 1 - quality, dash, color=colours[k], marker="o", markersize=2.5, linewidth=1.2, label=name)
    axes.set(yscale="log", xlabel="steps of the packing", ylabel="1 - mean quality")
    axes.grid(visible=True, which="both", linewidth=0.3)
    axes.tick_params(labelsize=8)
    if named and courses:
        legend = axes.legend(fontsize=7, frameon=False, loc="center left", bbox_to_anchor=(1, 0.5), labelcolor=INK)
        for text in legend.get_texts():
            text.set_parse_math(False)
    return figure
