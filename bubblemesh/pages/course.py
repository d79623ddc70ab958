"""The part of a report's page on the course of the run."""

import math
from collections.abc import Mapping, Sequence
from typing import Any
from urllib.parse import quote

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.messages import duration
from bubblemesh.pages.charts import Line, bar, line_chart
from bubblemesh.pages.markup import Markup, joined, tag
from bubblemesh.pages.tables import cell, head, table

MOST_STEPS = 400  # points of the line of speeds


def course(report: Mapping[str, Any], speeds: Sequence[Floats]) -> Markup:
    """Quality over the rounds, mean speed over the steps, time by stage."""
    rounds, initial = report["rounds"], report["initial"]
    lines = [
        Line(name, [(0, initial[key]), *((row["round"], row[key]) for row in rounds)], marked=True)
        for name, key in (("mean q", "quality_mean"), ("least q", "quality_min"))
    ]
    charts = [line_chart("Quality over the rounds", "round, from the placement at 0", lines, 0.0, 1.0)]
    steps = np.concatenate([np.asarray(part, float) for part in speeds]) if speeds else np.zeros(0)
    moving = np.flatnonzero(np.isfinite(steps) & (steps > 0))
    if len(moving):
        shown = moving[np.unique(np.linspace(0, len(moving) - 1, MOST_STEPS).astype(int))]
        values = steps[shown]
        line = Line("mean speed", list(zip((shown + 1).tolist(), values.tolist(), strict=True)), marked=False)
        low, high = (10.0 ** side(np.log10(values[values > 0])) for side in (_floor, _ceiling))
        charts.append(line_chart("Mean speed over the steps", "step", [line], low, high, logarithmic=True))
    return joined(*charts, tag("div", _stages(report["seconds"]), class_="scroll"))


def _floor(exponents: Floats) -> int:
    return math.floor(exponents.min())


def _ceiling(exponents: Floats) -> int:
    return max(math.ceil(exponents.max()), math.floor(exponents.min()) + 1)


def _stages(seconds: Mapping[str, float]) -> Markup:
    total = seconds["total"]
    rows = [
        [cell(stage, text=True), cell(duration(time)), cell(joined(f"{time / total:.0%}", bar(time / total)))]
        for stage, time in seconds.items()
        if stage != "total"
    ]
    rows.append([cell("total", text=True), cell(duration(total)), cell("")])
    return table("Time by stage", [head("Stage", text=True), head("Time"), head("Share")], rows)


def files_list(files: Sequence[str]) -> Markup:
    """Links to the files of the run."""
    items = joined(*(tag("li", tag("a", name, href=f"./{quote(name)}")) for name in files))
    return joined(tag("h3", "Files of this run"), tag("ul", items)) if files else Markup("")


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
