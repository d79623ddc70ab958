"""Sections of a report's page: legends of the picture, the shape of the triangles, the rounds."""

import math
from collections.abc import Mapping, Sequence
from typing import Any
from urllib.parse import quote

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.meshes.histograms import histogram, lowest_shown, quality_histogram
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.metric import MeasuresInMetric, measures_of, spacing_along_edges
from bubblemesh.meshes.quality import TARGET_SPACING, angles, edge_means, edge_ratios
from bubblemesh.messages import counted, duration, place_in_mesh
from bubblemesh.pages.charts import ChartLine, bar, histogram_chart, line_chart
from bubblemesh.pages.markup import Markup, cell, head, html, table, tag, whole
from bubblemesh.pages.scene import Scene
from bubblemesh.pictures.colouring import standard_color
from bubblemesh.pictures.styles import LABEL_COLOURS, region_colour

DASHES = ("", "9 4", "2 3", "9 3 2 3")
COLOURINGS = {
    "quality": "Quality q",
    "size": "Edge length l",
    "ratio": "Edge length l/d",
    "region": "Region",
    "none": "None",
}


def colourings(mesh: Mesh) -> Markup:
    """Buttons that choose what the colours of the triangles show."""
    names = [name for name in COLOURINGS if name != "region" or len(mesh.regions) > 1]
    first = standard_color(len(mesh.triangles))
    return html(*(tag("option", COLOURINGS[name], value=name, selected=name == first) for name in names))


def scales(scene: Scene) -> Markup:
    """Legend of each colouring."""
    low, high = scene.quality.limits
    smallest, largest = scene.size.limits
    below, above = scene.ratio.limits
    regions = []
    for k, name in enumerate(scene.mesh.regions):
        sample = tag("rect", width=26, height=12, class_=f"region-{region_colour(k)}")
        regions.append(tag("li", tag("svg", sample, aria_hidden="true"), " ", name))
    legends = {
        "quality": _scale("Quality q", f"{low:g} or less", f"{high:g}, equilateral"),
        "size": _scale("Edge length l", f"{smallest:.3g} or less", f"{largest:.3g} or more"),
        "ratio": _scale("Edge length over wanted spacing", f"{below:.3g} or less", f"{above:.3g} or more"),
        "region": html(tag("h3", "Regions"), tag("ul", html(*regions), class_="legend")),
        "none": tag("h3", "Triangles without colour"),
    }
    first = standard_color(len(scene.corners))
    return html(*(tag("div", legends[name], data_legend=name, hidden=name != first) for name in legends))


def _scale(title: str, low: str, high: str) -> Markup:
    ends = tag("div", tag("span", low), tag("span", high), class_="ends")
    picture = tag("canvas", role="img", aria_label=f"Colours from {low} to {high}")
    return html(tag("h3", title), tag("div", picture, ends, class_="scale"))


