from dataclasses import replace
from itertools import pairwise, product

import numpy as np
import pytest
from ellipse_packings import METHOD, SQUARE, front, packed, settled_ellipses, settled_net
from lattices import hexagon, hexagon_domain
from metrics import tensor_metric, uniform_metric
from sweeps import sweep
from twins import needs_compiler

from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.paths import Area
from bubblemesh.kernels.ellipse_annealing import Relaxing
from bubblemesh.kernels.newton import SmoothingTerms
from bubblemesh.kernels.tensors import roots
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.meshes.tensors import area_sizes, of_axes
from bubblemesh.packing.ellipses import smoothing
from bubblemesh.packing.ellipses.annealing import SPARED, EllipseAnnealing
from bubblemesh.packing.ellipses.mending import EllipseMending
from bubblemesh.packing.ellipses.net import connected, flipped_net
from bubblemesh.packing.ellipses.smoothing import (
    EllipseSmoothing,
    NoEllipseSmoothing,
    costs,
    roots_by,
)
from bubblemesh.packing.newton import changes_at, independent_groups, independent_groups_in_numpy
from bubblemesh.packing.placement import Perturbation
from bubblemesh.packing.placement.diffusion import boundary_bubbles
from bubblemesh.packing.progress import TimeUp
from bubblemesh.spacing.metric.metric import MetricSpacing

COARSE = uniform_metric(0.1, 0.2, 0.5)


def stretched_hexagon(side, factor):
    """A hexagon that is longer along x by a factor: a lattice of ellipses fills it."""
    corners = hexagon_domain(side).boundary.corners * [factor, 1]
    return Domain.of(rings.polygon(corners))


@pytest.mark.parametrize("factor", sweep([2.5, 1.0, 20.0], quick=1))
def test_a_uniform_stretch_gives_the_perfect_lattice_from_most_starts(factor):
    domain, spacing = stretched_hexagon(6, factor), uniform_metric(1.0, factor, 0.0)
    perfect = []
    for seed in range(10):
        *_, last = packed(domain, spacing, method=replace(METHOD, perturbation=Perturbation(seed=seed)))
        x, triangles = last.net.bubbles.x, last.net.triangles
        perfect.append(spacing.measures(x, triangles).radius_ratios.min() > 0.999)
        if perfect[-1]:
            assert len(x) == len(hexagon(6))
            nearest = np.abs(x[:, None] / [factor, 1] - hexagon(6)).max(axis=2).min(axis=1)
            assert nearest.max() < 0.02
    assert sum(perfect) >= 7


@pytest.mark.parametrize("spacing", [uniform_metric(0.05, 0.2, 0.5), front()], ids=["uniform", "front"])
def test_rounds_follow_each_other_and_tell_the_reason_last(spacing):
    found = packed(SQUARE, spacing)
    assert [done.number for done in found] == list(range(1, len(found) + 1))
    assert [done.stop_reason is None for done in found] == [True] * (len(found) - 1) + [False]
    for done in found:
        assert (signed_areas(done.bubbles.x, done.net.triangles) > 0).all()
        assert signed_areas(done.bubbles.x, done.net.triangles).sum() == pytest.approx(1)
    assert all(done.deleted >= 0 for done in found)


@pytest.fixture(scope="module")
def narrow():
    """A metric, and the number of bubbles of a whole packing in it."""
    spacing = uniform_metric(0.02, 0.2, 0.5)
    return spacing, len(packed(SQUARE, spacing)[-1].bubbles)


@pytest.mark.parametrize("share", [0.0, 0.2, 0.7])
def test_when_the_time_is_up_the_mesh_is_brought_to_the_last_metric(share, narrow):
    told = []

    def watch(done):
        told.append(done)
        if done >= share:
            raise TimeUp("no time")

    spacing, count = narrow
    *earlier, last = packed(SQUARE, spacing, watch)
    assert told == sorted(told)
    assert (last.stop_reason, last.late) == ("no time", True)
    assert not any(done.late for done in earlier)
    assert last.number == len(earlier) + 1
    assert not earlier or last.before == len(earlier[-1].bubbles)
    x, triangles = last.net.bubbles.x, last.net.triangles
    assert (signed_areas(x, triangles) > 0).all()
    assert 0.6 < len(x) / count < 1.3


