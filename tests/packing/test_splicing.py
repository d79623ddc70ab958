import json
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from lattices import hexagon, packed_hexagon, uniform
from sweeps import sweep
from twins import needs_compiler

from bubblemesh.case import load_case
from bubblemesh.geometry import rings
from bubblemesh.geometry.arrangement.regions import InnerParts
from bubblemesh.geometry.domain import Domain
from bubblemesh.kernels.library import COMPILED, engine
from bubblemesh.kernels.linking import legalised
from bubblemesh.meshes.edges import directed_sides
from bubblemesh.packing import net as nets
from bubblemesh.packing.neighbours import maximal_independent_set
from bubblemesh.packing.net import connect, reconnect
from bubblemesh.packing.placement.diffusion import ErrorDiffusion
from bubblemesh.packing.population import Defects
from bubblemesh.packing.splicing import spliced
from bubblemesh.run.pipeline import mesh_case

NO_EDGES = np.zeros((0, 2), np.int64)
SQUARE = rings.rectangle(0, 0, 3, 3)
WALL = rings.open_path((0.7, 0.4), [rings.LineTo((0.9, 2.5)), rings.LineTo((2.4, 2.2))], "wall")
DOMAINS = {
    "square": Domain.of(SQUARE),
    "turned": Domain.of(rings.polygon(np.array([[0, 0], [3, 1], [2, 4], [-1, 3]]) * np.sqrt(0.9))),
    "narrow": Domain.of(rings.rectangle(0, 0, 4, 0.5)),
    "holes": Domain.of(rings.circle((0, 0), 1.6), [rings.circle((0.3, 0), 0.6), rings.rectangle(-1, -0.5, -0.6, 0.5)]),
    "lines": Domain.of(SQUARE, parts=InnerParts(lines=(WALL,))),
}


def scattered_net(name, seed, spread=0.05):
    """A net of bubbles far from a perfect packing."""
    domain = DOMAINS[name]
    bubbles = ErrorDiffusion()(domain, uniform(0.2), 10_000)
    x = bubbles.x.copy()
    x[bubbles.interior] += spread * np.random.default_rng(seed).standard_normal(x[bubbles.interior].shape)
    x[~domain.contains(x)] = bubbles.x[~domain.contains(x)]
    return domain, connect(replace(bubbles, x=x), domain)


def random_change(net, random, share):
    """Interior bubbles (n,) and inner edges (k, 2) to take away and to halve, as they are allowed to be."""
    inside = np.arange(len(net.bubbles)) >= net.bubbles.boundary_count
    rank = random.permutation(len(net.bubbles))
    gone = maximal_independent_set(inside & (random.random(len(rank)) < share), net.edges, rank)
    taken, halved = gone.copy(), []
    for edge in random.permutation(net.edges[net.inner & (random.random(len(net.edges)) < share)]):
        if not taken[edge].any():
            taken[edge] = True
            halved.append(edge)
    return gone, np.array(halved, np.int64).reshape(-1, 2)


def twice_the_areas(x, triangles):
    u, v = (x[triangles[:, k]] - x[triangles[:, 0]] for k in (1, 2))
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]


def free_sides(triangles):
    sides = Counter(map(tuple, directed_sides(triangles).tolist()))
    assert set(sides.values()) == {1}
    return {(i, j) for i, j in sides if (j, i) not in sides}


@pytest.mark.parametrize("name", DOMAINS)
@pytest.mark.parametrize("share", [0.02, 0.3, 1.0])
@pytest.mark.parametrize("seed", sweep(range(3), quick=1))
def test_spliced_triangles_fill_the_region_and_flips_lead_from_them_to_the_triangulation_made_anew(name, share, seed):
    domain, net = scattered_net(name, seed)
    gone, halved = random_change(net, np.random.default_rng(seed), share)
    assert share < 0.1 or (gone.any() and len(halved))
    old = net.triangles.copy()
    triangles = spliced(net.bubbles.x, net.triangles, gone, halved)
    np.testing.assert_array_equal(net.triangles, old)
    assert triangles is not None
    middles = net.bubbles.x[halved].mean(axis=1)
    rest = net.bubbles.select(np.flatnonzero(~gone))
    bubbles = rest.append(middles, np.full(len(middles), 0.2))
    areas = twice_the_areas(bubbles.x, triangles)
    assert (areas > 0).all()
    assert areas.sum() == pytest.approx(twice_the_areas(net.bubbles.x, net.triangles).sum())
    assert free_sides(triangles) == free_sides(net.triangles)
    assert len(triangles) == len(net.triangles) - 2 * gone.sum() + 2 * len(halved)
    found, anew = connect(bubbles, domain, net, triangles), connect(bubbles, domain)
    for one in ("facets", "facet_piece", "two_sided", "triangles", "edges"):
        np.testing.assert_array_equal(getattr(found, one), getattr(anew, one))
    if engine() == COMPILED:
        assert legalised(triangles, bubbles.x, bubbles.x, net.facets) is not None


