from dataclasses import replace

import numpy as np
import pytest
from lattices import DAMPED, packed_hexagon, uniform

from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.net import connect
from bubblemesh.packing.placement.diffusion import ErrorDiffusion, boundary_bubbles
from bubblemesh.packing.population import (
    MANY_NEIGHBOURS,
    NEAREST_TO_CORNER,
    WIDEST_CORNER,
    Defects,
    across_wide_corners,
    crowded_on_walls,
    relative_lengths,
)
from bubblemesh.packing.relaxation import Connected
from bubblemesh.spacing.spacing import Spacing

SIDE = 5
NEVER = Defects(insert_longer=2.0, insert_longer_at_crowd=2.0)  # to insert


def controlled(scheme, domain, spacing, bubbles):
    return scheme(connect(bubbles, domain), domain, spacing, np.random.default_rng(0))


def with_interior(bubbles, inside):
    x = np.vstack([bubbles.x[: bubbles.boundary_count], inside])
    return Bubbles(x, np.ones(len(x)), bubbles.piece, bubbles.s, bubbles.corners, touched=np.zeros(len(x), bool))


def inside_shell(domain, spacing, inside):
    """Bubbles equally spaced on the boundary, and given ones inside."""
    shell = boundary_bubbles(domain, spacing)
    inside = np.array(inside, float).reshape(-1, 2)
    return shell.append(inside, spacing(inside), np.zeros(0, np.int64), np.zeros(0))


def random_packing(seed, curved=False):
    """A packing with many defects."""
    ring = rings.circle((0, 0), 3) if curved else rings.rectangle(-3, -3, 3, 3)
    domain = Domain.of(ring, [rings.circle((0.5, 0), 0.8)])
    spacing = Spacing(lambda x, y: 0.25 + 0.05 * np.hypot(x, y))
    bubbles = ErrorDiffusion()(domain, spacing, 10_000)
    x = bubbles.x.copy()
    x[bubbles.interior] += 0.02 * np.random.default_rng(seed).standard_normal(x[bubbles.interior].shape)
    return domain, spacing, replace(bubbles, x=x, d=spacing(x))


def rows(points):
    return {tuple(point) for point in points.tolist()}


def middles(net, points):
    """The net's edges whose middles the points are."""
    ends = net.bubbles.x[net.edges].mean(axis=1)
    distance = np.hypot(*(points[:, None] - ends).transpose(2, 0, 1))
    assert (distance.min(axis=1) < 1e-12).all()
    return net.edges[distance.argmin(axis=1)]


def test_perfect_lattice_does_not_change():
    domain, spacing, bubbles = packed_hexagon(SIDE)
    change = controlled(Defects(), domain, spacing, bubbles)
    assert (change.deleted, change.inserted) == (0, 0)
    np.testing.assert_array_equal(change.bubbles.x, bubbles.x)
    assert not change.bubbles.touched.any()


def test_doubled_bubble_is_deleted_and_its_neighbours_are_touched():
    domain, spacing, bubbles = packed_hexagon(SIDE)
    doubled = with_interior(bubbles, np.vstack([bubbles.x[bubbles.interior], [[0.1, 0.05]]]))
    change = controlled(Defects(), domain, spacing, doubled)
    assert (change.deleted, change.inserted) == (1, 0)
    away = np.hypot(*change.bubbles.x.T)
    assert np.sum(away < 0.3) == 1
    assert change.bubbles.touched[away < 0.3].all()
    assert change.bubbles.touched.sum() >= 3
    assert not change.bubbles.touched[away > 1.7].any()


@pytest.mark.parametrize("hole", [(0.0, 0.0), (1.0, 0.0), (-1.5, np.sqrt(3) / 2)])
def test_vacancy_is_filled_and_relaxes_to_the_perfect_lattice(hole):
    domain, spacing, bubbles = packed_hexagon(SIDE)
    inside = bubbles.x[bubbles.interior]
    start = with_interior(bubbles, inside[np.hypot(*(inside - hole).T) > 0.1])
    change = controlled(Defects(), domain, spacing, start)
    assert (change.deleted, change.inserted) == (0, 1)
    assert np.hypot(*(change.bubbles.x[-1] - hole)) < 0.51
    assert change.bubbles.touched[-1]
    assert change.bubbles.d[-1] == 1
    net = connect(change.bubbles, domain)
    end = Connected()(net, domain, spacing, DAMPED, 300).bubbles.x
    distance = np.hypot(*(end[:, None] - bubbles.x).transpose(2, 0, 1))
    assert distance.min(axis=1).max() < 1e-2
    assert sorted(distance.argmin(axis=1).tolist()) == list(range(len(bubbles)))


