import json
from collections import Counter
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from lattices import packed_hexagon, uniform
from twins import needs_compiler

from bubblemesh.case import load_case
from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing import net as nets
from bubblemesh.packing.net import connect, connect_inside, reconnect
from bubblemesh.packing.placement.diffusion import ErrorDiffusion
from bubblemesh.run.pipeline import mesh_case
from bubblemesh.spacing.spacing import Spacing

DOMAINS = {
    "square": (Domain.of(rings.rectangle(0, 0, 3, 2)), 0.25),
    "narrow": (Domain.of(rings.rectangle(0, 0, 4, 0.4)), 0.25),  # with edges across from one side to the other
    "ring": (Domain.of(rings.circle((0, 0), 1.5), [rings.circle((0.2, 0), 0.6)]), 0.22),
    "holes": (
        Domain.of(rings.rectangle(0, 0, 3, 3), [rings.rectangle(0.5, 0.5, 1.5, 1.5), rings.circle((2.2, 2.2), 0.5)]),
        0.2,
    ),
}


SHORT = {"method": "accelerated", "schedule": {"rounds": 2, "iterations": 30}}


def net_of(name):
    """Bubbles in general position, no four of them on a circle."""
    domain, d = DOMAINS[name]
    bubbles = ErrorDiffusion()(domain, uniform(d), 10_000)
    x = bubbles.x.copy()
    x[bubbles.interior] += 0.02 * d * np.random.default_rng(0).standard_normal(x[bubbles.interior].shape)
    return connect(replace(bubbles, x=x), domain)


@pytest.fixture(scope="module", params=DOMAINS)
def net(request):
    return net_of(request.param)


def sides_of(triangles):
    return [side for i, j, k in triangles.tolist() for side in pairwise((i, j, k, i))]


def neighbours_of(net):
    near = {i: set() for i in range(len(net.bubbles))}
    for i, j in sides_of(net.triangles):
        near[i].add(j)
        near[j].add(i)
    return near


def ball(near, start, rings):
    found = set(start)
    for _ in range(rings):
        found |= {j for i in found for j in near[i]}
    return found


def random_marks(net, share, seed=0):
    return np.random.default_rng(seed).random(len(net.bubbles)) < share


def test_edges_are_those_of_the_triangles_each_once(net):
    found = [frozenset(edge) for edge in net.edges.tolist()]
    assert len(set(found)) == len(found)
    assert set(found) == {frozenset(side) for side in sides_of(net.triangles)}


def test_triangles_turn_left_and_have_the_facets_on_their_rim(net):
    a, b, c = (net.bubbles.x[net.triangles[:, k]] for k in range(3))
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    assert (ux * vy - uy * vx > 0).all()
    sides = Counter(sides_of(net.triangles))
    free = {(i, j) for i, j in sides if (j, i) not in sides}
    assert free == {(i, j) for i, j in net.facets.tolist()}
    assert set(sides.values()) == {1}


def test_facets_follow_their_pieces(net):
    for (i, j), piece in zip(net.facets.tolist(), net.facet_piece.tolist(), strict=True):
        for node in (i, j):
            if node >= net.bubbles.corners:
                assert net.bubbles.piece[node - net.bubbles.corners] == piece


def test_valence_is_the_number_of_neighbours(net):
    near = neighbours_of(net)
    assert net.valence.tolist() == [len(near[i]) for i in range(len(net.bubbles))]


def test_inner_edges_are_those_that_are_no_facets(net):
    facets = {frozenset(facet) for facet in net.facets.tolist()}
    assert net.inner.tolist() == [frozenset(edge) not in facets for edge in net.edges.tolist()]
    assert (~net.inner).sum() == len(net.facets)


def test_narrow_domain_has_inner_edges_between_boundary_bubbles():
    net = net_of("narrow")
    on_boundary = (net.edges < net.bubbles.boundary_count).all(axis=1)
    assert (on_boundary & net.inner).any()


@pytest.mark.parametrize("share", [0.0, 0.02, 0.3, 1.0])
def test_joined_are_the_marked_and_their_neighbours(net, share):
    marked = random_marks(net, share)
    before = marked.copy()
    assert set(np.flatnonzero(net.dilated(marked)).tolist()) == ball(neighbours_of(net), np.flatnonzero(marked), 1)
    np.testing.assert_array_equal(marked, before)


