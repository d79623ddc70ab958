"""Kernels on numbers that no packing gives them: they end, and give what their twins in NumPy give."""

import numpy as np
import pytest
from scattered_points import SIDES
from twins import needs_compiler

from bubblemesh.geometry.distance.chord_runs import ChordRuns
from bubblemesh.geometry.distance.nearest_chord import nearest_chord, nearest_in_numpy
from bubblemesh.kernels.annealing import Acting, Cycles, Links, annealed
from bubblemesh.kernels.ellipse_flips import flipped, flipped_in_numpy
from bubblemesh.kernels.ellipse_motion import moved, moved_in_numpy, relaxed, relaxed_in_numpy
from bubblemesh.kernels.enclosing import enclosed
from bubblemesh.kernels.linking import in_order, in_order_in_numpy, legalised
from bubblemesh.kernels.newton import Metrics, Newton, SmoothingTerms
from bubblemesh.kernels.pairs import pairs_within
from bubblemesh.kernels.refining import refined_triangles
from bubblemesh.kernels.relaxing import Steps
from bubblemesh.kernels.shapes import Descent, eta, eta_in_numpy
from bubblemesh.kernels.spreading import spread, spread_in_numpy
from bubblemesh.meshes.triangulation import linked

pytestmark = [needs_compiler, pytest.mark.long]
TRIALS = 150


def odd(random, shape):
    """Numbers of all sizes, many of them alike, and some that are none."""
    numbers = random.normal(size=shape) * 10.0 ** random.integers(-12, 12, shape)
    numbers = np.where(random.random(shape) < 0.3, np.round(numbers), numbers)
    bad = random.choice([np.inf, -np.inf, np.nan, 0.0, 1e308, 5e-324], shape)
    return np.where(random.random(shape) < random.choice([0, 0.05]), bad, numbers)


def different(random, n, count):
    """Triangles (count, 3) of three different ones of n nodes each."""
    return np.array([random.choice(n, 3, replace=False) for _ in range(count)], np.int64).reshape(-1, 3)


@pytest.mark.parametrize("seed", range(TRIALS))
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_any_numbers_spread_alike(seed):
    random = np.random.default_rng(seed)
    vertices, cells = int(random.integers(4, 60)), int(random.integers(0, 40))
    corners = np.array([random.permutation(vertices)[:4] for _ in range(cells)], np.int64).reshape(-1, 4)
    for place in range(4):  # no two cells have a vertex at the same corner
        corners = corners[np.sort(np.unique(corners[:, place], return_index=True)[1])]
    rise = np.abs(odd(random, len(corners))) + 1e-300
    rise[~np.isfinite(rise)] = 1.0
    values = np.abs(odd(random, vertices))
    values[np.isnan(values)] = np.inf
    found = spread(np.ascontiguousarray(corners), rise, values, 1e-6)
    np.testing.assert_array_equal(found, spread_in_numpy(corners, rise, values, 1e-6))


@pytest.mark.parametrize("seed", range(TRIALS))
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_any_triangles_are_bettered_alike(seed):
    random = np.random.default_rng(seed)
    n = int(random.integers(3, 50))
    triangles = different(random, n, random.integers(0, 80)).reshape(-1, 3)
    edges = random.integers(0, n, (int(random.integers(0, 80)), 2))
    d, x, scale = random.uniform(1e-3, 1, n), odd(random, (n, 2)), odd(random, n) * random.integers(0, 2, n)
    fixed = int(random.integers(0, n))
    tangents = odd(random, (int(random.integers(0, n - fixed)), 2))
    counts, groups, weights = odd(random, len(triangles)), (fixed, len(tangents)), (7.0, 0.8, 0.015)
    descent = Descent(triangles, counts, edges, d, scale, odd(random, n), *groups, *weights)
    found, plain = descent.moved(x, tangents, 2), descent.moved_in_numpy(x, tangents, 2)
    finite = np.isfinite(found) & np.isfinite(plain)  # where both have no number it may be another one
    np.testing.assert_array_equal(found[finite], plain[finite])
    np.testing.assert_array_equal(np.isfinite(found), np.isfinite(plain))


@pytest.mark.parametrize("seed", range(TRIALS))
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_any_triangles_have_the_same_shape_measures(seed):
    random = np.random.default_rng(seed)
    n = int(random.integers(3, 50))
    x, triangles = odd(random, (n, 2)), random.integers(0, n, (int(random.integers(0, 80)), 3))
    np.testing.assert_array_equal(eta(x, triangles), eta_in_numpy(x, triangles))


