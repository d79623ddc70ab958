import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lattices import hexagonal

from bubblemesh.kernels.pairs import pairs_within
from bubblemesh.packing.neighbours import Neighbours, maximal_independent_set

pytestmark = pytest.mark.usefixtures("each_engine")


def all_pairs_within(x, d, reach):
    """Pairs of a look at each two points, ascending, like those that are found."""
    near = np.hypot(*(x[:, None] - x).transpose(2, 0, 1)) < reach * (d[:, None] + d) / 2
    return np.argwhere(np.triu(near, 1)).tolist()


def greedy(candidates, pairs, rank):
    rivals = {i: set() for i in range(len(rank))}
    for i, j in pairs:
        rivals[i].add(j)
        rivals[j].add(i)
    chosen = set()
    for i in np.argsort(rank):
        if candidates[i] and not rivals[i] & chosen:
            chosen.add(int(i))
    return [i in chosen for i in range(len(rank))]


@pytest.mark.parametrize("reach", [0.85, 1.9])
@pytest.mark.parametrize("octaves", [0, 1, 10])
@pytest.mark.parametrize("seed", range(3))
def test_pairs_are_those_of_the_double_loop(seed, octaves, reach):
    rng = np.random.default_rng(seed)
    d = 0.3 * 2.0 ** -rng.uniform(0, octaves, 150)
    x = rng.random((150, 2)) * rng.choice([1.0, 0.05], (150, 1))
    assert pairs_within(x, d, reach).tolist() == all_pairs_within(x, d, reach)


def test_pairs_follow_a_spacing_that_grows_a_thousandfold_from_a_point():
    rng = np.random.default_rng(0)
    distance, angle = 10.0 ** rng.uniform(-3, 0, 200), rng.uniform(0, 2 * np.pi, 200)
    x = distance[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    d = 0.3 * distance
    pairs = pairs_within(x, d, 1.9)
    assert d.max() / d.min() > 900
    assert len(pairs) > 200
    assert pairs.tolist() == all_pairs_within(x, d, 1.9)


@given(st.data())
@settings(derandomize=True, deadline=None, max_examples=40)
def test_pairs_of_any_points_are_those_of_the_double_loop(data):
    n = data.draw(st.integers(1, 12))
    numbers = st.integers(-4, 4).map(lambda k: k / 4)
    x = np.array(data.draw(st.lists(st.tuples(numbers, numbers), min_size=n, max_size=n)))
    d = np.array(data.draw(st.lists(st.sampled_from([0.001, 0.1, 0.5, 1.0]), min_size=n, max_size=n)))
    assert pairs_within(x, d, 1.5).tolist() == all_pairs_within(x, d, 1.5)


def test_no_points_have_no_pairs():
    assert pairs_within(np.zeros((0, 2)), np.zeros(0), 1.9).shape == (0, 2)


def test_points_at_one_place_are_all_pairs():
    x, d = np.tile([[0.3, 0.7]], (100, 1)), np.ones(100)
    assert pairs_within(x, d, 1.9).tolist() == all_pairs_within(x, d, 1.9)


def test_far_points_have_no_pairs():
    pairs = pairs_within(np.array([[0.0, 0.0], [5.0, 0.0]]), np.ones(2), 1.9)
    assert pairs.shape == (0, 2)
    assert np.issubdtype(pairs.dtype, np.integer)


def test_hexagonal_lattice_has_six_neighbours_inside():
    x = hexagonal(9, 9)
    pairs = pairs_within(x, np.ones(81), 1.5)
    valence = np.bincount(pairs.ravel(), minlength=81).reshape(9, 9)
    assert (valence[1:-1, 1:-1] == 6).all()
    assert (valence[[0, -1]] < 6).all()


def test_contact_is_the_sum_of_the_radii_and_drift_is_in_units_of_spacing():
    x, d = np.array([[0.0, 0.0], [1.0, 0.0]]), np.array([1.0, 0.5])
    near = Neighbours.of(x, d, 1.9)
    assert near.contact.tolist() == [0.75]
    assert near.drift(x) == 0
    assert near.drift(x + np.array([[0.1, 0.0], [0.0, 0.1]])) == pytest.approx(0.2)
    assert near.drift(x + np.array([[0.3, 0.0], [0.0, 0.1]])) == pytest.approx(0.3)


def test_neighbours_along_edges_are_these_pairs():
    x, d = hexagonal(4, 3), np.linspace(0.5, 1.5, 12)
    edges = np.array([[3, 1], [0, 5], [10, 11]])
    near = Neighbours.along(edges, x, d)
    assert near.pairs.tolist() == edges.tolist()
    assert near.contact.tolist() == [(d[i] + d[j]) / 2 for i, j in edges]
    assert near.drift(x) == 0


@given(st.data())
@settings(derandomize=True, deadline=None, max_examples=100)
def test_independent_choice_is_that_of_the_sequential_algorithm(data):
    n = data.draw(st.integers(1, 12))
    rank = np.array(data.draw(st.permutations(range(n))))
    members = st.integers(0, n - 1)
    found = data.draw(st.sets(st.tuples(members, members).filter(lambda pair: pair[0] < pair[1])))
    pairs = np.array(sorted(found), int).reshape(-1, 2)
    candidates = np.array(data.draw(st.lists(st.booleans(), min_size=n, max_size=n)))
    for some in (candidates, np.ones(n, bool)):
        assert maximal_independent_set(some, pairs, rank).tolist() == greedy(some, pairs.tolist(), rank)


def test_independent_choice_goes_along_a_chain_in_the_worst_order():
    pairs = np.column_stack([np.arange(50), np.arange(1, 51)])
    assert maximal_independent_set(np.ones(51, bool), pairs, np.arange(51)).tolist() == [k % 2 == 0 for k in range(51)]


def test_bubbles_of_all_sizes_around_fine_spots_take_memory_for_the_pairs_only():
    random = np.random.default_rng(3)
    size = np.repeat(2.0 ** np.arange(-24.0, -4.0, 0.5), 40)  # as many of each size, at distances in proportion
    angle = random.uniform(0, 2 * np.pi, len(size))
    ring = 2.5 * size[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    spots = random.random((15, 2))
    x, d = (spots[:, None] + ring).reshape(-1, 2), np.tile(size, 15)
    pairs_within(x[:10], d[:10], 1.9)  # what is loaded at first
    tracemalloc.start()
    pairs = pairs_within(x, d, 1.9)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 6 * pairs.nbytes
