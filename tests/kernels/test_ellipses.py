import numpy as np
import pytest
from metrics import random_tensors
from scattered_points import SIDES, scattered
from sweeps import sweep
from twins import needs_compiler

from bubblemesh.kernels.ellipse_flips import flipped, flipped_in_numpy
from bubblemesh.kernels.ellipse_motion import KEEP, moved, moved_in_numpy, relaxed, relaxed_in_numpy
from bubblemesh.kernels.ellipse_shapes import GOOD, Shaped, shape_measures, shape_measures_in_numpy
from bubblemesh.kernels.newton import BEND, Metrics, Newton, SmoothingTerms, costs_in, costs_in_numpy
from bubblemesh.kernels.shapes import eta
from bubblemesh.kernels.tensors import mapped, roots
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.meshes.tensors import of_axes
from bubblemesh.meshes.triangulation import linked, sorted_triangles
from bubblemesh.packing.neighbours import maximal_independent_set


def smooth_tensors(x, aspect):
    """Tensors (n, 3) that turn and stretch gently from place to place."""
    angle = x[:, 0] + 2 * x[:, 1]
    along = 0.06 * (1 + 0.3 * np.sin(5 * x[:, 1]))
    direction = np.column_stack([np.cos(angle), np.sin(angle)])
    return of_axes(along / (1 + (aspect - 1) * x[:, 0] ** 2), along, direction)


def start(seed, aspect=8.0):
    x = scattered(seed)
    return x, linked(x, SIDES)[0], smooth_tensors(x, aspect)


@needs_compiler
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("aspect", [1.0, 30.0])
def test_both_engines_flip_move_and_relax_alike(seed, aspect):
    x, triangles, m = start(seed, aspect)
    facets = np.concatenate([SIDES, triangles[:3, :2]])
    for found, expected in zip(
        flipped(triangles, x, m, facets), flipped_in_numpy(triangles, x, m, facets), strict=True
    ):
        np.testing.assert_array_equal(found, expected)
    triangles, edges = flipped(triangles, x, m, SIDES)
    moves = np.random.default_rng(seed).normal(scale=0.03, size=x.shape)
    moves[:4] = 0
    for found, expected in zip(moved(x, moves, triangles), moved_in_numpy(x, moves, triangles), strict=True):
        np.testing.assert_array_equal(found, expected)
    given = x, m, triangles, edges, 4, 8, 0.5, 1.0
    for found, expected in zip(relaxed(*given), relaxed_in_numpy(*given), strict=True):
        np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("seed", range(3))
def test_in_one_metric_everywhere_flips_make_the_delaunay_triangulation_of_the_stretched_nodes(seed):
    x, triangles, _ = start(seed)
    m = np.repeat(random_tensors(np.random.default_rng(seed), 1, 10), len(x), axis=0)
    stretched = mapped(roots(m), x)
    found, edges = flipped(triangles, x, m, SIDES)
    np.testing.assert_array_equal(sorted_triangles(found), sorted_triangles(linked(stretched, SIDES)[0]))
    assert len(edges) == 3 * len(x) - 3 - 4
    assert len({frozenset(edge) for edge in edges.tolist()}) == len(edges)


def test_facets_stay_whatever_the_metric_says():
    x = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    triangles, m = np.array([[0, 1, 2], [0, 2, 3]]), np.tile([1.0, -0.9, 1.0], (4, 1))
    diagonal = np.array([[2, 0]])
    kept, _ = flipped(triangles, x, m, np.concatenate([SIDES, diagonal]))
    turned, _ = flipped(triangles, x, np.tile([1.0, 0.9, 1.0], (4, 1)), SIDES)
    np.testing.assert_array_equal(kept, triangles)
    assert sorted(map(sorted, turned.tolist())) == [[0, 1, 3], [1, 2, 3]]


