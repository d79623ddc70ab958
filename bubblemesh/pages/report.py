"""The page of one run."""

import base64
from collections.abc import Mapping, Sequence
from datetime import datetime
from typing import Any, NamedTuple

from bubblemesh.arrays import Floats
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles.text import readable_json
from bubblemesh.messages import counted, duration, run_seconds
from bubblemesh.pages.areas_and_lengths import regions_and_labels
from bubblemesh.pages.layers import layers_section
from bubblemesh.pages.markup import Markup, from_template, html, linked_places, page, tag, whole
from bubblemesh.pages.metric import metric_section
from bubblemesh.pages.scene import Scene
from bubblemesh.pages.sections import (
    colourings,
    files_list,
    histograms,
    labels,
    rounds_charts,
    rounds_table,
    scales,
    worst_triangles,
)
from bubblemesh.pictures.colouring import MeshData
from bubblemesh.pictures.plots import png_of, small_png
from bubblemesh.pictures.spacing_plots import Extreme, spacing_figure
from bubblemesh.pictures.styles import PlotOptions

SCRIPTS = ("data", "colours", "camera", "raster", "picture", "facts", "viewer", "gestures", "controls", "report")
WORST = 10
STILL = PlotOptions(dpi=150)
FEW_LABELS = 12
MOST_LINES = 1500  # of the case


class Overview(NamedTuple):
    """The spacing of a whole domain: at the nodes of a mesh that is fine enough to show it, and its extremes."""

    mesh: Mesh
    spacing: Floats  # (n,)
    extremes: tuple[Extreme, Extreme]  # the least and the largest one, with their places


def report_page(
    mesh: Mesh,
    fields: Mapping[str, Floats],
    report: Mapping[str, Any],
    speeds: Sequence[Floats],
    written: datetime,
    overview: Overview | None = None,
) -> str:
    """The page of a run: one file of HTML that needs nothing else.

    Parameters
    ----------
    mesh
        The mesh, or a sample of it if it is too large for a page.
    fields
        Values at the triangles, with ``target_spacing`` (t,).
    report
        The report as it is written, with the names of all files, which are in the folder of the page.
    speeds
        Mean speeds of the bubbles after each step, for each round.
    written
        When the files were written.
    overview
        The spacing of the whole domain, shown above a sample.
    """
    scene = Scene.of(mesh, fields, WORST)
    crs = report.get("crs")
    in_plane = crs is None or crs["target"] == "auto"  # places of figures are those of the mesh
    as_given = crs is None or crs["target"] == crs["source"]  # and those of messages
    text, omitted = readable_json(report["parameters"], MOST_LINES)
    body = from_template(
        "report.html",
        name=report["case"],
        origin=f"method {report['method']}, seed {report['seed']}, bubblemesh {report['version']}, "
        f"{written.day} {written:%B %Y, %H:%M}",
        figures=_figures(report),
        warnings=_warnings(report["warnings"], linked=as_given),
        sample="" if overview is None else _sample(mesh, report, overview),
        picture=f"The mesh of {report['case']}: {counted(len(mesh.triangles), 'triangle')}, {_named(mesh.labels)}. Its "
        "figures are in the tables of this page.",
        colourings=colourings(mesh),
        scales=scales(scene),
        labels=labels(mesh),
        still=base64.b64encode(small_png(mesh, STILL, MeshData(fields))).decode(),
        layers=html(
            layers_section(mesh, report.get("layers", ()), in_plane=in_plane),
            metric_section(mesh, fields, report.get("metric")),
        ),
        regions=regions_and_labels(report),
        histograms=histograms(scene, fields),
        worst=worst_triangles(scene),
        stopped=report["stop_reason"],
        charts=rounds_charts(report, speeds),
        files=files_list(report["files"]),
        rounds=rounds_table(report["rounds"]),
        case=text,
        omitted=tag("p", f"{counted(omitted, 'more line')} in the JSON report.", class_="note") if omitted else "",
        data=scene.blocks(),
    )
    return page(f"{report['case']} - bubblemesh report", body, [f"{name}.js" for name in SCRIPTS])


def _sample(mesh: Mesh, report: Mapping[str, Any], overview: Overview) -> Markup:
    """Sample of a mesh that is too large for a page, shown above a picture of its spacing."""
    told = (
        f"Of the {whole(report['triangles'])} triangles the picture to zoom into shows the "
        f"{whole(len(mesh.triangles))} around the worst one; histograms and worst triangles are theirs. This is the "
        "spacing of the whole mesh:"
    )
    png = png_of(spacing_figure(*overview), PlotOptions())
    picture = f"data:image/png;base64,{base64.b64encode(png).decode()}"
    alt = "The spacing of the whole mesh"
    return html(tag("p", told, class_="note"), tag("img", src=picture, alt=alt, class_="overview"))


def _named(labels: Sequence[str]) -> str:
    return f"labels {', '.join(labels)}" if len(labels) <= FEW_LABELS else counted(len(labels), "label")


def _figures(report: Mapping[str, Any]) -> Markup:
    """List of the main figures: nodes, quality, spacing, time."""
    quality, spacing = report["quality"], report["spacing"]
    ideal = f"{report['nodes'] / report['ideal_nodes']:.3f} of the ideal number"  # of a domain without layers
    angles_note = "in space" if "metric" in report else "60° is ideal"
    rows = [
        ("Nodes", whole(report["nodes"]), "layers included" if "layers" in report else ideal),
        ("Triangles", whole(report["triangles"]), f"area {report['area']:.6g}"),
        ("Mean quality q", f"{quality['mean']:.4f}", f"1 % below {quality['p01']:.3f}"),
        ("Least quality q", f"{quality['min']:.3f}", "1 is equilateral"),
        ("Angles", f"{quality['angle_min']:.0f}° to {quality['angle_max']:.0f}°", angles_note),
        ("Edge length l/d", f"{spacing['mean']:.3f}", f"± {spacing['std']:.3f} of wanted spacing"),
        ("Time", duration(run_seconds(report["seconds"])), counted(len(report["rounds"]), "round")),
    ]
    return html(*(tag("div", tag("dt", term), tag("dd", value, tag("small", note))) for term, value, note in rows))


def _warnings(messages: Sequence[str], *, linked: bool) -> Markup:
    """List of warnings, whose places are buttons if they are ``linked`` to the picture."""
    if not messages:
        return tag("p", "No warnings.", class_="soft")
    items = html(*(tag("li", linked_places(message) if linked else message) for message in messages))
    title = tag("h2", counted(len(messages), "warning"), id="warnings-title")
    return tag("section", title, tag("ul", items), class_="warnings", aria_labelledby="warnings-title")
