from dataclasses import replace

import numpy as np
import pytest
from lattices import DAMPED, hexagonal, packed_hexagon, uniform

from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.kernels.shapes import FLATTEST, WORST, eta, shape_gradient, spacing_gradient
from bubblemesh.meshes.quality import radius_ratios
from bubblemesh.packing.net import connect
from bubblemesh.packing.placement.diffusion import ErrorDiffusion
from bubblemesh.packing.relaxation import Connected
from bubblemesh.packing.smoothing import MOST_SMOOTHING_MOVE, WORSE, Smoothing
from bubblemesh.spacing.spacing import Spacing

DOMAIN = Domain.of(
    rings.path((0, 0), [rings.LineTo((3, 0)), rings.ArcTo((0, 3), (0, 0), True)]), [rings.circle((1, 1), 0.4)]
)
SPACING = Spacing(lambda x, y: 0.2 + 0.05 * np.hypot(x, y))


def relaxed_net(seed=0, domain=DOMAIN, spacing=SPACING):
    """A packing in disorder, but not more than the forces leave."""
    start = ErrorDiffusion()(domain, spacing, 10_000)
    x = start.x.copy()
    x[start.interior] += 0.01 * np.random.default_rng(seed).standard_normal(x[start.interior].shape)
    net = connect(replace(start, x=x), domain)
    bubbles = Connected()(net, domain, spacing, DAMPED, 60).bubbles
    return connect(replace(bubbles, d=spacing(bubbles.x)), domain)


def jittered(side=5, amplitude=0.2):
    domain, spacing, bubbles = packed_hexagon(side)
    x = bubbles.x.copy()
    x[bubbles.interior] += np.random.default_rng(0).uniform(-amplitude, amplitude, x[bubbles.interior].shape)
    return domain, spacing, connect(replace(bubbles, x=x), domain)


def looped_eta(a, b, c):
    squares = sum((p - q) @ (p - q) for p, q in ((a, b), (b, c), (c, a)))
    (ux, uy), (vx, vy) = b - a, c - a
    return squares / (2 * np.sqrt(3) * (ux * vy - uy * vx))


def differences(energy, x, h=1e-6):
    """Gradient by central differences."""
    result = np.zeros_like(x)
    for i in range(len(x)):
        for k in range(2):
            step = np.zeros_like(x)
            step[i, k] = h
            result[i, k] = (energy(x + step) - energy(x - step)) / (2 * h)
    return result