def test_bubble_with_four_neighbours_is_deleted():
    domain, _, bubbles = packed_hexagon(SIDE)
    inside = np.vstack([bubbles.x[bubbles.interior], [[0.5, 0.0]]])
    more = replace(with_interior(bubbles, inside), d=np.full(len(bubbles) + 1, 0.6))  # nothing is too near
    net = connect(more, domain)
    assert net.valence[-1] == 4
    assert relative_lengths(net.bubbles, net.edges).min() > 0.8
    change = controlled(NEVER, domain, uniform(0.6), more)
    assert (change.deleted, change.inserted) == (1, 0)
    np.testing.assert_array_equal(change.bubbles.x, bubbles.x)


def test_of_two_bubbles_too_near_the_one_with_more_neighbours_stays():
    unequal = 0
    for seed in range(5):
        domain, spacing, bubbles = random_packing(seed)
        net = connect(bubbles, domain)
        after = rows(controlled(NEVER, domain, spacing, bubbles).bubbles.x)
        short = net.edges[relative_lengths(net.bubbles, net.edges) < 0.72]
        alone = (np.bincount(short.ravel(), minlength=len(bubbles)) == 1) & (net.valence > 4)
        alone[: bubbles.boundary_count] = False
        for i, j in short[alone[short].all(axis=1)]:
            if net.valence[i] != net.valence[j]:
                unequal += 1
                assert tuple(bubbles.x[i if net.valence[i] > net.valence[j] else j]) in after
    assert unequal > 10


def test_bubble_with_five_neighbours_stays():
    angle = np.arange(5) * 2 * np.pi / 5
    domain = Domain.of(rings.polygon(np.column_stack([np.cos(angle), np.sin(angle)])))
    change = controlled(Defects(), domain, uniform(1.0), inside_shell(domain, uniform(1.0), [(0, 0)]))
    assert (change.deleted, change.inserted, len(change.bubbles)) == (0, 0, 6)


@pytest.mark.parametrize(("sides", "inserted"), [(7, 0), (8, 1)])
def test_bubble_with_eight_neighbours_gets_one_more_where_an_edge_is_rather_long(sides, inserted):
    angle = np.arange(sides) * 2 * np.pi / sides
    domain = Domain.of(rings.polygon(1.25 * np.column_stack([np.cos(angle), np.sin(angle)])))
    bubbles = inside_shell(domain, uniform(1.0), [(0, 0)])
    assert connect(bubbles, domain).valence[-1] == sides
    change = controlled(Defects(), domain, uniform(1.0), bubbles)
    assert (change.deleted, change.inserted) == (0, inserted)
    if inserted:
        assert np.hypot(*change.bubbles.x[-1]) == pytest.approx(0.625)


@pytest.mark.parametrize(("distance", "deleted"), [(0.7, 1), (0.74, 0)])
def test_edge_is_too_short_below_its_threshold(distance, deleted):
    domain, spacing, bubbles = packed_hexagon(SIDE)
    x = bubbles.x.copy()
    (first,) = np.flatnonzero(np.hypot(*x.T) < 0.1)
    x[first] = [1 - distance, 0]
    change = controlled(NEVER, domain, spacing, replace(bubbles, x=x))
    assert change.deleted == deleted


@pytest.mark.parametrize(("length", "inserted"), [(1.36, 0), (1.4, 1)])
def test_edge_is_too_long_above_its_threshold(length, inserted):
    domain = Domain.of(rings.polygon([(-length / 2, 0), (0, -0.75), (length / 2, 0), (0, 0.75)]))
    shell = boundary_bubbles(domain, uniform(1.0))
    net = connect(shell, domain)
    assert net.inner.sum() == 1
    change = controlled(Defects(), domain, uniform(1.0), shell)
    assert change.inserted == inserted
    if inserted:
        np.testing.assert_allclose(change.bubbles.x[-1], [0, 0], atol=1e-12)


