import numpy as np
import pytest
from lattices import hexagon, hexagon_domain
from metrics import uniform_metric

from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.kernels.shapes import WORST
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.meshes.tensors import edge_lengths, roots
from bubblemesh.packing.ellipses.net import connected
from bubblemesh.packing.ellipses.population import controlled
from bubblemesh.packing.ellipses.rounds import rounds_in_metric
from bubblemesh.packing.ellipses.smoothing import length_gradient, shape_gradient, shape_measures
from bubblemesh.packing.methods import METHODS
from bubblemesh.packing.placement.diffusion import boundary_bubbles
from bubblemesh.packing.progress import TimeUp
from bubblemesh.spacing.metric.measures import measures_in

METHOD = METHODS["ellipses"]
SQUARE = Domain.of(rings.polygon([[0, 0], [1, 0], [1, 1], [0, 1]]))


def stretched_hexagon(side, factor):
    """A hexagon that is longer along x by a factor: a lattice of ellipses fills it."""
    corners = hexagon_domain(side).boundary.corners * [factor, 1]
    return Domain.of(rings.polygon(corners))


def packed(domain, spacing, watch=lambda share: None):
    levels = METHOD.levels(domain, spacing, 0)
    return list(rounds_in_metric(METHOD.placement(domain, levels[0], 10**6), domain, levels, METHOD, watch))


@pytest.mark.parametrize("factor", [1.0, 2.5, 20.0])
def test_a_uniform_stretch_gives_the_perfect_lattice(factor):
    domain, spacing = stretched_hexagon(6, factor), uniform_metric(1.0, factor, 0.0)
    *_, last = packed(domain, spacing)
    x, triangles = last.net.bubbles.x, last.net.triangles
    assert len(x) == len(hexagon(6))
    assert measures_in(spacing, x, triangles).radius_ratios.min() > 0.999
    nearest = np.abs(x[:, None] / [factor, 1] - hexagon(6)).max(axis=2).min(axis=1)
    assert nearest.max() < 0.02


def test_levels_go_through_metrics_of_doubled_aspect_to_the_one_asked_for():
    spacing = uniform_metric(0.01, 0.5, 0.0)
    levels = METHOD.levels(SQUARE, spacing, 0)
    assert levels[-1] is spacing
    assert [level.aspect for level in levels] == [50 / 32, 50 / 16, 50 / 8, 50 / 4, 50 / 2, 50]
    assert METHOD.levels(SQUARE, uniform_metric(0.1, 0.1, 0.0), 0)[:-1] == ()


def test_rounds_follow_each_other_and_tell_the_reason_last():
    found = packed(SQUARE, uniform_metric(0.05, 0.2, 0.5))
    assert [done.number for done in found] == list(range(1, len(found) + 1))
    assert [done.stop_reason is None for done in found] == [True] * (len(found) - 1) + [False]
    for done in found:
        assert (signed_areas(done.bubbles.x, done.net.triangles) > 0).all()
        assert signed_areas(done.bubbles.x, done.net.triangles).sum() == pytest.approx(1)
    assert all(done.deleted >= 0 for done in found)


@pytest.mark.parametrize("share", [0.0, 0.2, 0.7])
def test_when_the_time_is_up_the_mesh_is_brought_to_the_last_metric(share):
    told = []

    def watch(done):
        told.append(done)
        if done >= share:
            raise TimeUp("no time")

    spacing = uniform_metric(0.02, 0.2, 0.5)
    *_, last = packed(SQUARE, spacing, watch)
    assert told == sorted(told)
    assert last.stop_reason == "no time"
    x, triangles = last.net.bubbles.x, last.net.triangles
    assert (signed_areas(x, triangles) > 0).all()
    whole = packed(SQUARE, spacing)[-1]
    assert 0.6 < len(x) / len(whole.bubbles) < 1.3


def test_two_runs_are_the_same():
    first, second = (packed(SQUARE, uniform_metric(0.05, 0.2, 0.5))[-1] for _ in range(2))
    np.testing.assert_array_equal(first.bubbles.x, second.bubbles.x)
    np.testing.assert_array_equal(first.net.triangles, second.net.triangles)


def test_a_bubble_comes_to_a_long_edge_and_goes_from_a_short_one():
    spacing = uniform_metric(0.1, 0.2, 0.0)
    shell = boundary_bubbles(SQUARE, spacing)
    x = np.array([[0.5, 0.5], [0.53, 0.5]])
    net = connected(shell.append(x, np.ones(2)), SQUARE, spacing)
    change = controlled(net, spacing, METHOD.population)
    assert change.deleted == 1
    assert change.inserted >= 1
    assert (signed_areas(change.net.net.bubbles.x, change.net.net.triangles) > 0).all()


def test_gradients_are_those_of_the_sums():
    random = np.random.default_rng(0)
    spacing = uniform_metric(0.2, 0.6, 0.4)
    net = packed(SQUARE, spacing)[0].net
    x, triangles, edges = net.bubbles.x, net.triangles, net.edges
    root, tensors = roots(spacing.at(x[triangles].mean(axis=1))), spacing.at(x)
    direction, step = random.normal(size=x.shape), 1e-6

    def shapes(places):
        return (shape_measures(places, triangles, spacing) ** 4).sum()

    def lengths(places):
        return ((edge_lengths(places, tensors, edges) - 1) ** 2).sum()

    assert shape_measures(x, triangles, spacing).max() < WORST  # beyond, the power grows no more
    slope = (shapes(x + step * direction) - shapes(x - step * direction)) / (2 * step)
    assert (shape_gradient(x, triangles, root) * direction).sum() == pytest.approx(slope, rel=1e-4)
    slope = (lengths(x + step * direction) - lengths(x - step * direction)) / (2 * step)
    assert (length_gradient(x, tensors, edges) * direction).sum() == pytest.approx(slope, rel=1e-4)
