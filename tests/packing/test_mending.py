from dataclasses import replace

import numpy as np
import pytest
from lattices import DAMPED, packed_hexagon
from twins import needs_compiler

from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.kernels.shapes import eta
from bubblemesh.meshes.triangulation import linked
from bubblemesh.packing import mending
from bubblemesh.packing import net as nets
from bubblemesh.packing.mending import AROUND_BAD, AT_MOST, MOVING, Mending, badness, disjoint_patches
from bubblemesh.packing.net import connect, connect_inside
from bubblemesh.packing.placement.diffusion import ErrorDiffusion
from bubblemesh.packing.relaxation import Connected
from bubblemesh.packing.smoothing import Smoothing
from bubblemesh.spacing.spacing import Spacing

DOMAINS = {
    "square": (Domain.of(rings.rectangle(0, 0, 4, 4)), lambda x, y: 0.2 + 0 * x),
    "graded": (
        Domain.of(rings.rectangle(-1, -1, 1, 1), [rings.circle((0, 0), 0.3)]),
        lambda x, y: 0.15 * np.hypot(x, y),
    ),
    "sector": (
        Domain.of(rings.path((0, 0), [rings.LineTo((3, 0)), rings.ArcTo((0, 3), (0, 0), True)])),
        lambda x, y: 0.15 + 0.05 * np.hypot(x, y),
    ),
    "strip": (Domain.of(rings.rectangle(0, 0, 6, 0.5)), lambda x, y: 0.3 + 0 * x),
    "ring": (Domain.of(rings.circle((0, 0), 2), [rings.circle((0, 0), 1.5)]), lambda x, y: 0.33 + 0 * x),
}


def smoothed_net(name, seed=0, steps=60):
    domain, function = DOMAINS[name]
    spacing = Spacing(function)
    start = ErrorDiffusion()(domain, spacing, 10_000)
    x = start.x.copy()
    x[start.interior] += 0.01 * np.random.default_rng(seed).standard_normal(x[start.interior].shape)
    net = connect(replace(start, x=x), domain)
    bubbles = Connected()(net, domain, spacing, DAMPED, steps).bubbles
    return domain, spacing, Smoothing()(connect_inside(bubbles, domain, spacing), domain, spacing)


def mended(domain, spacing, net, seed=0, scheme=None):
    return (scheme or Mending())(net, domain, spacing, Smoothing(), np.random.default_rng(seed))


def worst(net):
    return eta(net.bubbles.x, net.triangles).max()


@needs_compiler
@pytest.mark.parametrize("name", ["graded", "square"])
def test_mended_part_is_put_back_without_a_triangulation_of_all_bubbles(name, monkeypatch):
    domain, spacing, net = smoothed_net(name, 4, 5)
    anew = connect_inside(mended(domain, spacing, net).bubbles, domain, spacing)
    sizes = []

    def noted(points, *others):
        sizes.append(len(points))
        return linked(points, *others)

    monkeypatch.setattr(nets, "linked", noted)
    found = mended(domain, spacing, net)
    assert worst(found) < worst(net)
    assert len(net.bubbles) not in sizes
    for one in ("facets", "facet_piece", "triangles", "edges"):
        np.testing.assert_array_equal(getattr(found, one), getattr(anew, one))


@pytest.mark.long
@pytest.mark.parametrize("name", DOMAINS)
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("steps", [5, 60])
def test_worst_triangle_never_gets_worse_and_no_bubble_is_lost(name, seed, steps):
    domain, spacing, net = smoothed_net(name, seed, steps)
    found = mended(domain, spacing, net, seed)
    assert worst(found) <= worst(net)
    assert len(found.bubbles) == len(net.bubbles)
    assert (found.valence > 0).all()


@pytest.mark.parametrize("name", ["square", "sector"])
def test_worst_triangles_get_better(name):
    gains = []
    for seed in range(3):
        domain, spacing, net = smoothed_net(name, seed)
        found = mended(domain, spacing, net, seed)
        gains.append((worst(net) - worst(found)) / (worst(net) - 1))
    assert np.mean(gains) > 0.1


