from dataclasses import replace

import numpy as np
import pytest
from metrics import tensor_metric, uniform_metric

from bubblemesh.geometry import rings
from bubblemesh.geometry.arrangement.regions import InnerParts
from bubblemesh.geometry.domain import Domain
from bubblemesh.kernels.ellipse_shapes import shape_measures
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.meshes.tensors import of_axes
from bubblemesh.packing.ellipses import trials
from bubblemesh.packing.ellipses.net import connected
from bubblemesh.packing.ellipses.patches import patches_around
from bubblemesh.packing.ellipses.smoothing import better_shapes, costs, roots_inside
from bubblemesh.packing.methods import METHODS
from bubblemesh.packing.rounds import rounds

METHOD = METHODS["ellipses"]
CORNERS = rings.polygon([[0, 0], [1, 0], [1, 1], [0, 1]])
LINE = rings.open_path((0.2, 0.5), [rings.LineTo((0.8, 0.55))], "line")
SQUARE = Domain.of(CORNERS)
SLIT = Domain.of(CORNERS, parts=InnerParts(lines=(LINE,)))


def waves():
    """A metric that turns and widens."""

    def tensors(x, y):
        angle = np.sin(5 * x) + np.cos(4 * y)
        across = 0.03 + 0.02 * np.sin(7 * x - 2 * y)
        return of_axes(across, np.full(len(x), 0.1), np.column_stack([np.cos(angle), np.sin(angle)]))

    return tensor_metric(tensors)


def settled(domain, spacing):
    """Ellipses that have settled, but are not finished."""
    first = next(rounds(METHOD.placement(domain, spacing, 10**6), domain, [spacing], METHOD))
    return connected(first.net.bubbles, domain, spacing)


def attempts(ellipses, spacing, seed=0, **keys):
    mending = replace(METHOD.mending, **keys)
    return list(mending.tried(ellipses, spacing, METHOD.smoothing, np.random.default_rng(seed)))


def attempted(ellipses, spacing, seed=0, **keys):
    return attempts(ellipses, spacing, seed, **keys)[-1].within(ellipses.net, spacing)


@pytest.fixture(scope="module", params=[SQUARE, SLIT], ids=["square", "slit"])
def ellipses(request):
    return settled(request.param, waves())


def total(some, price=0.0):
    return (costs(some.net.bubbles.x, some.net.triangles, waves(), METHOD.smoothing) + price).sum()


def test_trials_lessen_what_triangles_cost(ellipses):
    net, found = ellipses.net, attempted(ellipses, waves())
    assert total(found, price=1.0) < 0.9 * total(ellipses, price=1.0)
    x, triangles, fixed = found.net.bubbles.x, found.net.triangles, net.bubbles.boundary_count
    assert (signed_areas(x, triangles) > 0).all()
    assert signed_areas(x, triangles).sum() == pytest.approx(1)
    assert len(found.net.edges) == len(x) + len(triangles) - 1
    np.testing.assert_array_equal(np.unique(triangles), np.arange(len(x)))
    np.testing.assert_array_equal(x[:fixed], net.bubbles.x[:fixed])
    np.testing.assert_allclose(found.tensors, waves().at(x))
    assert found.net.are_facets(found.net.edges).sum() == len(net.facets)


def test_trials_are_the_same_for_the_same_seed(ellipses):
    found = [attempted(ellipses, waves(), seed, mend_attempts=8).net.bubbles.x.tobytes() for seed in (1, 1, 2)]
    assert found[0] == found[1] != found[2]


def test_trials_tell_of_each_attempt(ellipses):
    found = attempts(ellipses, waves(), mend_attempts=4)
    assert len(found) == 4
    least = [(each.costs + 1.0).sum() for each in found]
    assert least == sorted(least, reverse=True)


def test_trials_count_the_bubbles_that_come(ellipses):
    came, before = 0, np.arange(len(ellipses.tensors))
    for each in attempts(ellipses, waves()):
        assert each.came >= came
        assert len(each.x) - len(before) <= each.came
        came = each.came
    assert came > 0


def test_attempts_end_after_some_in_vain_in_a_row(ellipses, monkeypatch):
    monkeypatch.setattr(trials, "SURELY_LESS", np.inf)
    assert [each.in_vain for each in attempts(ellipses, waves(), mend_attempts=10)] == [1, 2]