def test_long_boundary_edges_are_not_halved():
    domain = Domain.of(rings.polygon([(0, 0), (1.45, 0), (0.725, 1.25)]))
    shell = boundary_bubbles(domain, uniform(1.0))
    assert relative_lengths(shell, connect(shell, domain).edges).max() > 1.4
    change = controlled(Defects(), domain, uniform(1.0), shell)
    assert (change.deleted, change.inserted, len(change.bubbles)) == (0, 0, 3)


@pytest.mark.parametrize(("distance", "stays"), [(0.45, False), (0.55, True), (0.65, True)])
def test_bubble_in_the_angle_of_a_corner_may_be_nearer(distance, stays):
    domain = Domain.of(rings.rectangle(0, 0, 4.4, 4.4))
    place = np.full(2, distance / np.sqrt(2))
    bubbles = inside_shell(domain, uniform(1.0), [place, (1.3, 0.75), (0.75, 1.3), (2.2, 2.2)])
    assert connect(bubbles, domain).valence[bubbles.boundary_count] == 5
    change = controlled(NEVER, domain, uniform(1.0), bubbles)
    assert (tuple(place) in rows(change.bubbles.x)) == stays


def test_right_angle_with_one_triangle_gets_a_bubble():
    domain, spacing = Domain.of(rings.rectangle(0, 0, 4, 4)), uniform(1.0)
    grid = np.stack(np.meshgrid([1.0, 2.0, 3.0], [1.0, 2.0, 3.0]), axis=-1).reshape(-1, 2)
    bubbles = inside_shell(domain, spacing, grid - 0.02 * np.sign(grid - 2))  # corner and next bubble not connected
    net = connect(bubbles, domain)
    assert (net.valence[:4] == 2).all()
    change = controlled(NEVER, domain, spacing, bubbles)
    assert change.inserted == 4
    assert rows(change.bubbles.x[-4:]) == {(0.5, 0.5), (3.5, 0.5), (0.5, 3.5), (3.5, 3.5)}
    assert (connect(change.bubbles, domain).valence[:4] == 3).all()


def test_right_angle_with_two_triangles_stays():
    domain, spacing = Domain.of(rings.rectangle(0, 0, 4, 4)), uniform(1.0)
    grid = np.stack(np.meshgrid([1.0, 2.0, 3.0], [1.0, 2.0, 3.0]), axis=-1).reshape(-1, 2)
    bubbles = inside_shell(domain, spacing, grid + 0.05 * np.sign(grid - 2))
    assert (connect(bubbles, domain).valence[:4] == 3).all()
    assert controlled(NEVER, domain, spacing, bubbles).inserted == 0


def test_right_angle_too_small_for_a_bubble_stays():
    domain, spacing = Domain.of(rings.rectangle(0, 0, 3.2, 3.2)), uniform(1.0)  # edges of 0.8
    bubbles = inside_shell(domain, uniform(0.8), [(1.6, 1.6)])
    bubbles = replace(bubbles, d=np.ones(len(bubbles)))
    net = connect(bubbles, domain)
    assert np.hypot(*(net.bubbles.x[net.facets[0, 0]] - net.bubbles.x[net.facets[0, 1]])) == pytest.approx(0.8)
    assert controlled(NEVER, domain, spacing, bubbles).inserted == 0


def test_right_angle_whose_other_side_is_the_boundary_stays():
    domain = Domain.of(rings.polygon([(0, 0), (1.5, 0), (0, 1.5)]))
    change = controlled(Defects(), domain, uniform(5.0), boundary_bubbles(domain, uniform(5.0)))
    assert (change.deleted, change.inserted, len(change.bubbles)) == (0, 0, 3)


def test_crowded_bubble_on_a_straight_wall_is_deleted():
    domain, spacing, bubbles = packed_hexagon(SIDE)
    at = np.array([2.5])
    none = np.zeros(1, np.int64)
    more = bubbles.append(domain.boundary.points(none, at), np.ones(1), none, at)
    change = controlled(Defects(), domain, spacing, more)
    assert (change.deleted, change.inserted) == (1, 0)
    np.testing.assert_array_equal(change.bubbles.x, bubbles.x)
    np.testing.assert_array_equal(change.bubbles.s, bubbles.s)


def crowded_on_circle(domain, gap, inside=()):
    """Bubbles around a disc with one more in the middle of a gap, and some inside."""
    shell = boundary_bubbles(domain, uniform(1.0))
    at, zero = shell.s[gap : gap + 2].mean(keepdims=True), np.zeros(1, np.int64)
    x = np.vstack([domain.boundary.points(zero, at), *inside])
    return shell.append(x, np.ones(len(x)), zero, at)


