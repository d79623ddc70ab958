import numpy as np
import pytest
from scipy.spatial import Delaunay

import bubblemesh
from bubblemesh.errors import CaseError
from bubblemesh.spacing.terms.field import MeshField, scattered

CORNERS = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])


def linear(x, y):
    return 3 + 0.5 * x - 0.7 * y


def ring(seed=0, n=400):
    """Points and triangles of a plate with a hole; every other triangle turns clockwise, and some points are unused."""
    rng = np.random.default_rng(seed)
    points = np.vstack([rng.uniform(-1, 1, (n, 2)) * [2, 1], [[9, 9]]])
    triangles = Delaunay(points[:-1]).simplices.astype(np.int64)
    triangles = triangles[np.hypot(*points[triangles].mean(axis=1).T) > 0.5]
    triangles[::2] = triangles[::2, ::-1]
    return points, triangles


def nearest_places(points, triangles, queries):
    """Nearest points (m, 2) of the triangles to the queries (m, 2), by trying all edges."""
    edges = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    a, b = points[edges[:, 0]], points[edges[:, 1]]
    share = ((queries[:, None] - a) * (b - a)).sum(axis=2) / ((b - a) ** 2).sum(axis=1)
    feet = a + np.clip(share, 0, 1)[..., None] * (b - a)
    best = ((queries[:, None] - feet) ** 2).sum(axis=2).argmin(axis=1)
    return feet[np.arange(len(queries)), best]


