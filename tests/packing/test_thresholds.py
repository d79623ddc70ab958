import numpy as np
import pytest
from lattices import hexagon, hexagonal, packed_hexagon

from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.neighbours import Neighbours
from bubblemesh.packing.net import connect
from bubblemesh.packing.placement.diffusion import boundary_bubbles
from bubblemesh.packing.population import Thresholds, boundary_gaps, boundary_overlaps, overlaps
from bubblemesh.spacing.spacing import Spacing

SIDE = 5


def with_interior(bubbles, inside):
    x = np.vstack([bubbles.x[: bubbles.boundary_count], inside])
    return Bubbles(x, np.ones(len(x)), bubbles.piece, bubbles.s, bubbles.corners, touched=np.zeros(len(x), bool))


def distance_to_others(x):
    distance = np.hypot(*(x[:, None] - x).transpose(2, 0, 1))
    return (distance + np.diag(np.full(len(x), np.inf))).min(axis=1)


def test_overlap_ratio_is_six_inside_a_perfect_lattice():
    x = hexagonal(9, 9, d=0.2)
    alpha = overlaps(Neighbours.of(x, np.full(81, 0.2), 2.0)).reshape(9, 9)
    np.testing.assert_allclose(alpha[2:-2, 2:-2], 6, atol=1e-12)
    assert (alpha[[0, -1]] < 5).all()


@pytest.mark.parametrize("seed", range(3))
def test_overlap_ratios_are_those_of_the_double_loop(seed):
    rng = np.random.default_rng(seed)
    x, d = rng.random((50, 2)), rng.uniform(0.05, 0.4, 50)
    r = d / 2
    expected = [
        sum(max(0, 2 * r[i] + r[j] - np.hypot(*(x[i] - x[j]))) / r[i] for j in range(50) if j != i) for i in range(50)
    ]
    np.testing.assert_allclose(overlaps(Neighbours.of(x, d, 2.0)), expected, atol=1e-12)


def test_boundary_overlap_ratio_is_two_when_in_place():
    domain, _, bubbles = packed_hexagon(SIDE)
    np.testing.assert_allclose(boundary_overlaps(bubbles, domain), 2, atol=1e-12)


def test_perfect_lattice_does_not_change():
    domain, spacing, bubbles = packed_hexagon(SIDE)
    change = Thresholds()(connect(bubbles, domain), domain, spacing, np.random.default_rng(0))
    assert (change.deleted, change.inserted) == (0, 0)
    assert not change.bubbles.touched.any()
    np.testing.assert_array_equal(change.bubbles.x, bubbles.x)


def test_doubled_bubble_is_deleted_and_its_neighbours_are_touched():
    domain, spacing, bubbles = packed_hexagon(SIDE)
    doubled = with_interior(bubbles, np.vstack([bubbles.x[bubbles.interior], [[0.1, 0.05]]]))
    change = Thresholds()(connect(doubled, domain), domain, spacing, np.random.default_rng(0))
    assert (change.deleted, change.inserted) == (1, 0)
    assert len(change.bubbles) == len(bubbles)
    assert distance_to_others(change.bubbles.x).min() > 0.85
    away = np.hypot(*change.bubbles.x.T)
    assert change.bubbles.touched[away < 1.3].all()
    assert not change.bubbles.touched[away > 1.7].any()


def test_vacancy_is_filled_where_the_bubble_is_missing():
    domain, spacing, bubbles = packed_hexagon(SIDE)
    inside = bubbles.x[bubbles.interior]
    hole = inside[np.hypot(*(inside - [1.0, 0.0]).T).argmin()]
    scheme = Thresholds(insert_below=5.5)  # the neighbours of a single vacancy have 5
    start = with_interior(bubbles, inside[(inside != hole).any(axis=1)])
    change = scheme(connect(start, domain), domain, spacing, np.random.default_rng(0))
    assert (change.deleted, change.inserted) == (0, 1)
    np.testing.assert_allclose(change.bubbles.x[-1], hole, atol=1e-9)
    assert change.bubbles.touched[-1]
    assert np.flatnonzero(change.bubbles.touched).size >= 4  # the new bubble and the triangle it came into


def test_gap_on_the_boundary_is_filled_in_its_middle():
    domain, spacing, bubbles = packed_hexagon(SIDE)
    gone = bubbles.corners + 2
    keep = np.delete(np.arange(len(bubbles)), gone)
    change = Thresholds()(connect(bubbles.select(keep), domain), domain, spacing, np.random.default_rng(0))
    assert change.inserted == 1
    assert change.bubbles.boundary_count == bubbles.boundary_count
    new = change.bubbles.boundary_count - 1
    np.testing.assert_allclose(change.bubbles.x[new], bubbles.x[gone], atol=1e-12)
    assert (change.bubbles.piece[-1], change.bubbles.s[-1]) == (bubbles.piece[2], pytest.approx(bubbles.s[2]))
    assert change.bubbles.touched[new]


