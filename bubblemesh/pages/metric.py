"""Section of a report's page on the metric of a mesh: figures, and ellipses where they are longest."""

import base64
from collections.abc import Mapping
from typing import Any

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.metric import tensors_in
from bubblemesh.meshes.tensors import axes
from bubblemesh.messages import place_in_mesh
from bubblemesh.pages.markup import Markup, html, linked_places, tag
from bubblemesh.pictures.colouring import MeshData
from bubblemesh.pictures.plots import small_png
from bubblemesh.pictures.styles import PlotOptions

WIDE_ELLIPSES = 4.0  # half the width of the picture, in lengths of the longest ellipse
ALIKE = 1e-6  # relative difference of tensors that are one
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
    found, middles = axes(tensors), mesh.points[mesh.triangles[:, :3]].mean(axis=1)
    if np.ptp(tensors, axis=0).max() <= ALIKE * np.abs(tensors).max():
        shown, why = int(np.hypot(*(middles - _middle(mesh.points)).T).argmin()), "as they are everywhere"
    else:
        shown, why = int(found.aspects.argmax()), "where they are longest"
    view = _view(mesh.points, middles[shown], WIDE_ELLIPSES * float(found.along[shown]))
    png = base64.b64encode(small_png(mesh, PlotOptions(view=view, ellipses=True, dpi=DPI), MeshData(fields))).decode()
    where = f"Ellipses at {place_in_mesh(middles[shown], size)}"
    picture = tag("img", src=f"data:image/png;base64,{png}", alt=where, class_="overview")
    told = tag("p", linked_places(where), f", {why}:", class_="soft")
    title = tag("h2", "Metric", id="metric-title")
    parts = tag("p", _figures(row, size)), tag("p", MEANING, class_="note"), told, picture
    return tag("section", title, *parts, aria_labelledby="metric-title")


def _middle(points: Floats) -> Floats:
    """Middle (2,) of the box around points (n, 2)."""
    return (points.min(axis=0) + points.max(axis=0)) / 2


def _view(points: Floats, at: Floats, half: float) -> tuple[float, float, float, float]:
    """Box (x0, y0, x1, y1) around a place, moved so that little of it is beside the mesh with points (n, 2).

    It is half as high as wide. ``half`` is half its width, or less if that is more than the mesh takes.
    """
    width, height = np.ptp(points, axis=0).tolist()
    half = min(half, max(width / 2, height))
    reach = np.array([half, half / 2])
    aside = np.maximum(np.array([width, height]) / 2 - reach, 0)  # how far the middles of the two may be apart
    middle = _middle(points)
    x, y = np.clip(at, middle - aside, middle + aside).tolist()
    return x - half, y - half / 2, x + half, y + half / 2


def _figures(row: Mapping[str, Any], size: float) -> Markup:
    """Sentences on the ellipses, and where they are shorter than asked for."""
    told = (
        f"Ellipses are up to {row['aspect']:.3g} times as long as wide; {row['edges_within']:.1%} of the edges are "
        "between 0.71 and 1.41 long in the metric."
    )
    shorter = row["shortened"]
    if shorter is None:
        return html(told)
    where = linked_places(place_in_mesh(shorter["ratio_at"], size))
    return html(
        f"{told} At {shorter['share']:.1%} of the nodes ellipses are shorter along than the metric asks for, "
        f"{shorter['ratio']:.3g} times at ",
        where,
        f": {', or '.join(shorter['reasons'])}. With the shorter ones, quality is "
        f"{shorter['quality_mean']:.4f} on average, 1 % is below {shorter['quality_p01']:.3f}, and the least is "
        f"{shorter['quality_min']:.3f}.",
    )