def test_where_no_triangle_is_bad_nothing_is_tried(ellipses):
    assert not attempts(ellipses, waves(), mend_worse=1e3)


def lattice():
    spacing = uniform_metric(0.1, 0.2, 0.0)
    *_, last = rounds(METHOD.placement(SQUARE, spacing, 10**6), SQUARE, [spacing], METHOD)
    return spacing, last.bubbles


def middle_of(bubbles):
    return np.hypot(*(bubbles.x - 0.5).T).argmin()


def test_a_bubble_comes_where_one_lacks():
    spacing, bubbles = lattice()
    without = bubbles.select(np.delete(np.arange(len(bubbles)), middle_of(bubbles)))
    found = attempted(connected(without, SQUARE, spacing), spacing)
    assert len(found.tensors) == len(bubbles)


def test_a_bubble_leaves_where_one_is_too_many():
    spacing, bubbles = lattice()
    more = bubbles.append(bubbles.x[[middle_of(bubbles)]] + [[0.03, 0.02]], np.ones(1))
    found = attempted(connected(more, SQUARE, spacing), spacing)
    assert len(found.tensors) == len(bubbles)


@pytest.mark.parametrize(("rings", "share"), [(1, 0.7), (2, 1.0)])
def test_patches_are_apart(ellipses, rings, share):
    net, candidates = ellipses.net, np.arange(0, len(ellipses.net.triangles), 3)
    x, triangles, edges = net.bubbles.x, net.triangles, net.edges
    chosen, within, patches = patches_around(candidates, rings, net, x, ellipses.tensors, triangles, edges)
    assert len(chosen) > 3
    assert chosen[0] == candidates[0]
    patch = np.full(len(x), -1)
    patch[patches.nodes] = patches.patch
    first, last = patch[edges].T
    assert ((first == last) | (first < 0) | (last < 0)).all()
    np.testing.assert_array_equal(patches.nodes[patches.triangles], triangles[within])
    np.testing.assert_array_equal(patch[triangles[chosen]], np.arange(len(chosen))[:, None] + np.zeros(3, int))
    # All triangles of what may move are there.
    free = patches.nodes[patches.free]
    assert (free >= net.bubbles.boundary_count).all()
    assert within[np.isin(triangles, free).any(axis=1)].all()
    moving = np.sort(patches.nodes[patches.free])
    around = net.dilated(np.isin(np.arange(len(x)), triangles[chosen]), rings - 1)
    np.testing.assert_array_equal(moving, np.flatnonzero(around & (np.arange(len(x)) >= net.bubbles.boundary_count)))
    # There is little room for more, and none for larger ones.
    taken = net.within(patches.nodes, 1)
    assert net.dilated(taken, rings)[triangles[candidates]].any(axis=1).mean() >= share


def test_some_of_the_patches_are_as_they_were(ellipses):
    net = ellipses.net
    given = net, net.bubbles.x, ellipses.tensors, net.triangles, net.edges
    _, _, patches = patches_around(np.arange(len(net.triangles)), 2, *given)
    chosen = np.arange(patches.patch.max() + 1) % 2 == 0
    some = patches.select(chosen)
    kept = chosen[patches.owner]
    np.testing.assert_array_equal(some.nodes[some.triangles], patches.nodes[patches.triangles[kept]])
    np.testing.assert_array_equal(some.owner, patches.owner[kept])
    np.testing.assert_array_equal(some.tensors, ellipses.tensors[some.nodes])
    assert some.free.sum() == patches.free[chosen[patches.patch]].sum()


def test_flips_leave_no_edge_whose_flip_would_better_the_worse_of_two_triangles(ellipses):
    net, spacing, x = ellipses.net, waves(), ellipses.net.bubbles.x
    before = roots_inside(x, net.triangles, spacing)
    triangles, inside = better_shapes(x, net.triangles, net.facets, spacing, before)
    again, _ = better_shapes(x, triangles, net.facets, spacing, inside)
    np.testing.assert_array_equal(again, triangles)
    np.testing.assert_array_equal(inside, roots_inside(x, triangles, spacing))
    assert shape_measures(x, triangles, inside).sum() < shape_measures(x, net.triangles, before).sum()
