"""Section of a report's page on its regions and labels: the area of each region, the length of each label."""

from collections.abc import Mapping, Sequence
from typing import Any

from bubblemesh.meshes.periodic import motion_text
from bubblemesh.messages import counted
from bubblemesh.pages.markup import Markup, cell, head, html, table, tag, whole

MOST_ROWS = 100  # regions or labels


def regions_and_labels(report: Mapping[str, Any]) -> Markup:
    """The section on the regions, labels and periodic sides of a report."""
    title = tag("h2", "Regions and labels", id="regions-title")
    areas = _table("Areas of regions", report["regions"], "triangles", "area")
    lengths = _table("Lengths of labels", report["labels"], "edges", "length")
    parts = title, tag("div", areas, lengths, class_="charts"), _periodic(report)
    return tag("section", *parts, aria_labelledby="regions-title")


def _periodic(report: Mapping[str, Any]) -> Markup | None:
    """Sentence on the motions of periodic sides, if there are any."""
    x0, y0, x1, y1 = report["bounds"]
    motions = [motion_text(row, max(x1 - x0, y1 - y0)) for row in report.get("periodic_sides", ())]
    return tag("p", f"Periodic sides: {'; '.join(motions)}.") if motions else None


def _table(caption: str, rows: Sequence[Mapping[str, Any]], cells: str, size: str) -> Markup:
    """Table of names with their number of cells and their area or length; what is beyond the first rows is counted."""
    heads = [head("Name", text=True), head(cells.capitalize()), head(size.capitalize())]
    body = [[cell(row["name"], text=True), cell(whole(row[cells])), cell(f"{row[size]:.6g}")] for row in rows]
    rest = len(rows) - MOST_ROWS
    note = tag("p", f"{counted(rest, 'more row')} in the JSON report.", class_="note") if rest > 0 else None
    return tag("div", html(table(caption, heads, body[:MOST_ROWS]), note), class_="scroll")
