"""The paper's figures, drawn from our runs."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from benchmarks.light import save
from benchmarks.paper.runs import Runs
from bubblemesh.packing.viscosity import OddBubbles, SawTooth
from bubblemesh.problem.prepare import prepare

INK, ACCENT, PALE = "#22303c", "#d1495b", "#d8e6ec"
METHODS = {"BPM": "table-1", "FNPBS": "table-4", "accelerated": "table-5/example-3-accelerated"}


@dataclass(frozen=True)
class Drawing:
    """A figure of the paper: its file, its caption, the cases whose runs it shows, and how it is made of these."""

    file: str
    caption: str
    cases: tuple[str, ...]
    made_of: Callable[..., Figure]


def save_drawing(drawing: Drawing, runs: Mapping[str, Runs], path: Path) -> None:
    """Write a figure to a file, whose ending is ``.svg`` or ``.png``."""
    path.parent.mkdir(parents=True, exist_ok=True)
    save(drawing.made_of(*(runs[name] for name in drawing.cases)), path)


def _viscosity() -> Figure:
    figure = Figure(figsize=(7, 3.2), layout="constrained")
    axes = figure.add_subplot(xlabel="step", ylabel="viscosity c")
    saw, odd = SawTooth(), OddBubbles()
    steps = np.arange(5 * 250)
    normal = np.array([saw(int(step % 250), int(step // 250)) for step in steps])
    marked = np.isin(steps // 250, [1, 3])
    axes.plot(steps, normal, color=INK, label="normal bubble")
    axes.plot(steps, np.where(marked, odd.c_odd, normal), color=ACCENT, linestyle="--", label="odd bubble")
    axes.legend(frameon=False)
    return figure


def _dense(coarse: Runs, dense: Runs) -> Figure:
    figure = Figure(figsize=(10, 10), layout="constrained")
    axes = figure.subplots(2, 2)
    _nodes(axes[0, 0], coarse.first.mesh.points)
    _nodes(axes[0, 1], dense.first.mesh.points)
    for place in axes[1]:
        _mesh(place, dense)
    axes[1, 1].set(xlim=(1.0, 2.0), ylim=(1.0, 2.0))
    for place, title in zip(axes.flat, ("Example 3", "dense variant", "its mesh", "a part of it"), strict=True):
        place.set_title(title)
    return figure


def _start_and_end(run: Runs) -> Figure:
    problem = prepare(run.case)
    start = problem.method.placement(problem.domain, problem.packing_spacing, run.case.limits.max_nodes)
    figure = Figure(figsize=(10, 5), layout="constrained")
    for axes, points in zip(figure.subplots(1, 2), (start.x, run.first.mesh.points), strict=True):
        _nodes(axes, points)
        axes.set_title(f"{len(points)} nodes")
    return figure


def _quality(run: Runs) -> Figure:
    figure = Figure(figsize=(7, 3.2), layout="constrained")
    axes = figure.add_subplot(xlabel="iterations", ylabel="q", ylim=(0, 1))
    report = run.first.report
    iterations = np.cumsum([0, *(row["iterations"] for row in report["rounds"])])
    for key, color, label in (("quality_mean", INK, "mean"), ("quality_min", ACCENT, "least")):
        values = [report["initial"][key], *(row[key] for row in report["rounds"])]
        axes.plot(iterations, values, color=color, marker="o", markersize=3, label=label)
    axes.legend(frameon=False, loc="lower right")
    return figure


def _examples(*runs: Runs) -> Figure:
    figure = Figure(figsize=(10, 17), layout="constrained")
    for (left, right), run in zip(figure.subplots(4, 2), runs, strict=True):
        _nodes(left, run.first.mesh.points)
        _mesh(right, run)
    return figure


def _speeds(*runs: Runs) -> Figure:
    figure = Figure(figsize=(7, 6), layout="constrained")
    places = figure.subplots(len(runs), 1, sharex=True)
    for axes, name, run in zip(places, METHODS, runs, strict=True):
        axes.semilogy(np.concatenate(run.first.speeds), color=INK, linewidth=0.8)
        axes.set(ylabel="mean speed", title=name)
    places[-1].set_xlabel("step")
    return figure


def _nodes(axes: Axes, points: np.ndarray) -> None:
    axes.plot(*points.T, ".", color=INK, markersize=2.5)
    _bare(axes)


def _mesh(axes: Axes, run: Runs) -> None:
    mesh = run.first.mesh
    axes.add_collection(PolyCollection(mesh.points[mesh.triangles], facecolors=PALE, edgecolors=INK, linewidths=0.4))
    axes.autoscale_view()
    _bare(axes)


def _bare(axes: Axes) -> None:
    axes.set_aspect("equal")
    axes.set_axis_off()


DRAWINGS = {
    2: Drawing(
        "fig-02.svg", "Fig. 2: viscosity of a normal bubble, and of one that is odd in rounds 2 and 4", (), _viscosity
    ),
    3: Drawing(
        "fig-03.png",
        "Fig. 3: nodes of Example 3 and of its dense variant, the mesh of the latter and a part of it",
        ("section-2.2/coarse-with", "section-2.2/dense-with"),
        _dense,
    ),
    5: Drawing("fig-05.png", "Fig. 5: initial and final nodes of Example 3 by FNPBS", ("table-4",), _start_and_end),
    7: Drawing(
        "fig-07.svg",
        "Fig. 7: mean and least q of Example 3 over the iterations of FNPBS",
        ("table-5/example-3-fnpbs",),
        _quality,
    ),
    9: Drawing(
        "fig-09.svg",
        "Fig. 9: mean and least q of Example 1 over the iterations of FNPBS",
        ("table-5/example-1-fnpbs",),
        _quality,
    ),
    10: Drawing(
        "fig-10.svg",
        "Fig. 10: mean and least q of Example 2 over the iterations of FNPBS",
        ("table-5/example-2-fnpbs",),
        _quality,
    ),
    11: Drawing(
        "fig-11.png",
        "Fig. 11: nodes and meshes of Examples 1 to 4 by the accelerated method",
        tuple(f"table-5/example-{number}-accelerated" for number in (1, 2, 3, 4)),
        _examples,
    ),
    12: Drawing(
        "fig-12.svg",
        "Fig. 12: mean speed of the bubbles of Example 3 by the three methods",
        tuple(METHODS.values()),
        _speeds,
    ),
}
