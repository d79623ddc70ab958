"""The plots of the page: quality and cost against the number of nodes, and quality by case."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchmarks.light import save
from benchmarks.peers.rows import Row
from benchmarks.peers.tools import OURS, TOOLS

CAPTIONS = {
    "peers-sizes.png": "What is missing to perfect quality, and the cost, of small to large meshes: lower is better",
    "peers-quality.png": "What is missing to perfect quality, and the spread of l/d, case by case: lower is better",
}
STYLES = {
    "bubblemesh-fast": ("#d1495b", "v"),
    "bubblemesh": ("#d1495b", "o"),
    "bubblemesh-best": ("#d1495b", "^"),
    "gmsh-frontal": ("#22303c", "s"),
    "gmsh-relocate": ("#22303c", "D"),
    "gmsh-delaunay": ("#22303c", "x"),
    "jigsaw": ("#2a7f62", "P"),
    "jigsaw-long": ("#2a7f62", "X"),
    "jigsaw-restarts": ("#2a7f62", "p"),
    "netgen": ("#3b7dd8", "h"),
    "triangle": ("#8d6fb0", "*"),
    "distmesh": ("#c98a2b", "+"),
}
LOSSES = {
    "1 - mean q": lambda row: 1 - row["mean"],
    "1 - 1 % q": lambda row: 1 - row["p01"],
    "1 - least q": lambda row: 1 - row["least"],
    "spread of l/d": lambda row: row["spread"],
}

Rows = Mapping[str, Mapping[str, Row]]


def draw(rows: Rows, sizes: list[str], folder: Path) -> None:
    """Draw the rows, by case and tool; ``sizes`` are the cases of the first plot."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, figure in zip(CAPTIONS, (_sizes(rows, sizes), _quality(rows)), strict=True):
        save(figure, folder / name)


def _sizes(rows: Rows, sizes: list[str]) -> Figure:
    figure = Figure(figsize=(11, 5.5), layout="constrained")
    quality, cost = figure.subplots(1, 2)
    quality.set(xlabel="nodes", ylabel="1 - mean quality", xscale="log", yscale="log")
    cost.set(xlabel="nodes", ylabel="CPU seconds", xscale="log", yscale="log")
    for tool, (color, marker) in STYLES.items():
        found = [rows[case][tool] for case in sizes if tool in rows[case] and not rows[case][tool].failure]
        if found:
            style = {"color": color, "marker": marker, "markersize": 5, "label": TOOLS[tool].label}
            nodes, mean, seconds = np.array([(row["nodes"], row["mean"], row["seconds"]) for row in found]).T
            quality.plot(nodes, 1 - mean, **style)
            cost.plot(nodes, seconds, **style)
            if tool == OURS:
                floor = seconds / [row["to_floor"] for row in found]
                cost.plot(nodes, floor, color=color, linestyle=":", label="one triangulation of the same nodes")
    _explain(figure, cost)
    return figure


def _quality(rows: Rows) -> Figure:
    figure = Figure(figsize=(9, 11), layout="constrained")
    panels = figure.subplots(len(LOSSES), 1, sharex=True)
    for axes, (title, loss) in zip(panels, LOSSES.items(), strict=True):
        axes.set(ylabel=title, yscale="log")
        axes.grid(axis="x", linewidth=0.3)
        for tool, (color, marker) in STYLES.items():
            values = [loss(rows[case][tool]) if tool in rows[case] else np.nan for case in rows]
            if np.isfinite(values).any():
                axes.plot(range(len(rows)), values, color=color, marker=marker, linestyle="", label=TOOLS[tool].label)
    panels[-1].set_xticks(range(len(rows)), list(rows), rotation=30, ha="right")
    _explain(figure, panels[0])
    return figure


def _explain(figure: Figure, axes: Axes) -> None:
    """Put the legend of one of its axes below the figure."""
    if axes.has_data():
        figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3, frameon=False)