def labels(mesh: Mesh) -> Markup:
    """The labels as buttons, each of which highlights its label."""
    counts = np.bincount(mesh.facet_labels, minlength=len(mesh.labels)).tolist()
    items = []
    for k, (name, count) in enumerate(zip(mesh.labels, counts, strict=True)):
        dashes = DASHES[k // len(LABEL_COLOURS) % len(DASHES)] or None
        kind = f"label-line label-{k % len(LABEL_COLOURS)}"
        line = tag("line", x1=1, y1=6, x2=25, y2=6, class_=kind, stroke_dasharray=dashes)
        sample = tag("svg", line, viewBox="0 0 26 12", aria_hidden="true")
        text = html(sample, name, " ", tag("span", whole(count), class_="soft"))
        state = {"data_label": str(k), "aria_pressed": "false", "title": f"{counted(count, 'edge')}: let it stand out"}
        items.append(tag("li", tag("button", text, type="button", class_="label", **state)))
    return html(tag("h3", "Labels and their edges"), tag("ul", html(*items), class_="legend"))


BINS = 25
FEW = 0.002  # share of the edges that a histogram may leave out at either end
LARGEST = 3.0  # edge length over spacing that a histogram shows


def histograms(scene: Scene, fields: Mapping[str, Floats]) -> Markup:
    """Histograms of quality, angles, and edge length over target spacing of the triangles that are not in layers."""
    points, corners = scene.mesh.points, scene.corners[scene.packed]
    q, corner_angles = scene.quality.values[scene.packed], angles(points, corners)
    sides, _ = unique_edges(corners)
    measures = measures_of(points, corners, {name: values[scene.packed] for name, values in fields.items()})
    if isinstance(measures, MeasuresInMetric):
        target = spacing_along_edges(measures)
    else:
        target = edge_means(corners, fields[TARGET_SPACING][scene.packed])
    ratios = edge_ratios(points, sides, target)
    low = lowest_shown(q)
    least = min(10 * math.floor(float(np.nanmin(corner_angles)) / 10), 50)
    most = max(10 * math.ceil(float(np.nanmax(corner_angles)) / 10), 70)
    few, many = np.quantile(ratios, [FEW, 1 - FEW])
    shortest, longest = min(math.floor(4 * few) / 4, 0.75), max(min(math.ceil(4 * many) / 4, LARGEST), 1.25)
    quarters = np.arange(shortest, longest + 0.01, 0.25 if longest - shortest < 2 else 0.5).tolist()
    fifths = np.linspace(low, 1, 5).tolist()
    return html(
        histogram_chart("Quality q", quality_histogram(q, BINS, low), "triangles", fifths),
        histogram_chart(
            "Angles, degrees",
            histogram(corner_angles.ravel(), least, most, BINS),
            "angles",
            [float(angle) for angle in range(least, most + 1, 10 if most - least <= 100 else 20)],
            ideal=60,
        ),
        histogram_chart("Edge length l/d", histogram(ratios, shortest, longest, BINS), "edges", quarters, ideal=1),
    )


def worst_triangles(scene: Scene) -> Markup:
    """A table of the worst triangles, with buttons that show them."""
    mesh = scene.mesh
    size = float(np.ptp(mesh.points, axis=0).max())
    rows = []
    for rank, t in enumerate(scene.worst.tolist()):
        corners = mesh.points[scene.corners[t]]
        x, y = corners.mean(axis=0).tolist()
        least = float(np.nanmin(angles(mesh.points, scene.corners[t : t + 1])))
        show = tag("button", "Show", type="button", class_="worst screen", data_rank=rank, title="Show in the mesh")
        cells = [f"{rank + 1}", f"{scene.quality.values[t]:.4f}", f"{least:.1f}°", f"{scene.ratio.values[t]:.3f}"]
        rows.append([cell(show), *map(cell, cells), cell(place_in_mesh((x, y), size)), cell(whole(t + 1))])
    heads = ["", "Rank", "q", "Least angle", "l/d", "Centre", "Triangle"]
    return table("Worst triangles", [head(name) for name in heads], rows)


MOST_STEPS = 400  # points of the line of speeds


def rounds_charts(report: Mapping[str, Any], speeds: Sequence[Floats]) -> Markup:
    """Quality over the rounds, mean speed over the steps, time by stage."""
    rounds, initial = report["rounds"], report["initial"]
    lines = [
        ChartLine(name, [(0, initial[key]), *((row["round"], row[key]) for row in rounds)], marked=True)
        for name, key in (("mean q", "quality_mean"), ("least q", "quality_min"))
    ]
    charts = [line_chart("Quality over the rounds", "round, from the placement at 0", lines, 0.0, 1.0)]
    steps = np.concatenate([np.asarray(part, float) for part in speeds]) if speeds else np.zeros(0)
    moving = np.flatnonzero(np.isfinite(steps) & (steps > 0))
    if len(moving):
        shown = moving[np.unique(np.linspace(0, len(moving) - 1, MOST_STEPS).astype(int))]
        values = steps[shown]
        line = ChartLine("mean speed", list(zip((shown + 1).tolist(), values.tolist(), strict=True)), marked=False)
        exponents = np.log10(values[values > 0])
        low = math.floor(exponents.min())
        high = max(math.ceil(exponents.max()), low + 1)
        charts.append(line_chart("Mean speed over the steps", "step", [line], 10.0**low, 10.0**high, logarithmic=True))
    return html(*charts, tag("div", _stages(report["seconds"]), class_="scroll"))


def _stages(seconds: Mapping[str, float]) -> Markup:
    total = seconds["total"]
    rows = [
        [cell(stage, text=True), cell(duration(time)), cell(html(f"{time / total:.0%}", bar(time / total)))]
        for stage, time in seconds.items()
        if stage != "total"
    ]
    rows.append([cell("total", text=True), cell(duration(total)), cell("")])
    return table("Time by stage", [head("Stage", text=True), head("Time"), head("Share")], rows)


def files_list(files: Sequence[str]) -> Markup:
    """Links to the files of the run."""
    items = html(*(tag("li", tag("a", name, href=f"./{quote(name)}")) for name in files))
    return html(tag("h3", "Files of this run"), tag("ul", items)) if files else Markup("")


def rounds_table(rounds: Sequence[Mapping[str, Any]]) -> Markup:
    """The figures of all rounds."""
    columns = {
        "round": ("Round", "d"),
        "iterations": ("Steps", "d"),
        "nodes_after": ("Nodes", "d"),
        "deleted": ("Deleted", "d"),
        "inserted": ("Inserted", "d"),
        "quality_mean": ("Mean q", ".4f"),
        "quality_min": ("Least q", ".3f"),
        "mean_speed": ("Mean speed", ".2e"),
        "seconds": ("Seconds", ".2f"),
    }
    rows = [[cell(format(row[key], form)) for key, (_, form) in columns.items()] for row in rounds]
    return table("Rounds", [head(name) for name, _ in columns.values()], rows)