def outside(points, triangles, queries):
    a, b, c = np.moveaxis(points[triangles], 1, 0)

    def area(p, q, r):
        return (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (r[..., 0] - p[..., 0])

    at = queries[:, None]
    parts = np.stack([area(a, b, at), area(b, c, at), area(c, a, at)]) / area(a, b, c)
    return (parts < 0).any(axis=0).all(axis=1)


def test_linear_functions_are_exact_inside_and_nearest_values_count_outside():
    points, triangles = ring()
    queries = np.random.default_rng(1).uniform([-3, -2], [3, 2], (1500, 2))
    found = MeshField.of(points, triangles, linear(*points.T))(*queries.T)
    out = outside(points, triangles, queries)
    assert 200 < out.sum() < 1300
    np.testing.assert_allclose(found[~out], linear(*queries[~out].T), rtol=1e-12)
    nearest = nearest_places(points, triangles, queries[out])
    np.testing.assert_allclose(found[out], linear(*nearest.T), rtol=1e-12)
    in_the_hole = out & (np.hypot(*queries.T) < 0.3)
    assert in_the_hole.any()


def test_value_is_continuous_across_edges_and_the_rim():
    points, triangles = ring(2)
    values = np.random.default_rng(3).uniform(1, 2, len(points))
    field = MeshField.of(points, triangles, values)
    ends = np.random.default_rng(4).uniform([-2.5, -1.5], [2.5, 1.5], (30, 2, 2))
    for a, b in ends:
        if np.linalg.norm(a) < 0.8 or np.linalg.norm(b) < 0.8:
            continue  # the nearest side of the hole may jump
        way = a + np.linspace(0, 1, 40_001)[:, None] * (b - a)
        way = way[np.hypot(*way.T) > 0.8]
        step = np.hypot(*np.diff(way, axis=0).T)
        near = step < 1e-3
        assert np.abs(np.diff(field(*way.T)))[near].max() < 0.02
    used = np.unique(triangles)
    np.testing.assert_allclose(field(*points[used].T), values[used], rtol=1e-9)


def test_far_points_get_the_nearest_value_in_any_number():
    field = MeshField.of(CORNERS, np.array([[0, 1, 2], [0, 2, 3]]), np.array([1.0, 2, 3, 4]))
    x = np.linspace(-1e6, 1e6, 70_001)
    expected = np.where(x < 0, 4.0, np.where(x > 1, 3.0, 4 - x))
    np.testing.assert_allclose(field(x, np.full(len(x), 5.0)), expected, rtol=1e-12)
    assert field(np.zeros(0), np.zeros(0)).shape == (0,)


def test_triangle_data_keeps_constants_and_the_number_of_bubbles():
    points, triangles = ring(5, 3000)
    constant = MeshField.of_triangles(points, triangles, np.full(len(triangles), 0.3))
    np.testing.assert_allclose(constant.values[np.unique(triangles)], 0.3, rtol=1e-14)
    centers = points[triangles].mean(axis=1)
    values = 0.05 + 0.2 * np.abs(centers[:, 0])
    field = MeshField.of_triangles(points, triangles, values)
    (ux, uy), (vx, vy) = (points[triangles[:, 1:]] - points[triangles[:, :1]]).transpose(1, 2, 0)
    area = np.abs(ux * vy - uy * vx) / 2
    d = field.values[triangles]
    assert (area / values**2).sum() == pytest.approx((area / 3 * (1 / d**2).sum(axis=1)).sum(), rel=1e-12)
    assert np.quantile(np.abs(field(*centers.T) / values - 1), 0.95) < 0.1


def test_jumps_of_triangle_data_are_taken_over_by_finer_sizes():
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    field = MeshField.of_triangles(CORNERS, triangles, np.array([1.0, 0.1]))
    np.testing.assert_allclose(field.values[[1, 3]], [1, 0.1])
    np.testing.assert_allclose(field.values[[0, 2]], 1 / np.sqrt((1 + 100) / 2))


def test_meshes_whose_triangles_share_no_nodes_may_jump():
    points = CORNERS[[0, 1, 2, 0, 2, 3]]
    field = MeshField.of(points, np.arange(6).reshape(2, 3), np.array([1.0, 1, 1, 2, 2, 2]))
    np.testing.assert_allclose(field(np.array([0.6, 0.4, -3]), np.array([0.4, 0.6, 0.5])), [1, 2, 2])


def test_scale_multiplies_inside_and_outside():
    points, triangles = ring()
    field = MeshField.of(points, triangles, linear(*points.T))
    x, y = np.random.default_rng(1).uniform(-3, 3, (2, 100))
    np.testing.assert_allclose(field.scaled(0.25)(x, y), 0.25 * field(x, y), rtol=1e-14)


@pytest.mark.parametrize("bad", [0.0, -1.5, np.nan, np.inf])
def test_values_that_are_none_are_named_with_their_place(bad):
    values = np.array([1.0, 1, bad, 1])
    with pytest.raises(CaseError, match=r"is \S+ at node 2 \(from 0\), \(1, 1\): a spacing has to be positive"):
        MeshField.of(CORNERS, np.array([[0, 1, 2], [0, 2, 3]]), values)
    with pytest.raises(CaseError, match=r"at node 3 \(from 0\), \(1, 1\)"):
        MeshField.of(np.vstack([[[7, 7]], CORNERS]), np.array([[1, 2, 3]]), np.insert(values, 0, np.nan))
    unused = MeshField.of(CORNERS, np.array([[0, 1, 3]]), values)
    assert unused(np.array([0.2]), np.array([0.2])) == pytest.approx(1)
    with pytest.raises(CaseError, match=r"is \S+ in the triangle around \(0\.3{6,}, 0\.6{5,}7\), and 1 more value is"):
        MeshField.of_triangles(CORNERS, np.array([[0, 1, 2], [0, 2, 3], [0, 1, 3]]), np.array([1, bad, bad]))


def test_a_cell_of_several_triangles_counts_once():
    triangles, cells = np.array([[0, 1, 2], [0, 2, 3]]), np.zeros(2, int)
    assert MeshField.of_triangles(CORNERS, triangles, np.array([0.3]), cells).values.tolist() == pytest.approx(
        [0.3] * 4
    )
    with pytest.raises(CaseError, match=r"^is 0 in the cell around \(0.5, 0.5\): a spacing has to be positive"):
        MeshField.of_triangles(CORNERS, triangles, np.zeros(1), cells)


def test_triangles_without_an_area_are_left_out():
    line = np.array([[0.0, 0], [1, 1], [2, 2]])
    with pytest.raises(CaseError, match="none of the triangles has an area"):
        MeshField.of(line, np.array([[0, 1, 2]]), np.ones(3))
    points = np.vstack([CORNERS, [0.5, 0.5]])
    field = MeshField.of(points, np.array([[0, 2, 4], [0, 1, 2], [0, 2, 3]]), np.array([1.0, 2, 3, 4, 9]))
    x = np.linspace(-0.5, 1.5, 50)
    np.testing.assert_allclose(field(x, x), 1 + 2 * np.clip(x, 0, 1), rtol=1e-12)


class TestScattered:
    def test_is_linear_between_the_points_and_nearest_outside_the_hull(self):
        rng = np.random.default_rng(0)
        points = np.vstack([rng.uniform(0, 1, (200, 2)), CORNERS])
        field = scattered(points, linear(*points.T))
        queries = rng.uniform(-1, 2, (1000, 2))
        np.testing.assert_allclose(field(*queries.T), linear(*np.clip(queries, 0, 1).T), rtol=1e-12)

    @pytest.mark.parametrize(("size", "origin"), [((1e-8, 1e-8), 0), ((1e9, 1e9), 0), ((1, 1e-6), 0), ((1, 1), 1e7)])
    def test_of_any_size_and_place(self, size, origin):
        points = np.vstack([np.random.default_rng(0).uniform(0, 1, (50, 2)), CORNERS])
        field = scattered(points * size + origin, linear(*points.T))
        at = np.random.default_rng(1).uniform(0, 1, (200, 2))
        np.testing.assert_allclose(field(*(at * size + origin).T), linear(*at.T), rtol=1e-6)

    def test_on_a_grid_every_point_keeps_its_value(self):
        points = np.stack(np.meshgrid(np.arange(9.0), np.arange(7.0)), axis=-1).reshape(-1, 2)
        values = np.random.default_rng(0).uniform(1, 2, len(points))
        np.testing.assert_allclose(scattered(points, values)(*points.T), values, rtol=1e-9)

    def test_points_may_come_twice_with_the_same_value(self):
        field = scattered(np.vstack([CORNERS, CORNERS]), np.tile([1.0, 2, 3, 2], 2))
        assert field(np.array([0.5]), np.array([0.5])) == pytest.approx(2)

    @pytest.mark.parametrize(
        ("points", "values", "message"),
        [
            ([[0, 0], [1, 0]], [1, 1], "lie on a line, or are fewer than three"),
            ([[0, 0], [1, 1], [0, 0]], [1, 1, 1], "lie on a line, or are fewer than three"),
            ([[0, 0], [0.1, 0.3], [0.2, 0.6], [0.3, 0.9]], [1, 1, 1, 1], "lie on a line"),
            ([[0, 0], [1, 0], [0, 1]], [1, -1, 1], r"is -1 at point 1 \(from 0\), \(1, 0\): a spacing"),
            (
                [[0, 0], [np.nan, 0], [0, 1]],
                [1, 1, 1],
                r"points: must be finite and at most 1e\+70 \(found nan in row 1\)",
            ),
            ([[0, 0], [1, 0], [0, 1], [1, 0]], [1, 2, 1, 3], r"points 1 and 3 \(from 0\) are both at \(1, 0\), with"),
        ],
    )
    def test_what_is_no_spacing_is_refused(self, points, values, message):
        with pytest.raises(CaseError, match=message):
            scattered(np.array(points, float), np.array(values, float))


def test_mesh_of_a_field_is_that_of_the_function_it_was_made_from():
    import shapely

    def h(x, y):
        return 0.03 + 0.1 * np.hypot(x - 0.2, y - 0.3)

    plate = shapely.box(0, 0, 1, 1)
    first = bubblemesh.mesh(plate, h)
    field = MeshField.of(first.points, first.triangles, h(*first.points.T))
    again = bubblemesh.mesh(plate, field)
    assert len(again.points) == pytest.approx(len(first.points), rel=0.02)
    assert field.scaled(0.5)(np.array([0.9]), np.array([0.3])) == pytest.approx(0.05, rel=0.01)


@pytest.mark.parametrize(
    "make", [MeshField.of, lambda points, triangles, values: MeshField.of_triangles(points, triangles, values[:1])]
)
def test_whole_numbers_are_taken_as_well(make):
    whole, triangles, values = np.array([[0, 0], [4, 0], [0, 4]]), np.array([[0, 1, 2]]), np.array([1, 2, 3])
    x = np.linspace(-3, 5, 9)
    found = make(whole, triangles, values)(x, x[::-1])
    np.testing.assert_array_equal(found, make(whole.astype(float), triangles, values.astype(float))(x, x[::-1]))