def test_shape_measure_of_known_triangles():
    x = np.array([[0, 0], [1, 0], [0.5, np.sqrt(3) / 2], [0, 1], [2, 0]])
    triangles = np.array([[0, 1, 2], [0, 1, 3], [0, 3, 1], [0, 1, 4], [2, 0, 1]])
    expected = [1, 2 / np.sqrt(3), np.inf, np.inf, 1]
    np.testing.assert_allclose(eta(x, triangles), expected, rtol=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_shape_measure_is_that_of_the_loop_whatever_the_size(seed):
    rng = np.random.default_rng(seed)
    x, triangles = (
        rng.random((30, 2)) * 10.0 ** rng.uniform(-8, 8),
        rng.permuted(np.tile(np.arange(30), (40, 1)), axis=1),
    )
    found = eta(x, triangles[:, :3])
    expected = np.array([looped_eta(*x[triangle]) for triangle in triangles[:, :3]])
    np.testing.assert_allclose(found, np.where(expected > 0, expected, np.inf), rtol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_shape_gradient_is_that_of_half_the_sum_of_counted_eighth_powers(seed):
    random = np.random.default_rng(seed)
    x = hexagonal(5, 4) + random.uniform(-0.1, 0.1, (20, 2))
    rows, columns = np.divmod(np.arange(20), 5)
    here = np.flatnonzero((columns < 4) & (rows % 2 == 0) & (rows < 3))
    triangles = np.vstack(
        [np.column_stack([here, here + 1, here + 5]), np.column_stack([here + 1, here + 6, here + 5])]
    )
    counts = random.uniform(0.5, 3, len(triangles))
    assert eta(x, triangles).max() < WORST

    def energy(x):
        return sum(often * looped_eta(*x[corners]) ** 8 / 2 for corners, often in zip(triangles, counts, strict=True))

    found = shape_gradient(x, triangles.T, np.ones(20), counts)
    np.testing.assert_allclose(found, differences(energy, x), rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("seed", range(3))
def test_spacing_gradient_is_that_of_the_sum_of_squares(seed):
    rng = np.random.default_rng(seed)
    x, ends = rng.random((12, 2)), np.array([rng.choice(12, 2, replace=False) for _ in range(30)]).T
    target = rng.uniform(0.1, 1, 30)

    def energy(x):
        return sum((np.hypot(*(x[i] - x[j])) / w - 1) ** 2 for (i, j), w in zip(ends.T, target, strict=True))

    np.testing.assert_allclose(spacing_gradient(x, ends, target), differences(energy, x), rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("height", [FLATTEST / 2, 0.0, -0.3])
def test_flat_and_inverted_triangles_are_pushed_to_the_right_side(height):
    x, corners = np.array([[0, 0], [1, 0], [0.5, height]]), np.array([[0], [1], [2]])
    gradient = shape_gradient(x, corners, np.ones(3), np.ones(1))
    assert np.isfinite(gradient).all()
    assert gradient[2, 1] < -1
    np.testing.assert_allclose(gradient.sum(axis=0), 0, atol=1e-9)


def test_coinciding_bubbles_have_a_finite_gradient():
    x, ends = np.zeros((2, 2)), np.array([[0], [1]])
    assert np.isfinite(spacing_gradient(x, ends, np.ones(1))).all()
    assert np.isfinite(shape_gradient(np.zeros((3, 2)), np.array([[0], [1], [2]]), np.ones(3), np.ones(1))).all()


def test_perfect_lattice_is_a_stationary_point():
    domain, spacing, bubbles = packed_hexagon(5)
    net = connect(bubbles, domain)
    gradient = shape_gradient(bubbles.x, net.triangles.T, bubbles.d, np.ones(len(net.triangles)))
    np.testing.assert_allclose(gradient[bubbles.interior], 0, atol=1e-12)
    np.testing.assert_allclose(spacing_gradient(bubbles.x, net.edges.T, np.ones(len(net.edges))), 0, atol=1e-12)
    smoothed = Smoothing()(net, domain, spacing)
    np.testing.assert_allclose(smoothed.bubbles.x, bubbles.x, atol=1e-12)


def test_jittered_lattice_gets_better_and_becomes_perfect():
    domain, spacing, net = jittered()
    _, _, perfect = packed_hexagon(5)
    worst = [eta(net.bubbles.x, net.triangles).max()]
    for _ in range(6):
        net = Smoothing()(net, domain, spacing)
        worst.append(eta(net.bubbles.x, net.triangles).max())
    assert worst[0] > 1.2
    assert worst[1] < 1 + 0.2 * (worst[0] - 1)
    assert worst == sorted(worst, reverse=True)
    np.testing.assert_allclose(net.bubbles.x, perfect.x, atol=1e-3)


@pytest.mark.parametrize("seed", range(3))
def test_smoothing_improves_shapes_and_lengths(seed):
    net = relaxed_net(seed)
    smoothed = Smoothing()(net, DOMAIN, SPACING)
    before, after = (radius_ratios(one.bubbles.x, one.triangles) for one in (net, smoothed))
    assert after.mean() > before.mean() + 0.005
    assert len(smoothed.bubbles) == len(net.bubbles)
    np.testing.assert_array_equal(smoothed.bubbles.d, SPACING(smoothed.bubbles.x))

    def spread(one):
        i, j = one.edges.T
        x, d = one.bubbles.x, SPACING(one.bubbles.x)
        return (np.hypot(*(x[i] - x[j]).T) / ((d[i] + d[j]) / 2)).std()

    assert spread(smoothed) < spread(net)


def test_weight_trades_shape_for_spacing():
    net = relaxed_net()
    spreads = []
    for weight in (0.0, 20.0):
        smoothed = Smoothing(spacing_weight=weight, shape_steps=40)(net, DOMAIN, SPACING)
        i, j = smoothed.edges.T
        x, d = smoothed.bubbles.x, smoothed.bubbles.d
        spreads.append((np.hypot(*(x[i] - x[j]).T) / ((d[i] + d[j]) / 2)).std())
    assert spreads[1] < 0.95 * spreads[0]


@pytest.mark.parametrize("seed", range(3))
def test_triangles_at_defects_get_better_where_they_count_more(seed):
    net = relaxed_net(seed)
    qualities = []
    for weight in (1.0, 2.0, 10.0):
        smoothed, smoothing = net, Smoothing(defect_weight=weight)
        for _ in range(4):
            smoothed = smoothing(smoothed, DOMAIN, SPACING)
        q = np.sort(radius_ratios(smoothed.bubbles.x, smoothed.triangles))
        qualities.append((q[: len(q) // 50].mean(), q.mean()))
    (plain, mean), (doubled, mean_of_doubled), (most, _) = qualities
    assert doubled > plain + 0.005
    assert mean_of_doubled > mean - 0.001
    assert most > plain  # steps do not overshoot


def smoothed_net(seed=0):
    net = relaxed_net(seed)
    for _ in range(3):
        net = Smoothing()(net, DOMAIN, SPACING)
    return net


@pytest.mark.parametrize("seed", range(3))
def test_the_last_pass_betters_the_worst_triangles_more_than_others_would(seed):
    net = smoothed_net(seed)
    before, plain, last = (
        np.sort(radius_ratios(one.bubbles.x, one.triangles))
        for one in (net, Smoothing()(net, DOMAIN, SPACING), Smoothing().of_worst(net, DOMAIN, SPACING))
    )
    worst = slice(len(before) // 50)
    assert last[worst].mean() > max(before[worst].mean(), plain[worst].mean()) + 0.005
    assert last.mean() > before.mean() - 0.002


def test_the_last_pass_leaves_bubbles_alone_that_are_at_no_bad_triangle():
    net = smoothed_net()
    bad = np.unique(net.triangles[eta(net.bubbles.x, net.triangles) > WORSE])
    assert 0 < len(bad) < 0.6 * len(net.bubbles)
    moved = Smoothing().of_worst(net, DOMAIN, SPACING)
    others = np.delete(np.arange(len(net.bubbles)), bad)
    np.testing.assert_array_equal(moved.bubbles.x[others], net.bubbles.x[others])
    way = np.hypot(*(moved.bubbles.x - net.bubbles.x)[bad[bad >= net.bubbles.corners]].T)
    assert (way > 0).all()


def test_the_last_pass_leaves_a_net_as_it_is_if_no_triangle_is_bad():
    domain, spacing, bubbles = packed_hexagon(5)
    smoothed = Smoothing().of_worst(connect(bubbles, domain), domain, spacing)
    np.testing.assert_array_equal(smoothed.bubbles.x, bubbles.x)


def test_without_passes_there_is_no_last_one():
    net = smoothed_net()
    assert Smoothing(passes=0).of_worst(net, DOMAIN, SPACING) is net


@pytest.mark.parametrize("smoothed", [Smoothing.__call__, Smoothing.of_worst])
def test_corners_stay_and_sliding_bubbles_stay_on_their_curve(smoothed):
    net = relaxed_net()
    before, after = net.bubbles, smoothed(Smoothing(), net, DOMAIN, SPACING).bubbles
    assert (after.corners, after.boundary_count) == (before.corners, before.boundary_count)
    np.testing.assert_array_equal(after.x[: after.corners], DOMAIN.boundary.corners)
    np.testing.assert_array_equal(after.piece, before.piece)
    np.testing.assert_array_equal(after.x[after.sliding], DOMAIN.boundary.points(after.piece, after.s))
    assert np.abs(after.s - before.s).max() > 1e-3
    assert np.abs(DOMAIN.signed_distance(after.x[after.sliding])).max() < 1e-12


def test_bubbles_that_are_not_free_stay_where_they_are():
    net = relaxed_net()
    free = np.random.default_rng(0).random(len(net.bubbles)) < 0.5
    moved = Smoothing().moved(net, DOMAIN, free)
    still = (moved.x == net.bubbles.x).all(axis=1)
    assert still[~free].all()
    assert not still[free & (np.arange(len(free)) >= net.bubbles.boundary_count)].any()


def test_no_bubble_moves_too_far_in_a_step():
    domain, _, net = jittered(amplitude=0.45)
    moved = Smoothing(shape_steps=1, shape_step=0.1).moved(net, domain, np.ones(len(net.bubbles), bool))
    way = np.hypot(*(moved.x - net.bubbles.x).T)
    assert way.max() == pytest.approx(MOST_SMOOTHING_MOVE)


@pytest.mark.parametrize("held_too", [False, True])
def test_smoothing_that_spoils_triangles_is_not_kept(held_too):
    domain, spacing, net = jittered()

    class Spoiling(Smoothing):
        """Puts a sliding bubble next to another one, if it may, or an interior one."""

        def moved(self, net, domain, free):
            bubbles = net.bubbles
            x, s = bubbles.x.copy(), bubbles.s.copy()
            if free[bubbles.corners]:
                s[0] = s[1] - 1e-3
                x[bubbles.corners] = domain.boundary.points(bubbles.piece[:1], s[:1])[0]
                return replace(bubbles, x=x, s=s)
            if held_too:
                x[-1] = x[-2] + 1e-3
                return replace(bubbles, x=x)
            return super().moved(net, domain, free)

    found = Spoiling()(net, domain, spacing)
    if held_too:
        assert found is net
    else:
        at = net.bubbles.boundary_count
        np.testing.assert_array_equal(found.bubbles.x[:at], net.bubbles.x[:at])
        assert eta(found.bubbles.x, found.triangles).max() < eta(net.bubbles.x, net.triangles).max()


def test_bubbles_given_stay_as_they_are():
    domain, spacing, net = jittered()
    before = net.bubbles.x.copy()
    Smoothing()(net, domain, spacing)
    np.testing.assert_array_equal(net.bubbles.x, before)


@pytest.mark.parametrize("scale", [2.0**-40, 2.0**60])
def test_smoothing_does_not_depend_on_the_unit_of_length(scale):
    _, _, net = jittered(3)
    domain, spacing = Domain.of(rings.polygon(3 * scale * hexagon_corners())), uniform(scale)
    bubbles = net.bubbles
    large = replace(bubbles, x=bubbles.x * scale, d=bubbles.d * scale, s=bubbles.s * scale)
    found = Smoothing()(connect(large, domain), domain, spacing)
    domain, spacing, net = jittered(3)
    np.testing.assert_allclose(found.bubbles.x / scale, Smoothing()(net, domain, spacing).bubbles.x, atol=1e-9)


def hexagon_corners():
    angle = np.arange(6) * np.pi / 3
    return np.column_stack([np.cos(angle), np.sin(angle)])


@pytest.mark.parametrize("width", [0.03, 0.005])
def test_boundary_edges_beside_a_thin_wall_do_not_come_to_cross(width):
    domain, spacing = Domain.of(rings.circle((0, 0), 1), [rings.circle((0, 0), 1 - width)]), uniform(0.5)
    net = connect(ErrorDiffusion()(domain, spacing, 10_000), domain)
    before = eta(net.bubbles.x, net.triangles).max()
    for _ in range(4):
        net = Smoothing()(net, domain, spacing)
        assert eta(net.bubbles.x, net.triangles).max() <= max(before, WORST)
    assert len(net.triangles) == len(net.facets)
