"""Section of a report's page on boundary layers: their figures on each label, and a picture at the wall."""

import base64
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.messages import place_in_mesh
from bubblemesh.pages.markup import Markup, cell, head, html, linked_places, table, tag, whole
from bubblemesh.pictures.plots import small_png
from bubblemesh.pictures.styles import PlotOptions, View

HIGH, WIDE = 2.5, 2.5  # half the width of the picture: the larger of so many heights of layers or edges of the wall
FLAT = 0.5  # height of the picture over its width
DPI = 110
HEADS = ("Layers", "Columns", "Complete", "First height", "Kept", "Height", "Angles", "Aspect", "Beyond", "Lowest")
MEANING = (
    "Complete: columns with all layers at full height. First height: that of the case, times the mean of what came "
    "out over it. Kept: share of the wall on which it is that of the case to 5 %. Height: mean of the columns. "
    "Angles: the least between a column and the wall, and the largest of the cells as triangles. Aspect: largest "
    "width of a cell over its height. Beyond: height of the triangles on the last layer over that of this layer. "
    "Lowest: a column with the fewest layers, if some lack any. Quality and edge lengths are those of the triangles "
    "beside the layers."
)


def layers_section(mesh: Mesh, rows: Sequence[Mapping[str, Any]], *, in_plane: bool) -> Markup:
    """The section on the layers of a report, with a row for each label; empty if there are no rows.

    The places and lengths of the rows are those of the mesh if it is written in the plane of its packing; else the
    section shows none of them in it.
    """
    if not rows:
        return Markup("")
    size = float(np.ptp(mesh.points, axis=0).max())
    heads = [head("Label", text=True), *map(head, HEADS)]
    figures = table("On each label", heads, [list(_cells(row, size if in_plane else None)) for row in rows])
    title = tag("h2", "Boundary layers", id="layers-title")
    picture = _picture(mesh, rows, size) if in_plane else ""
    parts = tag("div", figures, class_="scroll dense"), tag("p", MEANING, class_="note"), picture
    return tag("section", title, *parts, aria_labelledby="layers-title")


def _cells(row: Mapping[str, Any], size: float | None) -> Iterator[Markup]:
    """Cells with the figures of the layers on a label, and a place in a mesh of a size if that is given."""
    first, count, upright = row["first"], row["count"], row["orthogonality"]
    yield cell(row["label"] if row["region"] is None else f"{row['label']} in {row['region']}", text=True)
    least, most = count["least"], count["most"]
    number = f"{most}" if least == most else f"{least} to {most}"
    yield cell(number if most == count["wanted"] else f"{number} of {count['wanted']}")
    yield cell(whole(row["columns"]))
    yield cell(f"{row['complete']:.1%}")
    yield cell(f"{row['wanted']:.3g} x {first['mean']:.3f}" if first else "")
    yield cell(f"{first['kept']:.1%}" if first else "")
    yield cell(f"{row['thickness']:.3g}")
    yield cell(f"{upright['least']:.0f}, {row['angle_max']['degrees']:.0f}°" if upright else "")
    yield cell(f"{row['aspect']:.3g}" if first else "")
    yield cell("" if row["across_front"] is None else f"{row['across_front']:.2f}")
    lowest = next(iter(row["shortest"]), None)
    at = f" at {place_in_mesh(lowest['at'], size)}" if lowest and size else ""
    yield cell(linked_places(f"{lowest['layers']}{at}" if lowest else ""))


def _picture(mesh: Mesh, rows: Sequence[Mapping[str, Any]], size: float) -> Markup:
    """Picture of the mesh where columns lack most layers, or in the middle of the first wall."""
    row = min(rows, key=lambda row: row["count"]["least"] / max(row["count"]["wanted"], 1))
    on_wall = mesh.facets[mesh.facet_labels == mesh.labels.index(row["label"]), :2]
    middles = mesh.points[on_wall].mean(axis=1)
    at = np.array(row["shortest"][0]["at"]) if row["shortest"] else middles[len(middles) // 2]
    nearest = on_wall[np.hypot(*(middles - at).T).argmin()]
    edge = float(np.hypot(*(mesh.points[nearest[1]] - mesh.points[nearest[0]])))
    png = small_png(mesh, PlotOptions(view=_view(at, max(HIGH * row["thickness"], WIDE * edge)), dpi=DPI))
    where = f"Layers on {row['label']} at {place_in_mesh(at, size)}"
    picture = tag("img", src=f"data:image/png;base64,{base64.b64encode(png).decode()}", alt=where, class_="overview")
    told = "where they are lowest" if row["shortest"] else "in the middle of the wall"
    return html(tag("p", linked_places(where), f", {told}:", class_="soft"), picture)


def _view(at: Floats, half: float) -> View:
    """Part of the plane around a place, ``half`` as wide to either side."""
    x, y = at.tolist()
    return x - half, y - FLAT * half, x + half, y + FLAT * half