@pytest.mark.parametrize("seed", range(3))
def test_moves_of_any_length_invert_no_triangle(seed):
    x, triangles, _ = start(seed)
    moves = np.random.default_rng(seed).normal(scale=0.5, size=x.shape)
    moves[:4] = 0
    places, share = moved(x, moves, triangles)
    assert (signed_areas(places, triangles) >= KEEP * signed_areas(x, triangles) * (1 - 1e-9)).all()
    np.testing.assert_allclose(places, x + share[:, None] * moves)
    some, partly = moved(x, 0.1 * moves, triangles)
    assert (partly > 0).mean() > 0.3
    assert ((partly > 0) & (partly < 1)).any()
    assert (signed_areas(some, triangles) > 0).all()
    small, whole = moved(x, 1e-6 * moves, triangles)
    assert (whole == 1).all()
    np.testing.assert_array_equal(small, x + 1e-6 * moves)


def test_forces_in_a_metric_are_those_between_circles_in_the_stretched_plane():
    x, triangles, _ = start(1)
    m = np.repeat([[4.0, 0.0, 1.0]], len(x), axis=0) / 0.06**2
    triangles, edges = flipped(triangles, x, m, SIDES)
    round_ones = np.repeat([[1.0, 0.0, 1.0]], len(x), axis=0) / 0.06**2
    stretched = x * [2, 1]
    there, _ = relaxed(x, m, triangles, edges, 4, 3, 0.1, 1.0)
    plain, _ = relaxed(stretched, round_ones, triangles, edges, 4, 3, 0.1, 1.0)
    np.testing.assert_allclose(there * [2, 1], plain, atol=1e-12)
    assert np.abs(there - x).max() > 1e-3


def test_forces_are_in_balance_however_large_the_bubbles():
    """Else pressure would drive them from where they are small to where they are large."""
    x, triangles, m = start(2, 30.0)
    triangles, edges = flipped(triangles, x, m, SIDES)
    there, _ = relaxed(x, m, triangles, edges, 0, 1, 1e-3, 1.0)
    assert np.abs(there - x).max() > 1e-9
    np.testing.assert_allclose((there - x).sum(axis=0), 0, atol=1e-6 * np.abs(there - x).max())


def smoothing_problem(seed, aspect=8.0):
    """Nodes with triangles, the metrics of these, those of the nodes, axes, and groups of the inner nodes.

    One of the inner nodes in five has one axis only.
    """
    x, triangles, m = start(seed, aspect)
    triangles, edges = flipped(triangles, x, m, SIDES)
    random = np.random.default_rng(seed)

    def metrics(places):
        root = roots(smooth_tensors(places, aspect))
        return Metrics(places, root, random.normal(scale=0.1, size=(len(places), 6)) * np.tile(root, 2))

    left, groups = np.arange(len(x)) >= 4, []
    while left.any():
        chosen = maximal_independent_set(left, edges, np.arange(len(x)))
        groups.append(np.flatnonzero(chosen))
        left &= ~chosen
    inside, own = metrics(x[triangles].mean(axis=1)), metrics(x)
    axes = own.axes
    axes[::5] = np.column_stack([0.01 * random.normal(size=(len(axes[::5]), 2)), np.zeros((len(axes[::5]), 2))])
    return x, triangles, inside, own, axes, groups


@needs_compiler
@pytest.mark.parametrize(
    ("aspect", "terms", "seed"),
    sweep(
        [
            (*one, seed)
            for one in (
                (1.0, SmoothingTerms(0.5)),
                (30.0, SmoothingTerms(0.5)),
                (5.0, SmoothingTerms(2.0, 1.3, worst=True)),
                (1.0, SmoothingTerms(2.0, worst=True, bend=np.inf)),
            )
            for seed in range(4)
        ],
        quick=6,
    ),
)
def test_both_engines_smooth_alike(seed, aspect, terms):
    x, *given = smoothing_problem(seed, aspect)
    newton = Newton(*given, terms)
    np.testing.assert_array_equal(newton.moved(x, 3), newton.moved_in_numpy(x, 3))


