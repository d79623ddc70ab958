"""What the colours of the picture in a report's page mean."""

import numpy as np

from bubblemesh.meshes.mesh import Mesh
from bubblemesh.pages.markup import Markup, joined, tag
from bubblemesh.pages.numbers import counted, whole
from bubblemesh.pages.scene import Scene

DASHES = ("", "9 4", "2 3", "9 3 2 3")
COLOURINGS = {"quality": "Quality q", "ratio": "Edge length l/d", "region": "Region", "none": "None"}


def colourings(mesh: Mesh) -> Markup:
    """Choices of what the colour of the triangles shows."""
    names = [name for name in COLOURINGS if name != "region" or len(mesh.regions) > 1]
    return joined(*(tag("option", COLOURINGS[name], value=name) for name in names))


def scales(scene: Scene) -> Markup:
    """What the colours of each colouring mean."""
    low, high = scene.quality.limits
    below, above = scene.ratio.limits
    regions = [
        tag("li", tag("svg", tag("rect", width=26, height=12, class_=f"region-{k % 8}"), aria_hidden="true"), " ", name)
        for k, name in enumerate(scene.mesh.regions)
    ]
    legends = {
        "quality": _scale("Quality q", f"{low:g} or less", f"{high:g}, equilateral"),
        "ratio": _scale("Edge length over wanted spacing", f"{below:.3g} or less", f"{above:.3g} or more"),
        "region": joined(tag("h3", "Regions"), tag("ul", joined(*regions), class_="legend")),
        "none": tag("h3", "Triangles without colour"),
    }
    return joined(*(tag("div", legends[name], data_legend=name, hidden=name != "quality") for name in legends))


def _scale(title: str, low: str, high: str) -> Markup:
    ends = tag("div", tag("span", low), tag("span", high), class_="ends")
    picture = tag("canvas", role="img", aria_label=f"Colours from {low} to {high}")
    return joined(tag("h3", title), tag("div", picture, ends, class_="scale"))


def labels(mesh: Mesh) -> Markup:
    """The labels as buttons that let one stand out."""
    counts = np.bincount(mesh.facet_labels, minlength=len(mesh.labels)).tolist()
    items = []
    for k, (name, count) in enumerate(zip(mesh.labels, counts, strict=True)):
        dashes = DASHES[k // 8 % 4] or None
        line = tag("line", x1=1, y1=6, x2=25, y2=6, class_=f"label-line label-{k % 8}", stroke_dasharray=dashes)
        sample = tag("svg", line, viewBox="0 0 26 12", aria_hidden="true")
        button = tag(
            "button",
            joined(sample, name, " ", tag("span", whole(count), class_="soft")),
            type="button",
            class_="label",
            data_label=k,
            aria_pressed="false",
            title=f"{counted(count, 'edge')}: let it stand out",
        )
        items.append(tag("li", button))
    return joined(tag("h3", "Labels and their edges"), tag("ul", joined(*items), class_="legend"))
