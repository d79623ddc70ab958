import numpy as np
import pytest
from scipy.spatial import Delaunay

from bubblemesh.spacing.terms.locator import LOCATOR_LEVELS, PAIRS_PER_TRIANGLE, TriangleLocator


def graded(seed=0, n=300):
    rng = np.random.default_rng(seed)
    r, angle = rng.random(n) ** 4, rng.uniform(0, 2 * np.pi, n)
    points = np.column_stack([r * np.cos(angle), r * np.sin(angle)])
    return points[Delaunay(points).simplices]


def holed():
    corners = graded(1)
    return corners[np.hypot(*(corners.mean(axis=1) - [0.2, 0.1]).T) > 0.15]


def fan(n=300):
    angle = np.linspace(0, 2 * np.pi, n + 1)
    rim = np.column_stack([np.cos(angle), np.sin(angle)])
    return np.stack([np.zeros((n, 2)), rim[:-1], rim[1:]], axis=1)


def needles(n=200):
    low, high = np.arange(n) / n, np.arange(1, n + 1) / n
    west, east = np.zeros(n), np.ones(n)
    a, b, c, d = (np.column_stack(corner) for corner in ((west, low), (east, low), (east, high), (west, high)))
    return np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def stacked():
    return np.tile(graded(2, 12), (40, 1, 1))


def holding(corners, points, slack):
    """Which triangles (t,) hold which points (m,): (m, t), by the signs of areas."""
    a, b, c = np.moveaxis(corners, 1, 0)

    def area(p, q, r):
        return (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (r[..., 0] - p[..., 0])

    whole, at = area(a, b, c), points[:, None]
    parts = np.stack([area(a, b, at), area(b, c, at), area(c, a, at)])
    return (parts / whole >= -slack).all(axis=0)


MESHES = {"graded": graded(), "holed": holed(), "fan": fan(), "needles": needles(), "stacked": stacked()}


@pytest.mark.parametrize("name", MESHES)
@pytest.mark.parametrize(("size", "origin"), [(1, (0, 0)), (1e-9, (0, 0)), (1e12, (0, 0)), (1, (1e6, -1e6))])
def test_found_triangles_hold_the_points_and_none_is_missed(name, size, origin):
    corners = MESHES[name] * size + origin
    rng = np.random.default_rng(3)
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    weights = rng.dirichlet([0.3, 0.3, 0.3], 400)
    inside = (weights[:, :, None] * corners[rng.integers(len(corners), size=400)]).sum(axis=1)
    points = np.vstack([rng.uniform(low - 0.3 * (high - low), high + 0.3 * (high - low), (400, 2)), inside])
    found, (second, third) = TriangleLocator.of(corners).located(points)
    rounding = 1e-7 if max(map(abs, origin)) else 1e-10
    surely, perhaps = holding(corners, points, -rounding), holding(corners, points, max(rounding, 2e-9))
    assert (found[surely.any(axis=1)] >= 0).all()
    assert surely.any(axis=1).sum() > 100
    hits = np.flatnonzero(found >= 0)
    assert perhaps[hits, found[hits]].all()
    a, b, c = np.moveaxis(corners[found[hits]], 1, 0)
    again = a + second[hits, None] * (b - a) + third[hits, None] * (c - a)
    np.testing.assert_allclose(again, points[hits], rtol=1e-14, atol=1e-13 * size)


@pytest.mark.parametrize("name", ["graded", "holed", "fan", "needles"])
def test_corners_and_edges_belong_to_a_triangle(name):
    corners = MESHES[name]
    middles = (corners + np.roll(corners, 1, axis=1)) / 2
    points = np.concatenate([corners.reshape(-1, 2), middles.reshape(-1, 2)])
    found, weights = TriangleLocator.of(corners).located(points)
    assert (found >= 0).all()
    assert (weights >= -1e-9).all()
    assert (weights.sum(axis=0) <= 1 + 1e-9).all()


def test_cells_hold_few_candidates_however_the_triangles_are_graded():
    locator = TriangleLocator.of(graded(n=3000))
    assert np.diff(locator.begin).max() <= 12
    assert len(locator.candidates) < 4 * len(locator.maps)


@pytest.mark.parametrize("name", ["fan", "stacked"])
def test_cells_are_not_split_without_end_where_many_triangles_meet(name):
    locator = TriangleLocator.of(MESHES[name])
    assert len(locator.candidates) <= 4 * PAIRS_PER_TRIANGLE * len(locator.maps)
    assert locator.grid.level.max() <= LOCATOR_LEVELS


def test_one_triangle_and_no_points():
    locator = TriangleLocator.of(np.array([[[0.0, 0], [0, 1], [1, 0]]]))
    found, weights = locator.located(np.array([[0.25, 0.25], [0.75, 0.75]]))
    np.testing.assert_array_equal(found, [0, -1])
    np.testing.assert_allclose(weights[:, 0], [0.25, 0.25])
    assert locator.located(np.zeros((0, 2)))[0].shape == (0,)
