"""What every mesh must hold, whatever the case, by loops and dictionaries of its own."""

import math
from collections import Counter
from itertools import pairwise

import numpy as np
import shapely

AREA_TOLERANCE = 1e-12


def check_mesh(mesh):
    """Fail unless the mesh is conforming, compact, counter-clockwise and completely labelled."""
    check_arrays(mesh)
    check_nodes(mesh)
    check_edges(mesh)
    check_facets_do_not_cross(mesh)
    check_area(mesh)
    check_labels(mesh)


def check_arrays(mesh):
    n = len(mesh.points)
    assert mesh.points.dtype == np.float64
    assert mesh.points.shape == (n, 2)
    assert np.isfinite(mesh.points).all()
    for rows, width in ((mesh.triangles, 3), (mesh.facets, 2)):
        assert np.issubdtype(rows.dtype, np.integer)
        assert rows.shape == (len(rows), width)
        assert len(rows) > 0
        assert rows.min() >= 0
        assert rows.max() < n


def check_nodes(mesh):
    nodes = range(len(mesh.points))
    assert {i for triangle in mesh.triangles.tolist() for i in triangle} == set(nodes), "a node is unused"
    assert len({tuple(point) for point in mesh.points.tolist()}) == len(nodes), "two nodes coincide"
    on_boundary = {i for facet in outer_facets(mesh) for i in facet}
    assert on_boundary == set(range(len(on_boundary))), "boundary nodes do not come first"


def sides_of(mesh):
    """How often each directed edge is a side of a triangle."""
    return Counter(side for i, j, k in mesh.triangles.tolist() for side in pairwise((i, j, k, i)))


def outer_facets(mesh):
    """Facets that no triangle has on its right."""
    sides = sides_of(mesh)
    return [(i, j) for i, j in mesh.facets.tolist() if (j, i) not in sides]


def check_edges(mesh):
    """Each inner edge is run through once in each direction; each facet is there once, a triangle on its left."""
    sides = sides_of(mesh)
    assert set(sides.values()) == {1}, "an edge has two triangles on one side"
    alone = {(i, j) for i, j in sides if (j, i) not in sides}
    facets = [(i, j) for i, j in mesh.facets.tolist()]
    assert len({frozenset(facet) for facet in facets}) == len(facets), "a facet is listed twice"
    assert set(facets) <= set(sides), "a facet is no edge of a triangle on its left"
    assert alone == set(outer_facets(mesh)), "outer facets are not the triangles' free edges"


def check_facets_do_not_cross(mesh):
    chords = shapely.linestrings(mesh.points[mesh.facets])
    assert shapely.STRtree(chords).query(chords, predicate="crosses").size == 0, "facets cross"


def check_area(mesh):
    x, y = (mesh.points - mesh.points.mean(axis=0)).T.tolist()

    def twice_area(i, j, k):
        return (x[j] - x[i]) * (y[k] - y[i]) - (x[k] - x[i]) * (y[j] - y[i])

    areas = [twice_area(*triangle) for triangle in mesh.triangles.tolist()]
    assert min(areas) > 0, "a triangle is not counter-clockwise"
    polygon = math.fsum(x[i] * y[j] - x[j] * y[i] for i, j in outer_facets(mesh))
    assert abs(math.fsum(areas) / polygon - 1) <= AREA_TOLERANCE, "the triangles do not fill the polygon"


def check_labels(mesh):
    assert len(mesh.facet_labels) == len(mesh.facets)
    assert set(mesh.facet_labels.tolist()) == set(range(len(mesh.labels))), "a label is unused or out of range"
    assert len(mesh.triangle_regions) == len(mesh.triangles)
    assert set(mesh.triangle_regions.tolist()) == set(range(len(mesh.regions))), "a region is unused or out of range"
    assert set(mesh.node_labels.tolist()) == set(range(len(mesh.point_labels))), "a label of points is unused"
    assert len(mesh.labelled_nodes) == len(mesh.node_labels)
    assert mesh.facet_middles.shape == mesh.facets.shape
    for names in (mesh.labels, mesh.regions, mesh.point_labels):
        assert len(set(names)) == len(names)
        assert all(isinstance(name, str) and name for name in names)
