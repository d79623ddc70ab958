"""A mesh of triangles and quadrilaterals for the tests, and what it holds by the places of its nodes."""

import dataclasses

import numpy as np
from sandwiches import sandwich


def mixed():
    """The sandwich, bent, with quadrilaterals in its left half: all of one region, and some of the other."""
    mesh = sandwich()
    x, y = mesh.points.T
    pairs = np.arange(len(mesh.triangles)).reshape(-1, 2)
    left = mesh.points[mesh.triangles[pairs[:, 0]], 0].mean(axis=1) < mesh.points[:, 0].min() + 1.5
    bent = np.column_stack([x + 0.07 * np.sin(2 * y), y + 0.05 * x**2])
    return dataclasses.replace(mesh, points=bent, quads=pairs[left], facet_middles=np.zeros((0, 2)))


def of_order(mesh, order):
    return mesh if order == 1 else mesh.second_order()[0]


def cells_by_places(mesh, values=None):
    """Values of the cells, by default the names of their regions, by the places of their corners."""
    names = np.array(mesh.regions, object)[mesh.triangle_regions] if values is None else values
    found = {}
    for nodes, triangles in mesh.cells:
        corners = nodes[:, : 2 + triangles.shape[1]]
        for places, value in zip(mesh.points[corners].round(9).tolist(), names[triangles[:, 0]].tolist(), strict=True):
            found[tuple(sorted(map(tuple, places)))] = value
    return found


def facets_by_places(mesh):
    """Names of the labels by the places of the facets' ends."""
    ends = mesh.points[mesh.facets[:, :2]].round(9).tolist()
    names = [mesh.labels[k] for k in mesh.facet_labels]
    return {tuple(sorted(map(tuple, places))): name for places, name in zip(ends, names, strict=True)}
