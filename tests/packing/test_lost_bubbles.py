"""Bubbles that leave the domain: nets without them are those of a triangulation made anew."""

from dataclasses import replace

import numpy as np
import pytest
from lattices import uniform
from sweeps import sweep
from twins import needs_compiler

from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing import net as nets
from bubblemesh.packing.net import connect, connect_within
from bubblemesh.packing.placement.diffusion import ErrorDiffusion

pytestmark = needs_compiler

PLATE = Domain.of(rings.rectangle(0, 0, 12, 9), [rings.circle((5, 5), 2)])
NOTCHED = Domain.of(rings.polygon([(0, 0), (9, 0), (9, 4), (4, 4), (4, 9), (0, 9)]))


def net_of(domain):
    """A net in which rounding decides nothing."""
    bubbles = ErrorDiffusion()(domain, uniform(0.6), 10_000)
    x, random = bubbles.x.copy(), np.random.default_rng(9)
    x[bubbles.interior] += random.uniform(-0.02, 0.02, x[bubbles.interior].shape)
    return connect(replace(bubbles, x=x), domain)


def inner(net):
    """Bubbles with no neighbour on the boundary."""
    on_boundary = np.arange(len(net.bubbles)) < net.bubbles.boundary_count
    return np.flatnonzero(~net.dilated(on_boundary, 1))


def beside(net, place):
    """The bubble nearest to a place, of those beside the boundary."""
    mine = np.setdiff1d(np.arange(net.bubbles.boundary_count, len(net.bubbles)), inner(net))
    return mine[np.hypot(*(net.bubbles.x[mine] - place).T).argmin()]


def moved(net, most, seed=0, **to):
    """The bubbles, displaced at random inside, and some of them moved to places."""
    x, free, random = net.bubbles.x.copy(), inner(net), np.random.default_rng(seed)
    x[free] += random.uniform(-most, most, (len(free), 2))
    for number, place in to.items():
        x[int(number)] = place
    return replace(net.bubbles, x=x)


def assert_same(one, other):
    assert one.bubbles.x.tobytes() == other.bubbles.x.tobytes()
    for part in ("triangles", "edges", "facets"):
        np.testing.assert_array_equal(getattr(one, part), getattr(other, part))
    assert one.start.tobytes() == one.bubbles.x.tobytes()


WAYS_OUT = {
    "over a side": (PLATE, [6.0, 8.5], [6.0, 9.2]),
    "over a side by far": (PLATE, [6.0, 8.5], [6.1, 40.0]),
    "into a hole": (PLATE, [5.0, 7.4], [5.0, 6.0]),
    "over a side of a notch": (NOTCHED, [3.6, 7.0], [4.3, 7.0]),
}


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("way", WAYS_OUT)
def test_one_that_leaves_costs_no_triangulation(monkeypatch, way, seed):
    domain, here, there = WAYS_OUT[way]
    net = net_of(domain)
    bubbles = moved(net, 0.15, seed, **{str(beside(net, here)): there})
    expected = connect_within(bubbles, domain)
    assert len(expected.bubbles) == len(bubbles) - 1
    monkeypatch.setattr(nets, "_triangulated", None)
    assert_same(connect_within(bubbles, domain, net), expected)


def test_several_that_are_apart_leave_together(monkeypatch):
    net = net_of(PLATE)
    out = {str(beside(net, [k, 8.5])): [k, 9.3] for k in (2, 5, 8, 11)} | {str(beside(net, [5, 2.6])): [5.0, 4.0]}
    assert len(out) == 5
    bubbles = moved(net, 0.1, **out)
    expected = connect_within(bubbles, PLATE)
    assert len(expected.bubbles) == len(bubbles) - 5
    monkeypatch.setattr(nets, "_triangulated", None)
    assert_same(connect_within(bubbles, PLATE, net), expected)


@pytest.mark.parametrize(
    ("domain", "here", "there"),
    [
        (PLATE, [6.0, 8.5], [6.03, 9.0]),
        (PLATE, [0.4, 0.4], [-0.2, 0.3]),
        (PLATE, [0.4, 0.4], [-1e-15, 0.3]),
        (PLATE, [0.4, 4.0], [0.0, 4.02]),
        (PLATE, [5.0, 7.4], [5.0, 2.9]),
        (NOTCHED, [3.6, 3.6], [4.2, 4.3]),
        (NOTCHED, [8.6, 3.5], [9.2, 4.3]),
    ],
    ids=["onto a side", "at a corner", "hardly", "onto the left", "over a hole", "around a notch", "over a corner"],
)
def test_whatever_else_happens_gives_the_same_net(domain, here, there):
    net = net_of(domain)
    bubbles = moved(net, 0.15, **{str(beside(net, here)): there})
    assert_same(connect_within(bubbles, domain, net), connect_within(bubbles, domain))


def test_neighbours_that_leave_together_are_found_by_a_triangulation():
    net = net_of(PLATE)
    one = beside(net, [6.0, 8.5])
    near = set(net.edges[(net.edges == one).any(axis=1)].ravel().tolist()) - {one, *inner(net).tolist()}
    other = max(near)  # which is not on the boundary: those come first
    bubbles = moved(net, 0.1, **{str(one): [6.0, 9.3], str(other): [7.0, 9.4]})
    assert_same(connect_within(bubbles, PLATE, net), connect_within(bubbles, PLATE))


@pytest.mark.parametrize("seed", sweep(range(40), quick=13))
def test_any_moves_give_the_net_of_a_triangulation(seed):
    domain = (PLATE, NOTCHED)[seed % 2]
    net, random = net_of(domain), np.random.default_rng(seed)
    x = net.bubbles.x.copy()
    inside = net.bubbles.interior
    x[inside] += random.uniform(-1, 1, x[inside].shape) * random.choice([0.1, 0.3, 0.6])
    bubbles = replace(net.bubbles, x=x)
    assert_same(connect_within(bubbles, domain, net), connect_within(bubbles, domain))