@pytest.mark.parametrize("name", DOMAINS)
def test_bubbles_off_the_patches_stay_bit_for_bit(name):
    domain, spacing, net = smoothed_net(name)
    measure = eta(net.bubbles.x, net.triangles)
    limit = np.sort(measure)[-3]  # two triangles to mend
    found = mended(domain, spacing, net, scheme=Mending(mend_worse=max(limit, 1)))
    bad = net.triangles[measure > limit]
    near = net.within(bad, AROUND_BAD)
    np.testing.assert_array_equal(found.bubbles.x[~near], net.bubbles.x[~near])
    moved = (found.bubbles.x != net.bubbles.x).any(axis=1)
    assert moved.any()
    first = net.within(bad, 2 * MOVING)  # new bad triangles come next to the old ones
    assert not moved[~first].any()


@pytest.mark.parametrize("name", DOMAINS)
def test_corners_stay_and_sliding_bubbles_stay_on_their_curve(name):
    domain, spacing, net = smoothed_net(name)
    before, after = net.bubbles, mended(domain, spacing, net).bubbles
    assert (after.corners, after.boundary_count) == (before.corners, before.boundary_count)
    np.testing.assert_array_equal(after.x[: after.corners], domain.boundary.corners)
    np.testing.assert_array_equal(after.piece, before.piece)
    on_curve = domain.boundary.points(after.piece, after.s)
    np.testing.assert_allclose(after.x[after.sliding], on_curve, rtol=0, atol=1e-14)
    np.testing.assert_array_equal(after.d, spacing(after.x))


def test_net_without_bad_triangles_is_left_alone():
    domain, spacing, bubbles = packed_hexagon(4)
    net = connect(bubbles, domain)
    assert mended(domain, spacing, net) is net
    domain, spacing, net = smoothed_net("square")
    assert mended(domain, spacing, net, scheme=Mending(mend_worse=100.0)) is net
    assert mended(domain, spacing, net, scheme=Mending(mend_attempts=0)) is net


def starts_of_attempts(domain, spacing, net):
    """The bubbles as three attempts displaced them."""
    seen = []

    class Recording(Smoothing):
        def moved(self, net, domain, free):
            seen.append(net.bubbles)
            return net.bubbles

    Mending(mend_attempts=3)(net, domain, spacing, Recording(), np.random.default_rng(0))
    assert len(seen) > 2
    return seen


@pytest.mark.parametrize("name", ["strip", "ring"])
def test_bubbles_on_the_boundary_are_displaced_along_it(name):
    domain, spacing, net = smoothed_net(name)
    moved = set()
    for bubbles in starts_of_attempts(domain, spacing, net):
        on_curve = domain.boundary.points(bubbles.piece, bubbles.s)
        np.testing.assert_allclose(bubbles.x[bubbles.sliding], on_curve, atol=1e-14)
        np.testing.assert_array_equal(bubbles.x[: bubbles.corners], net.bubbles.x[: bubbles.corners])
        moved |= set(bubbles.s.tolist()) - set(net.bubbles.s.tolist())
    assert moved


@pytest.mark.parametrize("held", [[True] * 4, [True, False, False, False]], ids=["all", "floor"])
def test_bubbles_on_the_boundary_stay_beside_those_that_are_held(held):
    """What is poor beside cuts is mended when these are free: bubbles of a wall must not give way to it."""
    domain, spacing, net = smoothed_net("strip")
    domain.__dict__["tied"] = np.array(held)
    try:
        for bubbles in starts_of_attempts(domain, spacing, net):
            np.testing.assert_array_equal(bubbles.x[bubbles.sliding], net.bubbles.x[bubbles.sliding])
    finally:
        del domain.__dict__["tied"]  # the domain is shared


def test_all_places_are_mended_however_many_poor_triangles_one_has():
    """Each place has several poor triangles: the worst of one must not keep the others from being seen."""
    domain, spacing, net = smoothed_net("square")
    rng = np.random.default_rng(3)
    places = [(x, y) for x in (0.8, 1.6, 2.4, 3.2) for y in (0.8, 1.6, 2.4, 3.2)]
    x = net.bubbles.x.copy()
    for place in places:
        near = np.argsort(np.hypot(*(x - place).T))[:4]
        x[near] += 0.25 * 0.2 * rng.standard_normal((4, 2))
    spoiled = connect_inside(net.bubbles.moved(x), domain, spacing)
    measure = eta(spoiled.bubbles.x, spoiled.triangles)
    assert (measure > 1.08).sum() > 2 * AT_MOST
    found = mended(domain, spacing, spoiled)
    assert (eta(found.bubbles.x, found.triangles) > 1.08).sum() < 24


