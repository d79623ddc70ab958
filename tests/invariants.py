"""What every mesh must hold, whatever the case, by no function of the package: its tests check those."""

import math

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
    n = len(mesh.points)
    assert np.array_equal(np.unique(mesh.triangles), np.arange(n)), "a node is unused"
    assert len({tuple(point) for point in mesh.points.tolist()}) == n, "two nodes coincide"
    on_boundary = np.unique(outer_facets(mesh))
    assert np.array_equal(on_boundary, np.arange(len(on_boundary))), "boundary nodes do not come first"


def directed(mesh, pairs):
    """A number for each pair of nodes (m, 2), of which none but the same pair in the same order has the same."""
    return pairs[:, 0].astype(np.int64) * len(mesh.points) + pairs[:, 1]


def sides_of(mesh):
    """Pairs (3 t, 2) of nodes that are sides of the triangles, which lie on their left."""
    return np.concatenate([mesh.triangles[:, [k, (k + 1) % 3]] for k in range(3)])


def outer_facets(mesh):
    """Facets (b, 2) that no triangle has on its right."""
    return mesh.facets[~np.isin(directed(mesh, mesh.facets[:, ::-1]), directed(mesh, sides_of(mesh)))]


def check_edges(mesh):
    """Each inner edge is run through once in each direction; each facet is there once, a triangle on its left."""
    pairs = sides_of(mesh)
    sides, facets = directed(mesh, pairs), directed(mesh, mesh.facets)
    assert len(np.unique(sides)) == len(sides), "an edge has two triangles on one side"
    either_way = directed(mesh, np.sort(mesh.facets, axis=1))
    assert len(np.unique(either_way)) == len(either_way), "a facet is listed twice"
    assert np.isin(facets, sides).all(), "a facet is no edge of a triangle on its left"
    alone = sides[~np.isin(directed(mesh, pairs[:, ::-1]), sides)]
    outer = directed(mesh, outer_facets(mesh))
    assert np.array_equal(np.sort(alone), np.sort(outer)), "outer facets are not the triangles' free edges"


def check_facets_do_not_cross(mesh):
    chords = shapely.linestrings(mesh.points[mesh.facets])
    assert shapely.STRtree(chords).query(chords, predicate="crosses").size == 0, "facets cross"


def check_area(mesh):
    x, y = (mesh.points - mesh.points.mean(axis=0)).T
    i, j, k = mesh.triangles.T
    twice_areas = (x[j] - x[i]) * (y[k] - y[i]) - (x[k] - x[i]) * (y[j] - y[i])
    assert (twice_areas > 0).all(), "a triangle is not counter-clockwise"
    i, j = outer_facets(mesh).T
    twice_polygon = math.fsum(x[i] * y[j] - x[j] * y[i])
    assert abs(math.fsum(twice_areas) / twice_polygon - 1) <= AREA_TOLERANCE, "the triangles do not fill the polygon"


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