@needs_compiler
@pytest.mark.parametrize("worst", [False, True])
@pytest.mark.parametrize("seed", range(2))
def test_both_engines_find_the_same_costs(seed, worst):
    x, triangles, inside, own, *_ = smoothing_problem(seed)
    triangles = np.concatenate([triangles, triangles[:3, ::-1]])  # some are inverted
    inside = inside.select(np.append(np.arange(len(triangles) - 3), [0, 1, 2]))
    given = x, triangles, inside, own, SmoothingTerms(0.6, 1.2, worst)
    np.testing.assert_array_equal(costs_in(*given), costs_in_numpy(*given))
    assert np.isinf(costs_in(*given)).sum() == 3


@needs_compiler
@pytest.mark.parametrize("seed", range(4))
def test_both_engines_flip_to_the_same_shapes(seed):
    x, triangles, _ = start(seed)
    inside = roots(smooth_tensors(x[triangles].mean(axis=1), 8.0))
    found, plain = (
        Shaped(triangles.copy(), measures(x, triangles, inside), inside.copy())
        for measures in (shape_measures, shape_measures_in_numpy)
    )
    facets = np.concatenate([SIDES, triangles[:3, :2]])
    fresh = np.random.default_rng(seed).random(len(triangles)) < 0.7
    for _ in range(3):
        flips = found.flips(len(x), facets, fresh)
        for part, other in zip(flips, plain.flips_in_numpy(len(x), facets, fresh), strict=True):
            np.testing.assert_array_equal(part, other)
        turned = flips.turned.reshape(-1, 3)
        there = roots(smooth_tensors(x[turned].mean(axis=1), 8.0))
        after = shape_measures(x, turned, there)
        fresh = found.flip(flips, after, there)
        np.testing.assert_array_equal(fresh, plain.flip_in_numpy(flips, after, there))
        assert fresh.any()
        for part, other in zip(found, plain, strict=True):
            np.testing.assert_array_equal(part, other)
    np.testing.assert_array_equal(found.measures, shape_measures(x, found.triangles, found.inside))
    assert found.measures.max() > GOOD


def test_shapes_in_a_metric_are_those_of_the_stretched_triangles():
    x, triangles, m = start(1)
    root = roots(m[:1])
    inside = np.repeat(root, len(triangles), axis=0)
    stretched = mapped(np.repeat(root, len(x), axis=0), x)
    np.testing.assert_allclose(shape_measures(x, triangles, inside), eta(stretched, triangles))
    assert np.isinf(shape_measures(x, triangles[:, ::-1], inside)).all()


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    "terms",
    [
        *(SmoothingTerms(0.0), SmoothingTerms(1.0), SmoothingTerms(1.0, 1.3, worst=True)),
        SmoothingTerms(1.0, worst=True, bend=np.inf),
    ],
)
def test_each_sweep_of_the_smoothing_lessens_the_sum_and_inverts_no_triangle(seed, terms):
    x, triangles, inside, own, axes, groups = smoothing_problem(seed)
    first, before = x, costs_in(x, triangles, inside, own, terms).sum()
    for _ in range(4):
        moved_on = Newton(triangles, inside, own, axes, groups, terms).moved(x, 1)
        np.testing.assert_array_equal(moved_on[:4], x[:4])
        after = costs_in(moved_on, triangles, inside, own, terms).sum()
        assert after < before
        assert (signed_areas(moved_on, triangles) > 0).all()
        x, before = moved_on, after
    went, ways = (x - first)[::5], axes[::5, :2]
    assert np.abs(went[1:]).max() > 1e-4
    np.testing.assert_allclose(went[:, 0] * ways[:, 1], went[:, 1] * ways[:, 0], atol=1e-15)


