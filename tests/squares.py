"""A square with a square hole, meshed without any packing."""

import math

import numpy as np

from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.quality import radius_ratios


def holed_square(cells=9, labels=("bottom", "right", "top", "left", "hole")):
    """Return a mesh of the square [0, 3] x [0, 3] without its middle ninth; `cells` is a multiple of three."""
    third = cells // 3
    kept = [
        (i, j) for i in range(cells) for j in range(cells) if not (third <= i < 2 * third and third <= j < 2 * third)
    ]
    corner = {(i + k, j + m) for i, j in kept for k in (0, 1) for m in (0, 1)}
    outline = [
        *[((i, 0), (i + 1, 0), 0) for i in range(cells)],
        *[((cells, j), (cells, j + 1), 1) for j in range(cells)],
        *[((i + 1, cells), (i, cells), 2) for i in range(cells)],
        *[((0, j + 1), (0, j), 3) for j in range(cells)],
        *[((i + 1, third), (i, third), 4) for i in range(third, 2 * third)],
        *[((i, 2 * third), (i + 1, 2 * third), 4) for i in range(third, 2 * third)],
        *[((third, j), (third, j + 1), 4) for j in range(third, 2 * third)],
        *[((2 * third, j + 1), (2 * third, j), 4) for j in range(third, 2 * third)],
    ]
    boundary = list(dict.fromkeys(node for start, end, _ in outline for node in (start, end)))
    order = [*boundary, *sorted(corner - set(boundary))]
    number = {node: index for index, node in enumerate(order)}
    squares = [[number[i, j], number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]] for i, j in kept]
    triangles = [t for a, b, c, d in squares for t in ((a, b, c), (a, c, d))]
    return Mesh(
        # A factor that leaves digits to lose.
        points=np.array(order) * (3 / cells) + np.array([1 / 3, -math.pi]),
        triangles=np.array(triangles),
        facets=np.array([[number[start], number[end]] for start, end, _ in outline]),
        facet_labels=np.array([label for _, _, label in outline]),
        labels=labels,
    )


def fields_of(mesh):
    """Fields as a run has them, some of them made up."""
    ratios = radius_ratios(mesh.points, mesh.triangles)
    return {"quality": ratios, "target_spacing": np.linspace(0.1, 1 / 3, len(mesh.triangles))}