def on_the_wall(net, sides):
    """Bubbles (n,) that slide, with so many edges, no two of them connected."""
    sliding = np.zeros(len(net.bubbles), bool)
    sliding[net.bubbles.sliding] = True
    return maximal_independent_set(sliding & (net.valence == sides), net.edges, np.arange(len(sliding)))


@pytest.mark.parametrize("sides", [3, 4])
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", ["square", "turned"])
def test_nodes_leave_a_straight_wall(name, sides, seed):
    domain, net = scattered_net(name, seed)
    alone = np.eye(len(net.bubbles), dtype=bool)[on_the_wall(net, sides)]
    possible = [gone for gone in alone if spliced(net.bubbles.x, net.triangles, gone, NO_EDGES) is not None]
    assert 0 < len(possible) <= len(alone)
    assert sides > 3 or len(possible) == len(alone)  # two triangles always leave one
    gone = np.any(possible, axis=0)
    triangles = spliced(net.bubbles.x, net.triangles, gone, NO_EDGES)
    bubbles = net.bubbles.select(np.flatnonzero(~gone))
    areas = twice_the_areas(bubbles.x, triangles)
    assert (areas > 0).all()
    assert areas.sum() == pytest.approx(18)  # of two squares of side 3
    assert len(triangles) == len(net.triangles) - gone.sum()
    found, anew = connect(bubbles, domain, net, triangles), connect(bubbles, domain)
    for one in ("facets", "facet_piece", "two_sided", "triangles", "edges"):
        np.testing.assert_array_equal(getattr(found, one), getattr(anew, one))
    assert (found.legal is not None) == (engine() == COMPILED)


def test_node_at_which_two_rims_meet_stays():
    x = np.array([[0.0, 0], [-1, 0], [-0.5, 1], [1, 0], [0.5, 1], [0, 1.5]])
    triangles = np.array([[0, 2, 1], [0, 3, 4]])
    assert spliced(x, triangles, np.arange(6) == 0, NO_EDGES) is None


def test_nodes_stay_on_a_round_wall():
    _, net = scattered_net("holes", 0)
    round_one = np.abs(np.hypot(*net.bubbles.x.T) - 1.6) < 1e-9
    gone = on_the_wall(net, 3) & round_one
    assert gone.any()
    assert spliced(net.bubbles.x, net.triangles, gone, NO_EDGES) is None


@needs_compiler
def test_triangles_that_do_not_end_at_the_facets_are_made_anew():
    _, net = scattered_net("square", 0)
    for triangles in (net.triangles[1:], np.delete(net.triangles, net.triangles.max(axis=1).argmax(), axis=0)):
        assert legalised(triangles, net.bubbles.x, net.bubbles.x, net.facets) is None
        np.testing.assert_array_equal(reconnect(net, net.bubbles, triangles).triangles, net.triangles)
    assert legalised(net.triangles, net.bubbles.x, net.bubbles.x, net.facets[1:]) is None
    strange = np.vstack([net.facets, [[0, len(net.bubbles) - 1]]])
    assert legalised(net.triangles, net.bubbles.x, net.bubbles.x, strange) is None


def test_nothing_to_splice_leaves_the_triangles():
    _, net = scattered_net("square", 0)
    nobody = np.zeros(len(net.bubbles), bool)
    np.testing.assert_array_equal(spliced(net.bubbles.x, net.triangles, nobody, NO_EDGES), net.triangles)


def fan(corners, center=(0.0, 0.0)):
    """Nodes, the first in the middle of the others, and the triangles around it."""
    k = np.arange(len(corners))
    return np.vstack([center, corners]), np.column_stack([0 * k, 1 + k, 1 + (k + 1) % len(k)])


@pytest.mark.parametrize("sides", range(3, 12))
def test_hole_of_a_node_is_filled_with_two_triangles_less(sides):
    angle = 2 * np.pi * (np.arange(sides) + 0.2) / sides
    x, triangles = fan(np.column_stack([np.cos(angle), np.sin(angle)]))
    found = spliced(x, triangles, np.arange(len(x)) == 0, NO_EDGES)
    assert len(found) == sides - 2
    assert (twice_the_areas(x[1:], found) > 0).all()
    assert free_sides(found) == {(k, (k + 1) % sides) for k in range(sides)}