@pytest.mark.parametrize(("radius", "kept"), [(3, True), (8, False)])
def test_a_crowded_bubble_goes_where_a_curve_turns_little(radius, kept):
    domain = Domain.of(rings.circle((0, 0), radius))
    ((x, y),) = crowded_on_circle(domain, 0).x[-1:]
    bubbles = crowded_on_circle(domain, 0, [np.array([[x, y]]) * (1 - 0.86 / radius)])
    assert connect(bubbles, domain).valence[bubbles.boundary_count - 1] == 3
    change = controlled(NEVER, domain, uniform(1.0), bubbles)
    assert (change.bubbles.boundary_count == bubbles.boundary_count) is kept


def test_a_crowded_bubble_stays_whose_triangles_end_at_another_wall():
    domain = Domain.of(rings.circle((0, 0), 8), [rings.circle((0, 0), 7.2)])
    for gap in range(40):
        bubbles = crowded_on_circle(domain, gap)
        net = connect(bubbles, domain)
        fewest = net.valence == 3
        if fewest.any():
            assert not crowded_on_walls(net, domain).any()
            return
    pytest.fail("no bubble has two triangles")


@pytest.mark.parametrize("seed", range(3))
def test_bubbles_on_curves_and_corners_never_change(seed):
    domain, spacing, bubbles = random_packing(seed, curved=True)
    change = controlled(Defects(), domain, spacing, bubbles)
    at = bubbles.boundary_count
    assert change.bubbles.boundary_count == at
    np.testing.assert_array_equal(change.bubbles.x[:at], bubbles.x[:at])
    np.testing.assert_array_equal(change.bubbles.s, bubbles.s)
    assert change.deleted > 10