def test_attempts_that_make_it_worse_are_not_kept(monkeypatch):
    class Spoiling(Smoothing):
        def moved(self, net, domain, free):
            x = net.bubbles.x.copy()
            inside = free & (np.arange(len(free)) >= net.bubbles.boundary_count)
            x[inside] += 0.4 * net.bubbles.d[inside, None] * np.sin(1000 * x[inside])
            return replace(net.bubbles, x=x)

    looked = []

    def noted(net, bad):
        looked.append(len(bad))
        return disjoint_patches(net, bad)

    monkeypatch.setattr(mending, "disjoint_patches", noted)
    domain, spacing, net = smoothed_net("square")
    found = Mending()(net, domain, spacing, Spoiling(), np.random.default_rng(0))
    assert found is net
    assert len(looked) == 1  # where nothing has changed there is nothing new to see


def test_a_seed_gives_one_result_and_another_seed_another():
    domain, spacing, net = smoothed_net("square")
    one, same, other = (mended(domain, spacing, net, seed).bubbles.x.tobytes() for seed in (1, 1, 2))
    assert one == same != other


@pytest.mark.parametrize("name", DOMAINS)
def test_patches_are_apart_and_hold_what_must_not_move(name):
    _, _, net = smoothed_net(name)
    measure = eta(net.bubbles.x, net.triangles)
    bad = np.argsort(-measure)[:AT_MOST]
    _, part = net.part(net.within(net.triangles[bad[:5]], AROUND_BAD))
    for one in (net, part):
        order = np.argsort(-eta(one.bubbles.x, one.triangles))[:AT_MOST]
        patches = disjoint_patches(one, order)
        assert patches.number >= 1
        assert (patches.moving[: one.bubbles.corners] == -1).all()
        cut = one.facets[one.facet_piece < 0]
        assert (patches.moving[cut] == -1).all()
        assert (patches.moving[patches.displaced] >= 0).all()
        of = patches.moving[one.triangles]
        for row in of.tolist():
            assert len({number for number in row if number >= 0}) <= 1
        seen = set(patches.moving.tolist()) - {-1}
        assert seen == set(range(patches.number))
        first = one.within(one.triangles[order[0]], MOVING)
        assert set(np.flatnonzero(patches.moving == 0).tolist()) <= set(np.flatnonzero(first).tolist())


def test_rim_of_a_part_does_not_move_though_a_patch_reaches_it():
    _, _, net = smoothed_net("square")
    (middle,) = np.flatnonzero(np.hypot(*(net.bubbles.x - [2, 2]).T) == np.hypot(*(net.bubbles.x - [2, 2]).T).min())
    _, part = net.part(net.within(np.array([middle]), 2))
    patches = disjoint_patches(part, np.arange(len(part.triangles)))
    rim = np.unique(part.facets)
    assert (part.facet_piece == -1).all()
    assert (patches.moving[rim] == -1).all()
    assert not patches.displaced[rim].any()
    assert (patches.moving == 0).sum() == 7  # the middle and its neighbours, if they are six


def test_badness_of_a_patch_is_that_of_the_triangles_at_its_moving_bubbles():
    _, _, net = smoothed_net("square")
    order = np.argsort(-eta(net.bubbles.x, net.triangles))[:AT_MOST]
    patches = disjoint_patches(net, order)
    found = badness(net, patches)
    measure = eta(net.bubbles.x, net.triangles)
    for number in range(patches.number):
        mine = [m for m, t in zip(measure, net.triangles, strict=True) if (patches.moving[t] == number).any()]
        assert found[number] == pytest.approx(sum(m**64 for m in mine))


def test_a_triangle_that_is_inverted_is_infinitely_bad():
    _, _, net = smoothed_net("square")
    patches = disjoint_patches(net, np.array([40]))
    moving = np.flatnonzero(patches.moving == 0)[0]
    x = net.bubbles.x.copy()
    x[moving] += 10
    assert badness(replace(net, bubbles=net.bubbles.moved(x)), patches) == [np.inf]


def test_bad_triangles_are_the_worst_ones_first():
    _, _, net = smoothed_net("square", steps=5)
    measure = eta(net.bubbles.x, net.triangles)
    tried = []

    class Recording(Smoothing):
        def moved(self, net, domain, free):
            tried.append(net.bubbles.x[free])
            return net.bubbles

    domain, spacing = DOMAINS["square"][0], Spacing(DOMAINS["square"][1])
    Mending(mend_attempts=1)(net, domain, spacing, Recording(), np.random.default_rng(0))
    worst_place = net.bubbles.x[net.triangles[measure.argmax()]].mean(axis=0)
    assert np.hypot(*(tried[0] - worst_place).T).min() < 0.3
