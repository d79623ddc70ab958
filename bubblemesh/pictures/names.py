"""Names of regions and of single points, where they are in a picture."""

import numpy as np
from matplotlib.axes import Axes
from scipy.spatial import KDTree

from bubblemesh.arrays import Floats
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.pictures.styles import INK

MOST_REGIONS = 24  # that have their names in a picture
MOST_POINTS = 12
NEARLY = 0.8
ABOVE = 6  # points from a mark to its name


def add_names(axes: Axes, mesh: Mesh) -> None:
    """Write the names of regions, if there are several, into them, and those of labelled points beside a mark.

    If there are so many that they would cover the picture, they are left out.
    """
    if 1 < len(mesh.regions) <= MOST_REGIONS:
        for index, name in enumerate(mesh.regions):
            if (mesh.triangle_regions == index).any():
                _write(axes, inmost(mesh, index), name, 0)
    points = mesh.points[mesh.labelled_nodes]
    if len(points):
        axes.plot(*points.T, "s", color=INK, markersize=3.5, markeredgecolor="white", markeredgewidth=0.6, zorder=4)
    if len(points) <= MOST_POINTS:
        for point, label in zip(points, mesh.node_labels.tolist(), strict=True):
            _write(axes, point, mesh.point_labels[label], ABOVE)


def inmost(mesh: Mesh, region: int) -> Floats:
    """Centre (2,) of the triangle of a region that is far from the region's rim and from all that is labelled.

    Of all triangles that are nearly as far as the farthest, it is the one nearest to the region's middle.
    """
    mine = mesh.triangles[mesh.triangle_regions == region, :3]
    pairs, counts = unique_edges(mine)
    middles = mesh.points[mine].mean(axis=1)
    lines = np.concatenate([pairs[counts == 1], mesh.facets[:, :2]])
    away = np.asarray(KDTree(mesh.points[lines].mean(axis=1)).query(middles)[0])
    far = middles[away >= NEARLY * away.max()]
    found: Floats = far[np.hypot(*(far - middles.mean(axis=0)).T).argmin()]
    return found


def _write(axes: Axes, place: Floats, text: str, above: float) -> None:
    """Write a text ``above`` points above a place."""
    axes.annotate(
        text,
        (float(place[0]), float(place[1])),
        xytext=(0, above),
        textcoords="offset points",
        ha="center",
        va="bottom" if above else "center",
        color=INK,
        bbox={"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.7},
        zorder=4,
        parse_math=False,
    )