def test_bubbles_have_the_metric_of_their_places_when_the_time_is_up_between_two_looks_at_it():
    def watch(done):
        if done > 0.3:
            raise TimeUp("no time")

    *_, last = packed(SQUARE, front(), watch)
    x = last.net.bubbles.x
    np.testing.assert_array_equal(last.net.bubbles.d, area_sizes(front().at(x)))
    assert (signed_areas(x, last.net.triangles) > 0).all()


FINISHES = {
    "whole": ({}, {}),
    "no attempts": ({}, {"mend_attempts": 0}),
    "three passes": ({"passes": 3}, {}),
    "two passes": ({"passes": 2}, {}),
    "one pass": ({"passes": 1}, {}),
}


@pytest.mark.parametrize(("smoothing", "mending"), FINISHES.values(), ids=FINISHES)
def test_shares_are_told_after_each_pass(smoothing, mending, monkeypatch):
    calls = []

    def counted(*given):
        calls.append(len(told))
        return smoothed(*given)

    smoothed = EllipseSmoothing.__call__
    monkeypatch.setattr(EllipseSmoothing, "__call__", counted)
    told, method = [], with_finish(smoothing, mending)
    packed(SQUARE, COARSE, told.append, method)
    assert told == sorted(told)
    assert told[-1] == 1
    assert len(calls) == method.smoothing.passes
    assert all(later > earlier for earlier, later in pairwise([*calls, len(told)]))


@pytest.mark.parametrize(("attempts", "times"), [(0, 0), (2, 2), (32, 3)])
def test_bubbles_leave_between_the_first_passes_as_often_as_attempts_are_made_at_most(attempts, times, monkeypatch):
    calls = []

    def counted(*given):
        calls.append(len(given))
        return fewer(*given)

    fewer = EllipseMending.fewer
    monkeypatch.setattr(EllipseMending, "fewer", counted)
    packed(SQUARE, COARSE, method=with_finish({"passes": 6}, {"mend_attempts": attempts}))
    assert len(calls) == times


@pytest.mark.parametrize(("passes", "before"), [(1, 0), (2, 0), (3, 1), (6, 4)])
def test_trials_come_before_the_last_two_passes(passes, before, monkeypatch):
    order = []
    for name, scheme, method in (("smoothed", EllipseSmoothing, "__call__"), ("tried", EllipseMending, "tried")):
        function = getattr(scheme, method)

        def noted(*given, name=name, function=function):
            order.append(name)
            return function(*given)

        monkeypatch.setattr(scheme, method, noted)
    packed(SQUARE, COARSE, method=with_finish({"passes": passes}, {}))
    assert order.count("smoothed") == passes
    assert order.index("tried") == before


def with_finish(smoothing, mending):
    """The method with some other keys of smoothing and mending."""
    return replace(METHOD, smoothing=replace(METHOD.smoothing, **smoothing), mending=replace(METHOD.mending, **mending))


def test_two_runs_are_the_same():
    first, second = (packed(SQUARE, uniform_metric(0.05, 0.2, 0.5))[-1] for _ in range(2))
    np.testing.assert_array_equal(first.bubbles.x, second.bubbles.x)
    np.testing.assert_array_equal(first.net.triangles, second.net.triangles)


def test_bubbles_come_to_long_edges_where_the_area_lacks_them():
    spacing = uniform_metric(0.1, 0.2, 0.0)
    shell = boundary_bubbles(SQUARE, spacing)
    net = connected(shell.append(np.array([[0.5, 0.5]]), np.ones(1)), SQUARE, spacing)
    change = METHOD.population(net, spacing)
    assert len(change.net.tensors) == len(net.tensors) + change.inserted
    assert change.inserted >= 1
    assert (signed_areas(change.net.net.bubbles.x, change.net.net.triangles) > 0).all()


