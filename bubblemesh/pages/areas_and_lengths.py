"""Section of a report's page on its regions and labels: the area of each region, the length of each label."""

from collections.abc import Mapping, Sequence
from typing import Any

from bubblemesh.messages import counted
from bubblemesh.pages.markup import Markup, cell, head, html, table, tag, whole

MOST_ROWS = 100  # regions or labels


def regions_and_labels(regions: Sequence[Mapping[str, Any]], labels: Sequence[Mapping[str, Any]]) -> Markup:
    """The section on the regions and labels of a report."""
    title = tag("h2", "Regions and labels", id="regions-title")
    areas = _table("Areas of regions", regions, "triangles", "area")
    lengths = _table("Lengths of labels", labels, "edges", "length")
    return tag("section", title, tag("div", areas, lengths, class_="charts"), aria_labelledby="regions-title")


def _table(caption: str, rows: Sequence[Mapping[str, Any]], cells: str, size: str) -> Markup:
    """Table of names with their number of cells and their area or length; what is beyond the first rows is counted."""
    heads = [head("Name", text=True), head(cells.capitalize()), head(size.capitalize())]
    body = [[cell(row["name"], text=True), cell(whole(row[cells])), cell(f"{row[size]:.6g}")] for row in rows]
    rest = len(rows) - MOST_ROWS
    note = tag("p", f"{counted(rest, 'more row')} in the JSON report.", class_="note") if rest > 0 else None
    return tag("div", html(table(caption, heads, body[:MOST_ROWS]), note), class_="scroll")