@pytest.mark.parametrize("seed", range(TRIALS))
def test_any_triangles_are_put_in_the_same_order(seed):
    random = np.random.default_rng(seed)
    n = int(random.integers(3, 40))
    triangles = different(random, n, random.integers(1, 60))
    for found, plain in zip(in_order(triangles, n), in_order_in_numpy(triangles, n), strict=True):
        np.testing.assert_array_equal(found, plain)


@pytest.mark.parametrize("seed", range(TRIALS))
def test_triangles_that_are_no_triangulation_are_left_alone_or_flipped(seed):
    random = np.random.default_rng(seed)
    n = int(random.integers(4, 40))
    triangles = different(random, n, random.integers(1, 60))
    facets = np.sort(random.integers(0, n, (int(random.integers(1, 10)), 2)), axis=1)
    found = legalised(triangles, odd(random, (n, 2)), odd(random, (n, 2)), facets, is_open=bool(seed % 4))
    if found is not None:
        assert all(((part >= 0) & (part < n)).all() for part in (found.triangles, found.edges))
        assert ((found.twins >= -1) & (found.twins < found.twins.size)).all()
        again = legalised(found.triangles, odd(random, (n, 2)), odd(random, (n, 2)), facets, found)
        assert again is None or again.triangles.shape == found.triangles.shape


@pytest.mark.parametrize("seed", range(TRIALS))
def test_any_bubbles_are_annealed_somehow(seed):
    random = np.random.default_rng(seed)
    n = int(random.integers(4, 40))
    triangles, edges = in_order(different(random, n, random.integers(1, 60)), n)
    twins = random.integers(-1, triangles.size, triangles.shape).astype(np.int32) if seed % 2 else None
    if twins is not None:  # the twin of each twin is the side itself
        sides = np.arange(triangles.size).reshape(-1, 3)
        twins[twins >= 0] = -1
        twins[0, 0], twins[-1, 2] = sides[-1, 2], sides[0, 0]
    facets = np.sort(random.integers(0, n, (int(random.integers(0, 10)), 2)), axis=1)
    links = Links(triangles, edges, twins, facets, odd(random, (n, 2)))
    cycles, steps = int(random.integers(1, 6)), int(random.integers(1, 4))
    rules = Steps(int(random.integers(0, n)), np.abs(odd(random, n)), 0.5, odd(random, steps))
    acting = Acting(np.abs(odd(random, n)), odd(random, n), 1.5)
    sizes = np.abs(odd(random, cycles)), np.abs(odd(random, cycles))
    displacements = Cycles(int(random.integers(2**63)), int(random.integers(9)), *sizes, random.random(n) < 0.2)
    found = annealed(odd(random, (n, 2)), links, acting, rules, displacements)
    assert found.x.shape == (n, 2)
    assert len(found.speeds) <= cycles
    if found.legal is not None:
        assert len(found.speeds) == cycles
        assert all(((part >= 0) & (part < n)).all() for part in (found.legal.triangles, found.legal.edges))


@pytest.mark.parametrize("seed", range(TRIALS))
def test_any_triangles_are_refined_somehow(seed):
    random = np.random.default_rng(seed)
    n = int(random.integers(3, 40))
    triangles, edges = in_order(different(random, n, random.integers(0, 60)), n)
    if seed % 3 == 0:
        edges = edges[random.random(len(edges)) < 0.7]
    number = random.integers(-1, 100, n)
    middle = random.integers(-2, 100, len(edges))
    found, sides = refined_triangles(triangles, edges, number, middle)
    assert len(triangles) * 4 >= len(found)
    assert (found >= 0).all()
    assert (sides >= 0).all()


@pytest.mark.parametrize("seed", range(TRIALS))
def test_any_chords_are_found_alike(seed):
    random = np.random.default_rng(seed)
    count = int(random.integers(1, 200))
    start = random.normal(size=(count, 2)) * 10.0 ** random.integers(-9, 9)
    start = np.where(random.random((count, 1)) < 0.3, np.round(start), start)
    end = np.where(random.random((count, 1)) < 0.8, np.roll(start, -1, axis=0), random.permutation(start))
    runs = ChordRuns.of(start, end)
    points = np.vstack([start, (start + end) / 2, 3 * np.abs(start).max() * random.normal(size=(100, 2))])
    np.testing.assert_array_equal(nearest_chord(runs, points), nearest_in_numpy(runs, points))