def test_a_triangle_that_the_metric_makes_equilateral_with_sides_of_1_costs_half():
    m = of_axes(np.array([0.1]), np.array([0.4]), np.array([[0.6, 0.8]]))
    corners = np.linalg.solve(
        [[roots(m)[0, 0], roots(m)[0, 1]], [0, roots(m)[0, 2]]], np.array([[0, 1, 0.5], [0, 0, np.sqrt(0.75)]])
    ).T
    inside = Metrics(corners.mean(axis=0)[None], roots(m), np.zeros((1, 6)))
    own = Metrics(corners, roots(m).repeat(3, axis=0), np.zeros((3, 6)))
    triangle = np.array([[0, 1, 2]])
    assert costs_in(corners, triangle, inside, own, SmoothingTerms(3.0))[0] == pytest.approx(0.5)
    larger = inside._replace(places=1.1 * inside.places)
    assert costs_in(corners * 1.1, triangle, larger, own, SmoothingTerms(0.0))[0] == pytest.approx(0.5)
    assert costs_in(corners * 1.1, triangle, larger, own, SmoothingTerms(3.0))[0] > 0.6
    assert costs_in(corners, triangle[:, ::-1], inside, own, SmoothingTerms(3.0))[0] == np.inf
    far = inside._replace(places=inside.places + 0.2)
    assert costs_in(corners, triangle, far, own, SmoothingTerms(3.0))[0] == np.inf


def test_sides_are_measured_by_the_metrics_of_both_ends():
    """A side that is 1 long in the metric at its middle, and far more at its ends, costs as much as at its ends."""
    corners, triangle = np.array([[0, 0], [1, 0], [0.5, np.sqrt(0.75)]]), np.array([[0, 1, 2]])
    inside = Metrics(corners.mean(axis=0)[None], np.array([[1.0, 0, 1.0]]), np.zeros((1, 6)))
    own = Metrics(corners, np.repeat([[2.0, 0, 2.0]], 3, axis=0), np.zeros((3, 6)))
    assert costs_in(corners, triangle, inside, own, SmoothingTerms(1.0))[0] == pytest.approx(0.5 + 3 * (4 + 0.25 - 2))


@pytest.mark.parametrize(("size", "beyond"), [(0.7, 0.7), (0.8, 1.25), (1.0, 1.25), (1.2, 1.25), (1.5, 1.5)])
def test_lengths_that_are_free_cost_nothing(size, beyond):
    corners, triangle = size * np.array([[0, 0], [1, 0], [0.5, np.sqrt(0.75)]]), np.array([[0, 1, 2]])
    inside = Metrics(corners.mean(axis=0)[None], np.array([[1.0, 0, 1.0]]), np.zeros((1, 6)))
    own = Metrics(corners, np.repeat([[1.0, 0, 1.0]], 3, axis=0), np.zeros((3, 6)))
    expected = 0.5 + 3 * ((beyond - 1 / beyond) ** 2 - 0.45**2)
    assert costs_in(corners, triangle, inside, own, SmoothingTerms(1.0, 1.25))[0] == pytest.approx(expected)


@pytest.mark.parametrize("height", [0.866, 0.9, 1.0, 1.5, 4.0])
@pytest.mark.parametrize(("worst", "k"), [(False, 2), (True, 8)])
@pytest.mark.parametrize("bend", [BEND, 2.0, np.inf])
def test_shapes_cost_by_a_high_power_and_bad_ones_by_the_fourth(height, worst, k, bend):
    corners, triangle = np.array([[0, 0], [1, 0], [0.5, height]]), np.array([[0, 1, 2]])
    inside = Metrics(corners.mean(axis=0)[None], np.array([[1.0, 0, 1.0]]), np.zeros((1, 6)))
    own = Metrics(corners, np.repeat([[1.0, 0, 1.0]], 3, axis=0), np.zeros((3, 6)))
    power = eta(corners, triangle)[0] ** 4
    expected = power**k / k if power <= bend else bend**k / k + bend ** (k - 1) * (power - bend)
    terms = SmoothingTerms(0.0, worst=worst, bend=bend)
    assert costs_in(corners, triangle, inside, own, terms)[0] == pytest.approx(expected)