def windmill(angle):
    """Three long corners of a hole, and three short ones, each so many degrees after a long one."""
    directions = np.radians([120.0 * k + turn for k in range(3) for turn in (0, angle)])
    return np.tile([1, 0.1], 3)[:, None] * np.column_stack([np.cos(directions), np.sin(directions)])


@pytest.mark.parametrize(("angle", "filled"), [(60, True), (50, True), (10, False), (110, False)])
def test_hole_is_filled_from_a_corner_that_sees_all_of_it_or_not_at_all(angle, filled):
    x, triangles = fan(windmill(angle))
    found = spliced(x, triangles, np.arange(7) == 0, NO_EDGES)
    assert (found is not None) == filled
    if filled:
        assert (twice_the_areas(x[1:], found) > 0).all()


def test_node_and_edge_on_the_rim_are_no_matter_of_splicing():
    x, triangles = fan(hexagon(1)[[0, 1, 4, 6, 5, 2]][::-1])
    nobody = np.zeros(7, bool)
    assert spliced(x, triangles, np.arange(7) == 1, NO_EDGES) is None
    assert spliced(x, triangles, nobody, np.array([[1, 2]])) is None
    assert spliced(x, triangles, nobody, np.array([[1, 4]])) is None  # is no edge at all
    assert len(spliced(x, triangles, nobody, np.array([[0, 2]]))) == 8


def test_edge_of_a_hole_is_halved():
    domain, _, bubbles = packed_hexagon(2)
    triangles, middle = connect(bubbles, domain).triangles, np.flatnonzero((bubbles.x == 0).all(axis=1))[0]
    beside = next(row for row in triangles.tolist() if middle in row)
    edge = np.array([[node for node in beside if node != middle]])
    found = spliced(bubbles.x, triangles, np.arange(len(bubbles)) == middle, edge)
    assert len(found) == len(triangles)
    assert np.sum(found == len(bubbles) - 1) == 4


@needs_compiler
@pytest.mark.parametrize("name", DOMAINS)
def test_population_control_spares_the_triangulation(name, monkeypatch):
    domain, net = scattered_net(name, 1, 0.06)
    change = Defects()(net, domain, uniform(0.2), np.random.default_rng(0))
    assert change.deleted + change.inserted > 0
    if change.bubbles.boundary_count < net.bubbles.boundary_count:
        assert change.triangles is None
        return
    anew = connect(change.bubbles, domain)
    monkeypatch.setattr(nets, "linked", None)
    found = connect(change.bubbles, domain, net, change.triangles)
    np.testing.assert_array_equal(found.triangles, anew.triangles)
    np.testing.assert_array_equal(found.edges, anew.edges)


def test_bubble_that_leaves_a_wall_has_the_net_made_anew():
    domain, net = scattered_net("square", 0)
    wall = net.bubbles.corners + 3
    rest = net.bubbles.select(np.delete(np.arange(len(net.bubbles)), wall))
    found, anew = connect(rest, domain, net, net.triangles[:0]), connect(rest, domain)
    np.testing.assert_array_equal(found.triangles, anew.triangles)
    np.testing.assert_array_equal(found.facets, anew.facets)


def test_triangles_that_do_not_turn_left_have_the_net_made_anew():
    domain, net = scattered_net("square", 0)
    found = connect(net.bubbles, domain, net, net.triangles[:, ::-1])
    np.testing.assert_array_equal(found.triangles, net.triangles)


def test_nets_of_a_whole_packing_are_spliced_and_are_those_made_anew(monkeypatch):
    counts = Counter()

    def compared(net, bubbles, triangles=None):
        before = counts["anew"]
        found = reconnect(net, bubbles, triangles)
        if triangles is not None:
            counts["spliced"] += 1
            counts["not spared"] += counts["anew"] - before
            counts["other number"] += len(bubbles) != len(net.bubbles)
        expected = linked(bubbles.x, net.facets, net.two_sided)
        np.testing.assert_array_equal(found.triangles, expected[0])
        np.testing.assert_array_equal(found.edges, expected[1])
        return found

    def counted(*given):
        counts["anew"] += 1
        return linked(*given)

    linked = nets.linked
    monkeypatch.setattr(nets, "linked", counted)
    monkeypatch.setattr(nets, "reconnect", compared)
    case = {"domain": {"outer": {"circle": {"center": [0, 0], "radius": 1}}}, "spacing": "0.06 + 0.05 * x"}
    mesh_case(load_case("disc.yaml", text=json.dumps(case | {"packing": {"effort": "fast", "mend_worse": 1.05}})))
    assert counts["other number"] >= 2
    assert counts["spliced"] > counts["other number"]
    if engine() == COMPILED:
        assert counts["not spared"] <= counts["spliced"] // 4
