"""The part of a report's page on the shape of the triangles."""

import math

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.meshes.histograms import histogram, lowest_shown, quality_histogram
from bubblemesh.meshes.quality import angles, edge_means, edge_ratios
from bubblemesh.pages.charts import histogram_chart
from bubblemesh.pages.markup import Markup, joined, tag
from bubblemesh.pages.numbers import place, whole
from bubblemesh.pages.scene import Scene
from bubblemesh.pages.tables import cell, head, table

BINS = 25
FEW = 0.002  # share of the edges that a histogram may leave out at either end
LARGEST = 3.0  # edge length over spacing that a histogram shows


def histograms(scene: Scene, target: Floats) -> Markup:
    """Histograms of quality, angles, and edge length over the spacing (t,) wanted in the triangles."""
    points, corners = scene.mesh.points, scene.corners
    q, corner_angles = scene.quality.values, angles(points, corners)
    sides, _ = unique_edges(corners)
    ratios = edge_ratios(points, sides, edge_means(corners, target))
    low = lowest_shown(q)
    least = min(10 * math.floor(float(np.nanmin(corner_angles)) / 10), 50)
    most = max(10 * math.ceil(float(np.nanmax(corner_angles)) / 10), 70)
    few, many = np.quantile(ratios, [FEW, 1 - FEW])
    shortest, longest = min(math.floor(4 * few) / 4, 0.75), max(min(math.ceil(4 * many) / 4, LARGEST), 1.25)
    quarters = np.arange(shortest, longest + 0.01, 0.25 if longest - shortest < 2 else 0.5).tolist()
    fifths = np.linspace(low, 1, 5).tolist()
    return joined(
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
    rows = []
    for rank, t in enumerate(scene.worst.tolist()):
        corners = mesh.points[scene.corners[t]]
        x, y = corners.mean(axis=0).tolist()
        least = float(np.nanmin(angles(mesh.points, scene.corners[t : t + 1])))
        show = tag("button", "Show", type="button", class_="worst screen", data_rank=rank, title="Show in the mesh")
        cells = [f"{rank + 1}", f"{scene.quality.values[t]:.4f}", f"{least:.1f}°", f"{scene.ratio.values[t]:.3f}"]
        rows.append([cell(show), *map(cell, cells), cell(place((x, y))), cell(whole(t + 1))])
    heads = ["", "Rank", "q", "Least angle", "l/d", "Centre", "Triangle"]
    return table("Worst triangles", [head(name) for name in heads], rows)