@pytest.mark.parametrize("seed", range(TRIALS))
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_any_points_have_the_pairs_of_a_double_loop(seed):
    random = np.random.default_rng(seed)
    n = int(random.integers(0, 60))
    x, d = odd(random, (n, 2)), np.abs(odd(random, n))
    apart, most = x[:, None] - x, 1.9 * (d[:, None] + d) / 2
    near = np.triu((apart * apart).sum(axis=2) < most * most, 1)
    np.testing.assert_array_equal(pairs_within(x, d, 1.9), np.argwhere(near))


def linked_tensors(random):
    """A triangulation with tensors of all sizes at its nodes; a metric's checks let none pass that are no numbers."""
    x = random.random((int(random.integers(4, 40)), 2))
    x = np.concatenate([[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], x])
    tensors = np.clip(np.nan_to_num(np.abs(odd(random, (len(x), 3)))), 1e-20, 1e20)
    tensors[:, 1] = 0.9 * (2 * random.random(len(x)) - 1) * np.sqrt(tensors[:, 0]) * np.sqrt(tensors[:, 2])
    return x, linked(x, SIDES)[0], tensors


def assert_alike(found, plain):
    """Both have numbers at the same places, and the same ones."""
    np.testing.assert_array_equal(np.isfinite(found), np.isfinite(plain))
    finite = np.isfinite(found)
    np.testing.assert_array_equal(found[finite], plain[finite])


@pytest.mark.parametrize("seed", range(TRIALS))
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_any_tensors_flip_alike(seed):
    x, triangles, tensors = linked_tensors(np.random.default_rng(seed))
    for found, plain in zip(
        flipped(triangles, x, tensors, SIDES), flipped_in_numpy(triangles, x, tensors, SIDES), strict=True
    ):
        np.testing.assert_array_equal(found, plain)


@pytest.mark.parametrize("seed", range(TRIALS))
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_any_moves_are_guarded_alike(seed):
    random = np.random.default_rng(seed)
    x, triangles, _ = linked_tensors(random)
    moves = odd(random, x.shape)
    for found, plain in zip(moved(x, moves, triangles), moved_in_numpy(x, moves, triangles), strict=True):
        assert_alike(found, plain)


@pytest.mark.parametrize("seed", range(TRIALS))
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_any_ellipses_relax_alike(seed):
    random = np.random.default_rng(seed)
    x, triangles, tensors = linked_tensors(random)
    edges = random.integers(0, len(x), (int(random.integers(0, 80)), 2))
    given = x, tensors, triangles, edges, int(random.integers(0, len(x))), 3, 0.5, 1.0
    for found, plain in zip(relaxed(*given), relaxed_in_numpy(*given), strict=True):
        assert_alike(found, plain)


@pytest.mark.parametrize("seed", range(TRIALS))
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_any_metrics_are_smoothed_alike(seed):
    random = np.random.default_rng(seed)
    x, triangles, _ = linked_tensors(random)
    inside, own = (
        Metrics(places, odd(random, (len(places), 3)), odd(random, (len(places), 6)))
        for places in (x[triangles].mean(axis=1), x)
    )
    apart = [np.array([node]) for node in random.permutation(len(x))[:5].tolist()]
    newton = Newton(triangles, inside, own, odd(random, (len(x), 4)), apart, SmoothingTerms(0.6, worst=seed % 2 == 1))
    assert_alike(newton.moved(x, 2), newton.moved_in_numpy(x, 2))


@pytest.mark.parametrize("seed", range(TRIALS))
def test_any_cells_and_rings_enclose_some_of_the_cells_or_none(seed):
    random = np.random.default_rng(seed)
    n, t = int(random.integers(1, 30)), int(random.integers(0, 40))
    cells = random.integers(0, n + 3, (t, 6)).astype(np.uint32)
    cells[:, 3:] = random.integers(0, t + 2, (t, 3))  # numbers of neighbours, of which there may be none
    cells[random.random((t, 6)) < 0.1] = 2**32 - 1
    cells[:, :3] %= n + 3
    found = enclosed(cells, random.integers(0, n, (int(random.integers(0, 20)), 2)), n)
    assert found is None or (len(found) <= t and ((found >= -3) & (found < n)).all())