@pytest.mark.parametrize("curved", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_no_two_deletions_are_connected_and_no_two_insertions_share_a_bubble(seed, curved):
    domain, spacing, bubbles = random_packing(seed, curved)
    net = connect(bubbles, domain)
    change = Defects()(net, domain, spacing, np.random.default_rng(0))
    after = rows(change.bubbles.x)
    gone = np.array([tuple(x) not in after for x in bubbles.x.tolist()])
    assert gone.sum() == change.deleted > 10
    assert not gone[net.edges].all(axis=1).any()
    new = np.array([x for x in change.bubbles.x.tolist() if tuple(x) not in rows(bubbles.x)])
    assert len(new) == change.inserted > 10
    halved = middles(net, new)
    assert len(np.unique(halved)) == halved.size
    assert not gone[halved].any()
    assert len(change.bubbles) == len(bubbles) - change.deleted + change.inserted
    np.testing.assert_array_equal(change.bubbles.d[-len(new) :], spacing(new))


@pytest.mark.parametrize("seed", range(3))
def test_touched_bubbles_are_those_next_to_a_change(seed):
    domain, spacing, bubbles = random_packing(seed)
    net = connect(bubbles, domain)
    change = Defects()(net, domain, spacing, np.random.default_rng(0))
    after = {
        tuple(x): bool(touched) for x, touched in zip(change.bubbles.x.tolist(), change.bubbles.touched, strict=True)
    }
    before = [tuple(x) for x in bubbles.x.tolist()]
    new = np.array([x for x in after if x not in set(before)])
    expected = set(middles(net, new).ravel().tolist())
    for i, j in net.edges.tolist():
        for one, other in ((i, j), (j, i)):
            if before[one] not in after:
                expected.add(other)
    for k, x in enumerate(before):
        if x in after:
            assert after[x] == (k in expected)
    assert all(after[tuple(x)] for x in new.tolist())


def test_population_settles():
    domain, spacing, bubbles = random_packing(0)
    changes = []
    for _ in range(12):
        net = connect(bubbles, domain)
        bubbles = Connected()(net, domain, spacing, DAMPED, 40).bubbles
        change = controlled(Defects(), domain, spacing, replace(bubbles, d=spacing(bubbles.x)))
        changes.append(change.deleted + change.inserted)
        bubbles = change.bubbles
    assert changes[0] > 5 * max(changes[-3:])


@pytest.mark.parametrize("seed", range(3))
def test_relative_lengths_are_lengths_over_mean_spacing(seed):
    domain, _, bubbles = random_packing(seed)
    net = connect(bubbles, domain)
    expected = [
        np.hypot(*(bubbles.x[i] - bubbles.x[j])) / ((bubbles.d[i] + bubbles.d[j]) / 2) for i, j in net.edges.tolist()
    ]
    np.testing.assert_allclose(relative_lengths(net.bubbles, net.edges), expected, rtol=1e-12)


def loop_across_wide_corners(net):
    """Edges that face too wide an angle at a corner, triangle by triangle."""
    facets, x = {frozenset(facet) for facet in net.facets.tolist()}, net.bubbles.x
    for triangle in net.triangles.tolist():
        apex = min(triangle)
        a, b = sorted(set(triangle) - {apex})
        u, v = x[a] - x[apex], x[b] - x[apex]
        wide = u @ v < WIDEST_CORNER * np.linalg.norm(u) * np.linalg.norm(v)
        roomy = np.linalg.norm((x[a] + x[b]) / 2 - x[apex]) > NEAREST_TO_CORNER * net.bubbles.d[apex]
        if apex < net.bubbles.corners and wide and roomy and frozenset((a, b)) not in facets:
            yield a, b


def fan(corner_size):
    """A square with one bubble inside, whose corners see one triangle each; the spacing may be larger at corners."""
    domain = Domain.of(rings.rectangle(0, 0, 2, 2))
    shell = boundary_bubbles(domain, uniform(1))
    d = np.where(np.arange(len(shell)) < shell.corners, corner_size, 1.0)
    return connect(replace(shell, d=d), domain)


@pytest.mark.parametrize("corner_size", [0.5, 1.0, 1.3, 2.0])
def test_edges_across_wide_corners_are_those_of_the_loop_in_a_fan(corner_size):
    net = fan(corner_size)
    found = across_wide_corners(net, np.zeros(len(net.bubbles), bool))
    assert sorted(map(tuple, found.tolist())) == sorted(loop_across_wide_corners(net))


def test_a_fan_has_wide_corners_where_the_spacing_leaves_room():
    assert len(list(loop_across_wide_corners(fan(0.5)))) > 0
    assert len(list(loop_across_wide_corners(fan(2.0)))) == 0


@pytest.mark.parametrize("height", [0.0, 0.15])
def test_a_corner_at_which_the_boundary_goes_nearly_straight_on_has_no_wide_angle(height):
    ring = [(0, height), (1, 0), (1, 1), (0, 1.1), (-1, 1), (-1, 0)]
    domain = Domain.of(rings.polygon(ring))
    x = np.array([[0.0, height + 0.5]])
    net = connect(boundary_bubbles(domain, uniform(0.8)).append(x, np.full(1, 0.8)), domain)
    middle = domain.boundary.corners.tolist().index([0.0, height])
    beside = [set(triangle) - {middle} for triangle in net.triangles.tolist() if middle in triangle]
    found = [set(edge) for edge in across_wide_corners(net, np.zeros(len(net.bubbles), bool)).tolist()]
    assert not any(edge in found for edge in beside)


@pytest.mark.parametrize("seed", range(3))
def test_halved_edges_are_the_longest_first(seed):
    domain, _, bubbles = random_packing(seed)
    bubbles = bubbles.select(np.r_[: bubbles.boundary_count, bubbles.boundary_count + 3 : len(bubbles) : 2])
    net = connect(bubbles, domain)
    gone = np.zeros(len(bubbles), bool)
    gone[bubbles.boundary_count :: 7] = True
    ratio, scheme, inner = relative_lengths(bubbles, net.edges), Defects(), set(np.flatnonzero(net.inner).tolist())

    def is_long(k):
        limit = scheme.insert_longer
        if max(net.valence[net.edges[k]]) >= MANY_NEIGHBOURS:
            limit = scheme.insert_longer_at_crowd
        return k in inner and not gone[net.edges[k]].any() and ratio[k] > limit

    long_edges = sorted(filter(is_long, range(len(net.edges))), key=lambda k: -ratio[k])
    candidates = [*net.edges[long_edges].tolist(), *across_wide_corners(net, gone).tolist()]
    first = {}
    for rank, edge in enumerate(candidates):
        for bubble in edge:
            first.setdefault(bubble, rank)
    expected = [edge for rank, edge in enumerate(candidates) if all(first[bubble] == rank for bubble in edge)]
    assert expected
    assert scheme._too_long(net, ratio, gone).tolist() == expected