def test_as_many_bubbles_are_packed_as_the_area_in_the_metric_has_room_for():
    *_, last = packed(SQUARE, front())
    x, triangles = last.net.bubbles.x, last.net.triangles
    density = 1 / front()(x[triangles].mean(axis=1)) ** 2
    areas = signed_areas(x, triangles) * density / (np.sqrt(3) / 4)
    # Trials go by the metric that is asked for: where ellipses are shorter they take some bubbles away.
    assert areas.sum() == pytest.approx(len(triangles), rel=0.04)
    assert front().measures(x, triangles).radius_ratios.mean() > 0.95


@pytest.mark.parametrize("across", [1e-3, 1e-4])
def test_layers_far_thinner_than_the_cells_of_the_start_get_their_bubbles(across):
    def tensors(x, y):
        sizes = np.minimum(across + 0.2 * np.maximum(y, 0), 0.1), np.full(len(x), 0.1)
        return of_axes(*sizes, np.tile([1.0, 0.0], (len(x), 1)))

    *_, last = packed(SQUARE, tensor_metric(tensors, 0.1 / across))
    x = last.bubbles.x[last.bubbles.interior]
    low, high = 5 * across, 100 * across
    expected = 2 / np.sqrt(3) * np.log((across + 0.2 * high) / (across + 0.2 * low)) / (0.1 * 0.2)
    assert ((x[:, 1] > low) & (x[:, 1] < high)).sum() == pytest.approx(expected, rel=0.2)  # half of them were missing


def test_annealing_leaves_bubbles_alone_where_ellipses_are_shorter():
    spacing, net = front(), settled_ellipses()
    still = Relaxing(net.net.bubbles.boundary_count, 0, 0.5, 1.0)
    first, _ = next(METHOD.annealing(net, spacing, METHOD.relaxation, still, np.random.default_rng(0)))
    before, free = net.net.bubbles.x, spacing.shares(net.net.bubbles.x) > SPARED
    stayed = (first.net.bubbles.x == before).all(axis=1)
    assert not free.all()
    assert stayed[~free].all()
    assert not stayed[free].all()


def test_bubbles_stay_where_they_were_if_annealing_piles_them_up(monkeypatch):
    def piled(scheme, ellipses, *given):
        x = ellipses.net.bubbles.x.copy()
        x[ellipses.interior] = 0.5 + 0.9 * (x[ellipses.interior] - 0.5)
        yield ellipses.at(x), 1

    found = []
    for annealing in (piled, lambda *given: iter(())):
        monkeypatch.setattr(EllipseAnnealing, "__call__", annealing)
        found.append(packed(SQUARE, COARSE)[-1].net.bubbles.x)
    np.testing.assert_array_equal(*found)


def test_bubbles_stay_where_they_were_if_the_time_is_up_while_annealing_piles_them_up(monkeypatch):
    going = []

    def piled(scheme, ellipses, *given):
        x = ellipses.net.bubbles.x.copy()
        x[ellipses.interior] = 0.5 + 0.9 * (x[ellipses.interior] - 0.5)
        going.append(ellipses)
        yield ellipses.at(x), 1

    def watch(done):
        if going:
            raise TimeUp("no time")

    monkeypatch.setattr(EllipseAnnealing, "__call__", piled)
    *_, last = packed(SQUARE, front(), watch)
    np.testing.assert_array_equal(last.net.bubbles.x, going[0].net.bubbles.x)


def test_trials_made_when_the_time_is_up_are_not_lost(monkeypatch):
    done = []

    def noted(*given):
        for each in tried(*given):
            done.append(each)
            yield each

    def watch(share):
        if len(done) == 3:
            raise TimeUp("no time")

    tried = EllipseMending.tried
    monkeypatch.setattr(EllipseMending, "tried", noted)
    *_, last = packed(SQUARE, front(), watch)
    assert len(done) == 3
    np.testing.assert_array_equal(last.net.bubbles.x, done[-1].x)


@pytest.mark.parametrize(
    "smoothing", [NoEllipseSmoothing(), replace(METHOD.smoothing, passes=0)], ids=["none", "no pass"]
)
def test_without_smoothing_no_trials_are_expected(smoothing):
    assert replace(METHOD, smoothing=smoothing).finishing_work(1000) == 0


