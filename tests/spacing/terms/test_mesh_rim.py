import numpy as np
import pytest
from scipy.spatial import Delaunay

from bubblemesh.spacing.terms.locator import MeshRim


def holed(n=500):
    points = np.random.default_rng(0).uniform(-1, 1, (n, 2))
    triangles = Delaunay(points).simplices.astype(np.int64)
    middles = points[triangles].mean(axis=1)
    kept = (np.hypot(*(middles - 0.4).T) > 0.3) & (np.hypot(*(middles + 0.4).T) > 0.2)
    triangles = triangles[kept]
    triangles[::3] = triangles[::3, ::-1]
    return points, triangles


def exploded():
    points, triangles = holed()
    return points[triangles.ravel()], np.arange(triangles.size).reshape(-1, 3)


def apart():
    points, triangles = holed()
    corners = points[triangles]
    middles = corners.mean(axis=1, keepdims=True)
    return (middles + 0.8 * (corners - middles)).reshape(-1, 2), np.arange(triangles.size).reshape(-1, 3)


def overlapping():
    points, triangles = holed(100)
    more, others = holed(120)
    return np.vstack([points, more + 0.5]), np.concatenate([triangles, triangles[:20], others + len(points)])


def touching():
    points = np.array([[0.0, 0], [1, 0], [0.5, 1], [-1, 0], [-0.5, -1], [0, -1], [1, -1]])
    return points, np.array([[0, 1, 2], [0, 3, 4], [0, 6, 5]])


MESHES = {"holed": holed, "exploded": exploded, "apart": apart, "overlapping": overlapping, "touching": touching}


def inside(points, triangles, queries):
    a, b, c = np.moveaxis(points[triangles], 1, 0)

    def area(p, q, r):
        return (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (r[..., 0] - p[..., 0])

    at = queries[:, None]
    parts = np.stack([area(a, b, at), area(b, c, at), area(c, a, at)]) / area(a, b, c)
    return (parts >= 0).all(axis=0).any(axis=1)


@pytest.mark.parametrize("name", MESHES)
def test_nearest_place_outside_is_that_of_all_edges(name):
    points, triangles = MESHES[name]()
    queries = np.random.default_rng(1).uniform(-2, 2, (1000, 2))
    queries = queries[~inside(points, triangles, queries)]
    assert len(queries) > 100
    nodes, share = MeshRim.of(points, triangles).nearest(queries)
    place = points[nodes[:, 0]] + share[:, None] * (points[nodes[:, 1]] - points[nodes[:, 0]])
    edges = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    a, b = points[edges[:, 0]], points[edges[:, 1]]
    t = np.clip(((queries[:, None] - a) * (b - a)).sum(axis=2) / ((b - a) ** 2).sum(axis=1), 0, 1)
    least = np.hypot(*np.moveaxis(queries[:, None] - a - t[..., None] * (b - a), 2, 0)).min(axis=1)
    np.testing.assert_allclose(np.hypot(*(queries - place).T), least, rtol=1e-12)


def test_edges_between_triangles_are_no_rim_whether_or_not_they_share_nodes():
    for points, triangles in (holed(), exploded()):
        rim = MeshRim.of(points, triangles)
        edges = np.sort(holed()[1][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        count = np.unique(edges, axis=0, return_counts=True)[1]
        assert len(rim.nodes) == (count == 1).sum()


def test_loops_close_where_parts_touch_in_a_point():
    points, triangles = touching()
    rim = MeshRim.of(points, triangles)
    begin, end = rim.runs.start, rim.runs.end
    assert sorted(map(tuple, end)) == sorted(map(tuple, begin))
    assert len(rim.nodes) == 9