def test_crowded_boundary_bubble_is_deleted():
    domain, spacing, bubbles = packed_hexagon(SIDE)
    more = bubbles.append(
        domain.boundary.points(np.array([0]), np.array([2.5])), np.ones(1), np.array([0]), np.array([2.5])
    )
    change = Thresholds()(connect(more, domain), domain, spacing, np.random.default_rng(0))
    assert change.bubbles.boundary_count == bubbles.boundary_count
    assert change.bubbles.corners == bubbles.corners


def test_deletions_of_a_round_keep_their_distance():
    domain, spacing, bubbles = packed_hexagon(SIDE)
    rng = np.random.default_rng(0)
    inside = bubbles.x[bubbles.interior]
    crowd = np.vstack([inside, inside + rng.uniform(-0.3, 0.3, inside.shape), inside + rng.uniform(-0.3, 0.3, (1, 2))])
    crowd = crowd[domain.signed_distance(crowd) > 0.3]
    before = with_interior(bubbles, crowd)
    change = Thresholds()(connect(before, domain), domain, spacing, np.random.default_rng(0))
    after = {tuple(x) for x in change.bubbles.x.tolist()}
    gone = np.array([x for x in before.x.tolist() if tuple(x) not in after])
    assert len(gone) == change.deleted > 3
    assert distance_to_others(gone).min() >= 1.2


def test_insertions_of_a_round_keep_their_distance():
    domain, spacing, bubbles = packed_hexagon(SIDE)
    inside = bubbles.x[bubbles.interior]
    start = with_interior(bubbles, inside[np.hypot(*inside.T) > 2.5])
    change = Thresholds()(connect(start, domain), domain, spacing, np.random.default_rng(0))
    assert change.inserted > 3
    assert distance_to_others(change.bubbles.x).min() > 0.85 - 1e-9


def test_counts_add_up_whatever_the_start():
    domain, spacing, bubbles = packed_hexagon(SIDE)
    for seed in range(5):
        rng = np.random.default_rng(seed)
        inside = rng.uniform(-SIDE, SIDE, (70, 2))
        start = with_interior(bubbles, inside[domain.signed_distance(inside) > 0.2])
        change = Thresholds()(connect(start, domain), domain, spacing, np.random.default_rng(0))
        assert len(change.bubbles) == len(start) - change.deleted + change.inserted
        assert change.bubbles.touched.shape == (len(change.bubbles),)


def test_lattice_fills_its_hexagon():
    _, _, bubbles = packed_hexagon(SIDE)
    assert sorted(map(tuple, bubbles.x.round(6) + 0.0)) == sorted(map(tuple, hexagon(SIDE).round(6) + 0.0))


def test_the_order_of_deletion():
    alpha, random = np.array([5.0, 9.0, 8.0, 9.0]), np.random.default_rng(3)
    assert Thresholds(delete_order="placed").rank(alpha, random).tolist() == [0, 1, 2, 3]
    assert Thresholds(delete_order="worst").rank(alpha, random).tolist() == [3, 0, 2, 1]
    shuffled = Thresholds(delete_order="random").rank(np.zeros(50), random).tolist()
    assert sorted(shuffled) == list(range(50)) != shuffled


def test_edges_of_the_boundary_have_room_by_the_spacing_of_their_own_ends():
    domain = Domain.of(rings.rectangle(0, 0, 4, 4))
    bubbles = boundary_bubbles(domain, Spacing(lambda x, y: 0.2 + 0.2 * x))
    every_second = np.r_[: bubbles.corners, bubbles.corners + 1 : len(bubbles) : 2]
    bubbles = bubbles.select(every_second)
    net = connect(bubbles, domain)
    found, piece, s = boundary_gaps(bubbles, domain, net.facets, net.facet_piece, 0.8)
    x, d = bubbles.x, bubbles.d
    expected = [(i, j) for i, j in net.facets.tolist() if np.hypot(*(x[i] - x[j])) > 1.6 * (d[i] + d[j]) / 2]
    assert 0 < len(expected) < len(net.facets)
    assert [tuple(edge) for edge in found.tolist()] == expected
    np.testing.assert_allclose(domain.boundary.points(piece, s), x[found].mean(axis=1), atol=1e-12)


def test_random_order_of_deletion_is_drawn_from_the_generator():
    domain, spacing, bubbles = packed_hexagon(SIDE)
    inside = bubbles.x[bubbles.interior]
    net = connect(with_interior(bubbles, np.vstack([inside, inside + np.array([0.2, 0.1])])), domain)
    scheme = Thresholds(delete_order="random")
    left = [scheme(net, domain, spacing, np.random.default_rng(seed)).bubbles.x for seed in (0, 0, 1)]
    assert np.array_equal(left[0], left[1])
    assert not np.array_equal(left[0], left[2])