def test_smoothing_goes_by_the_metric_that_is_asked_for():
    spacing, net = front(), settled_ellipses()
    wider = MetricSpacing.of(lambda x, y: spacing.ellipses(x, y).wider(2.0), bent=spacing.bent)
    done, other = (METHOD.smoothing(net, SQUARE, one) for one in (spacing, wider))
    np.testing.assert_array_equal(done.net.bubbles.x, other.net.bubbles.x)


def test_metrics_of_triangles_are_linear_around_them():
    spacing, centers = front(), np.array([[0.2, 0.4], [0.6, 0.8]])
    root = roots(spacing.at(centers))
    slopes = changes_at(centers, root, roots_by(spacing))
    r11, r12, r22 = root.T
    there = centers + 0.05 * np.column_stack([1 / r11, np.zeros(2)])
    np.testing.assert_allclose(root + 0.05 * slopes[:, :3], roots(spacing.at(there)), rtol=0.01)
    there = centers + 0.05 * np.column_stack([-r12 / (r11 * r22), 1 / r22])
    np.testing.assert_allclose(root + 0.05 * slopes[:, 3:], roots(spacing.at(there)), rtol=0.01)


@needs_compiler
@pytest.mark.parametrize("seed", range(3))
def test_both_engines_find_the_same_groups_of_nodes(seed):
    net = settled_net()
    chosen = np.random.default_rng(seed).random(len(net.bubbles)) < 0.8
    groups, plain = (find(chosen, net.triangles) for find in (independent_groups, independent_groups_in_numpy))
    for some, others in zip(groups, plain, strict=True):
        np.testing.assert_array_equal(some, others)
    np.testing.assert_array_equal(np.sort(np.concatenate(groups)), np.flatnonzero(chosen))


def qualities():
    *_, last = packed(SQUARE, COARSE)
    return COARSE.measures(last.net.bubbles.x, last.net.triangles).radius_ratios


def test_the_last_passes_let_lengths_be_for_better_shapes(monkeypatch):
    free = qualities().mean()
    monkeypatch.setattr(smoothing, "FREE", 1.0)
    assert free > qualities().mean()


def test_the_last_passes_are_for_the_worst_shapes(monkeypatch):
    worst = np.sort(qualities())[:8].mean()
    monkeypatch.setattr(smoothing, "SmoothingTerms", lambda *of, worst=False: SmoothingTerms(*of))
    assert worst > np.sort(qualities())[:8].mean() + 0.003


def test_smoothing_and_mending_lessen_what_triangles_cost():
    spacing, net = front(), settled_net()
    ellipses = connected(net.bubbles, SQUARE, spacing)

    def total(some):
        return costs(some.net.bubbles.x, some.net.triangles, spacing, METHOD.smoothing).sum()

    better = METHOD.smoothing(ellipses, SQUARE, spacing)
    assert total(better) < total(ellipses)
    fewer = METHOD.mending.fewer(ellipses, spacing, METHOD.smoothing)
    assert len(fewer.tensors) < len(ellipses.tensors)
    assert total(fewer) < total(ellipses)
    for some in (better, fewer):
        x, triangles = some.net.bubbles.x, some.net.triangles
        assert (signed_areas(x, triangles) > 0).all()
        assert signed_areas(x, triangles).sum() == pytest.approx(1)
        assert len(some.net.edges) == len(x) + len(triangles) - 1
        np.testing.assert_allclose(some.tensors, spacing.at(some.known))


def disc(radius):
    return Domain.of(rings.circle((0, 0), radius))


def shifted(domain, spacing):
    """Ellipses of a packed domain, and those on its boundary a third of the way to the next one."""
    net = packed(domain, spacing)[-1].net
    bubbles, boundary = net.bubbles, domain.boundary
    s = bubbles.s + 0.3 * np.mod(np.roll(bubbles.s, -1) - bubbles.s, boundary.lengths[0])
    x = bubbles.x.copy()
    x[bubbles.sliding] = boundary.points(bubbles.piece, s)
    return flipped_net(net, replace(bubbles, x=x, s=s), net.triangles, spacing)


