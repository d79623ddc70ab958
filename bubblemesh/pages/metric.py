"""Section of a report's page on the metric of a mesh: figures, and ellipses where they are longest."""

import base64
from collections.abc import Mapping
from typing import Any

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.metric import tensors_in
from bubblemesh.meshes.tensors import axes
from bubblemesh.messages import place
from bubblemesh.pages.markup import Markup, html, linked_places, tag
from bubblemesh.pictures.colouring import MeshData
from bubblemesh.pictures.plots import small_png
from bubblemesh.pictures.styles import PlotOptions

WIDE = 4.0  # half the width of the picture, in lengths of the longest ellipse
DPI = 110
MEANING = (
    "Quality and edge lengths on this page are those in the metric, in which an edge should be 1 long; angles and "
    "areas are those in space."
)


def metric_section(mesh: Mesh, fields: Mapping[str, Floats], row: Mapping[str, Any] | None) -> Markup:
    """The section on the metric of a report; empty if the report has no metric."""
    tensors = tensors_in(fields)
    if row is None or tensors is None:
        return Markup("")
    size = float(np.ptp(mesh.points, axis=0).max())
    found = axes(tensors)
    longest = int(found.aspects.argmax())
    (x, y), half = mesh.points[mesh.triangles[longest, :3]].mean(axis=0).tolist(), WIDE * float(found.along[longest])
    options = PlotOptions(view=(x - half, y - half / 2, x + half, y + half / 2), ellipses=True, dpi=DPI)
    png = base64.b64encode(small_png(mesh, options, MeshData(fields))).decode()
    where = f"Ellipses at {place((x, y), size)}"
    picture = tag("img", src=f"data:image/png;base64,{png}", alt=where, class_="overview")
    told = tag("p", linked_places(where), ", where they are longest:", class_="soft")
    title = tag("h2", "Metric", id="metric-title")
    parts = tag("p", _figures(row, size)), tag("p", MEANING, class_="note"), told, picture
    return tag("section", title, *parts, aria_labelledby="metric-title")


def _figures(row: Mapping[str, Any], size: float) -> Markup:
    """Sentences on the ellipses, and where they are shorter than asked for."""
    told = (
        f"Ellipses are up to {row['aspect']:.3g} times as long as wide; {row['edges_within']:.1%} of the edges are "
        "between 0.71 and 1.41 long in the metric."
    )
    shorter = row["shortened"]
    if shorter is None:
        return html(told)
    where = linked_places(place(shorter["ratio_at"], size))
    return html(
        f"{told} At {shorter['share']:.1%} of the nodes ellipses are shorter along than the metric asks for, "
        f"{shorter['ratio']:.3g} times at ",
        where,
        f": {', or '.join(shorter['reasons'])}. With the shorter ones, quality is "
        f"{shorter['quality_mean']:.4f} on average, 1 % is below {shorter['quality_p01']:.3f}, and the least is "
        f"{shorter['quality_min']:.3f}.",
    )