@pytest.mark.parametrize("rings", range(5))
def test_within_are_those_that_so_many_steps_lead_to(net, rings):
    near = neighbours_of(net)
    for start in ([7], [0, len(net.bubbles) - 1], []):
        found = net.within(np.array(start, int), rings)
        assert set(np.flatnonzero(found).tolist()) == ball(near, start, rings)
    triangle = net.triangles[[len(net.triangles) // 2]]
    found = net.within(triangle, rings)
    assert set(np.flatnonzero(found).tolist()) == ball(near, triangle.ravel().tolist(), rings)


@pytest.mark.parametrize("rings", [1, 3, 100])
def test_part_is_made_of_the_triangles_whose_nodes_are_marked(net, rings):
    start = [net.bubbles.corners + 1, len(net.bubbles) - 1]  # at the boundary, and not
    marked = net.within(np.array(start), rings)
    before = marked.copy()
    numbers, part = net.part(marked)
    np.testing.assert_array_equal(marked, before)
    chosen = set(np.flatnonzero(marked).tolist())
    assert numbers.tolist() == sorted(chosen | set(range(net.bubbles.corners)))
    for name in ("x", "d", "touched"):
        np.testing.assert_array_equal(getattr(part.bubbles, name), getattr(net.bubbles, name)[numbers])
    slides = numbers[(numbers >= net.bubbles.corners) & (numbers < net.bubbles.boundary_count)] - net.bubbles.corners
    np.testing.assert_array_equal(part.bubbles.piece, net.bubbles.piece[slides])
    np.testing.assert_array_equal(part.bubbles.s, net.bubbles.s[slides])
    whole = [tuple(triangle) for triangle in net.triangles.tolist() if set(triangle) <= chosen]
    assert [tuple(triangle) for triangle in numbers[part.triangles].tolist()] == whole
    edges = {frozenset(edge) for edge in net.edges.tolist() if set(edge) <= chosen}
    assert {frozenset(edge) for edge in numbers[part.edges].tolist()} == edges
    own = dict(zip(map(tuple, net.facets.tolist()), net.facet_piece.tolist(), strict=True))
    sides = {side for i, j, k in whole for side in pairwise((i, j, k, i))}
    rim = {(i, j): own.get((i, j), -1) for i, j in sides if (j, i) not in sides}
    facets = map(tuple, numbers[part.facets].tolist())
    assert dict(zip(facets, part.facet_piece.tolist(), strict=True)) == rim
    assert len(part.facets) == len(rim)


def test_part_of_all_is_the_net(net):
    numbers, part = net.part(np.ones(len(net.bubbles), bool))
    assert numbers.tolist() == list(range(len(net.bubbles)))
    assert {tuple(facet) for facet in part.facets.tolist()} == {tuple(facet) for facet in net.facets.tolist()}
    np.testing.assert_array_equal(part.triangles, net.triangles)
    assert (part.facet_piece >= 0).all()


def test_reconnected_part_fills_the_same_region(net):
    marked = net.within(np.array([len(net.bubbles) - 1]), 3)
    _, part = net.part(marked)
    again = reconnect(part, part.bubbles)
    assert {frozenset(edge) for edge in again.edges.tolist()} == {frozenset(edge) for edge in part.edges.tolist()}
    np.testing.assert_array_equal(again.facets, part.facets)
    np.testing.assert_array_equal(again.facet_piece, part.facet_piece)


def test_reconnected_bubbles_have_the_edges_of_their_new_places():
    domain, _, bubbles = packed_hexagon(4)
    net = connect(bubbles, domain)
    x = bubbles.x.copy()
    x[bubbles.interior] += np.random.default_rng(0).uniform(-0.3, 0.3, x[bubbles.interior].shape)
    moved = replace(bubbles, x=x)
    found, expected = reconnect(net, moved), connect(moved, domain)
    assert found.bubbles is moved
    np.testing.assert_array_equal(found.edges, expected.edges)
    np.testing.assert_array_equal(found.triangles, expected.triangles)
    assert {frozenset(edge) for edge in found.edges.tolist()} != {frozenset(edge) for edge in net.edges.tolist()}


@needs_compiler
@pytest.mark.parametrize("move_again", [0.0, 0.2])
def test_flips_go_on_from_where_bubbles_were_connected(monkeypatch, move_again):
    domain, _, bubbles = packed_hexagon(4)
    net, random = connect(bubbles, domain), np.random.default_rng(0)

    def moved(some, most):
        x = some.x.copy()
        x[some.interior] += random.uniform(-most, most, x[some.interior].shape)
        return replace(some, x=x)

    turned_over = net.of(moved(bubbles, 0.6))
    a, b, c = turned_over.bubbles.x[turned_over.triangles].transpose(1, 0, 2)
    assert (np.linalg.det(np.stack([b - a, c - a], axis=1)) < 0).any()
    now = moved(turned_over.bubbles, move_again)
    monkeypatch.setattr(nets, "_triangulated", None)  # nothing is triangulated anew
    found = reconnect(turned_over, now)
    monkeypatch.undo()
    expected = connect(now, domain)
    assert (expected.valence > 0).all()
    np.testing.assert_array_equal(found.triangles, expected.triangles)
    assert found.start is now.x


@pytest.mark.parametrize("name", DOMAINS)
def test_enmeshed_bubbles_are_those_inside_with_the_spacing_of_their_places(name):
    domain, _ = DOMAINS[name]
    net = net_of(name)
    spacing = Spacing(lambda x, y: 0.2 + 0.01 * np.abs(x - y), floor=0.1)
    x = net.bubbles.x.copy()
    away = net.bubbles.boundary_count + np.array([0, 4, 9])
    x[away] = [[-5.0, 0.0], [9.0, 9.0], [50.0, 60.0]]
    found = connect_inside(replace(net.bubbles, x=x), domain, spacing)
    rest = np.delete(np.arange(len(x)), away)
    np.testing.assert_array_equal(found.bubbles.x, x[rest])
    np.testing.assert_array_equal(found.bubbles.d, spacing(x[rest]))
    assert found.bubbles.boundary_count == net.bubbles.boundary_count
    expected = connect(found.bubbles, domain)
    for one in ("facets", "facet_piece"):
        np.testing.assert_array_equal(getattr(found, one), getattr(expected, one))
    assert {frozenset(t) for t in found.triangles.tolist()} == {frozenset(t) for t in expected.triangles.tolist()}
    assert {frozenset(edge) for edge in found.edges.tolist()} == {frozenset(edge) for edge in expected.edges.tolist()}
    assert (found.valence > 0).all()


def test_enmeshed_bubbles_in_a_hole_are_lost_and_the_spacing_is_not_asked_for_there():
    domain, _ = DOMAINS["ring"]

    def function(x, y):
        distance = np.hypot(x - 0.2, y)
        assert (distance > 0.5).all()
        return 0.1 + 0.05 * distance

    net = net_of("ring")
    x = net.bubbles.x.copy()
    x[-2:] = [[0.2, 0.1], [0.1, 0.0]]
    found = connect_inside(replace(net.bubbles, x=x), domain, Spacing(function))
    assert len(found.bubbles) == len(x) - 2


def test_enmeshed_bubbles_all_inside_stay():
    domain, spacing, bubbles = packed_hexagon(4)
    net = connect_inside(replace(bubbles, d=np.zeros(len(bubbles))), domain, spacing)
    np.testing.assert_array_equal(net.bubbles.x, bubbles.x)
    np.testing.assert_array_equal(net.bubbles.d, 1)


def test_connected_bubbles_outside_belong_to_no_triangle():
    domain, _, bubbles = packed_hexagon(4)
    x = bubbles.x.copy()
    x[-1] = [9.0, 9.0]
    net = connect(replace(bubbles, x=x), domain)
    assert net.valence[-1] == 0
    assert (net.valence[:-1] > 0).all()


def test_nets_of_a_whole_packing_between_near_walls_are_those_made_anew(monkeypatch):
    """Bubbles slide along walls that are 2e-4 apart, so that triangles there are flat, with very large circles."""
    gap, tops = 1.9617e-4, (0.35139, 0.53537, 0.72079, 0.66284)
    holes = [{"rectangle": [0.2 * k + gap, gap, 0.2 * (k + 1), top]} for k, top in enumerate(tops)]
    seen = []

    def compared(net, bubbles, triangles=None):
        found = reconnect(net, bubbles, triangles)
        anew = nets.linked(bubbles.x, net.facets, net.two_sided)
        np.testing.assert_array_equal(found.triangles, anew[0])
        np.testing.assert_array_equal(found.edges, anew[1])
        seen.append(not np.array_equal(bubbles.s, net.bubbles.s))
        return found

    monkeypatch.setattr(nets, "reconnect", compared)
    text = json.dumps({"domain": {"outer": {"rectangle": [0, 0, 1, 1]}, "holes": holes}, "spacing": 1 / 14} | SHORT)
    mesh = mesh_case(load_case("walls.yaml", text=text)).mesh
    assert len(mesh.triangles) > 200
    assert any(seen)