def test_bubbles_on_a_curve_slide_along_it_to_better_triangles():
    domain, spacing = disc(1.0), uniform_metric(0.1, 0.25, 0.3)
    before = shifted(domain, spacing)
    x = before.net.bubbles.x
    after = METHOD.smoothing(before, domain, spacing).net
    count = before.net.bubbles.boundary_count
    np.testing.assert_allclose(np.hypot(*after.bubbles.x[:count].T), 1, rtol=1e-12)
    there = domain.boundary.points(after.bubbles.piece, after.bubbles.s)
    np.testing.assert_array_equal(after.bubbles.x[after.bubbles.sliding], there)
    assert (np.hypot(*(after.bubbles.x - x)[:count].T) > 1e-3).mean() > 0.9
    assert (signed_areas(after.bubbles.x, after.triangles) > 0).all()
    total_before, total_after = (
        costs(net.bubbles.x, net.triangles, spacing, METHOD.smoothing).sum() for net in (before.net, after)
    )
    tied = disc(1.0)
    tied.__dict__["tied"] = np.array([True])
    held = METHOD.smoothing(before, tied, spacing).net
    np.testing.assert_array_equal(held.bubbles.x[:count], x[:count])
    total_held = costs(held.bubbles.x, held.triangles, spacing, METHOD.smoothing).sum()
    assert total_after < total_held < total_before


def test_the_boundary_stays_where_too_little_would_be_left_of_a_triangle_put_back_on_its_curve(monkeypatch):
    domain, spacing = disc(1.0), uniform_metric(0.1, 0.25, 0.3)
    before = shifted(domain, spacing)
    on_curve = before.net.bubbles.sliding
    monkeypatch.setattr("bubblemesh.kernels.ellipse_motion.KEEP", 0.999)
    net = METHOD.smoothing(before, domain, spacing).net
    np.testing.assert_allclose(net.bubbles.x[on_curve], before.net.bubbles.x[on_curve], atol=1e-12)
    assert (signed_areas(net.bubbles.x, net.triangles) > 0).all()


@pytest.mark.parametrize(("gap", "seed"), sweep(product([0.0012, 0.0014], range(3)), quick=2))
def test_the_boundary_stays_where_edges_would_cross_in_a_thin_gap(gap, seed):
    """Across the gap there is no triangle that could be inverted."""
    around = Area(rings.rectangle(0, 0, 1, 1), (rings.circle((0.5, 0.5), 0.3),))
    domain = Domain.of_areas([around, Area(rings.circle((0.5, 0.5), 0.3 - gap), ())])
    method = replace(METHOD, perturbation=Perturbation(seed=seed))
    *_, last = packed(domain, uniform_metric(0.05, 0.05, 0.4), method=method)
    assert last.net.has_simple_rim


EFFORTS = ["fast", "normal", "best"]


@pytest.mark.parametrize("effort", sweep(EFFORTS, quick=2))
def test_what_is_told_before_the_end_is_near_to_what_is_done(effort):
    told = []
    annealing, mending = (replace(scheme, effort=effort) for scheme in (METHOD.annealing, METHOD.mending))
    packed(SQUARE, front(), told.append, replace(METHOD, annealing=annealing, mending=mending))
    assert 0.8 < told[-2] <= told[-1] == 1


def one_too_many():
    """A perfect net of ellipses, and the same one with a bubble between others."""
    spacing = uniform_metric(0.1, 0.2, 0.0)
    bubbles = packed(SQUARE, spacing)[-1].bubbles
    return spacing, *(
        connected(some, SQUARE, spacing) for some in (bubbles, bubbles.append(np.array([[0.51, 0.51]]), np.ones(1)))
    )


def test_mending_takes_away_a_bubble_between_others():
    spacing, perfect, crowded = one_too_many()
    fewer = METHOD.mending.fewer(crowded, spacing, METHOD.smoothing)
    assert len(fewer.tensors) == len(perfect.tensors)


def test_population_control_deletes_no_more_bubbles_than_are_too_many():
    spacing, *nets = one_too_many()
    changes = [METHOD.population(net, spacing) for net in nets]
    gone = [
        len(net.tensors) + change.inserted - len(change.net.tensors) for net, change in zip(nets, changes, strict=True)
    ]
    assert gone == [0, 1]
