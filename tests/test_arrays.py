import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from bubblemesh.arrays import (
    complement,
    components,
    different_rows,
    gathered,
    median,
    members,
    pairs_of_groups,
    quantile,
    taken,
)


@given(st.lists(st.integers(0, 5)))
def test_members_of_groups_one_after_the_other(counts):
    group, rank = members(np.array(counts, np.int64))
    assert list(zip(group, rank, strict=True)) == [(k, r) for k, count in enumerate(counts) for r in range(count)]


@given(st.lists(st.integers(0, 5)))
def test_pairs_of_groups_are_all_that_have_equal_numbers(groups):
    one, other = pairs_of_groups(np.array(groups, np.int64))
    expected = [(i, j) for i, a in enumerate(groups) for j, b in enumerate(groups) if a == b]
    assert list(zip(one, other, strict=True)) == expected


@pytest.mark.parametrize(("count", "links"), [(1, 0), (6, 3), (500, 300), (500, 2000)])
def test_components_are_those_of_scipy(count, links):
    pairs = np.random.default_rng(count).integers(0, count, (links, 2))
    matrix = coo_array((np.ones(links), tuple(pairs.T)), shape=(count, count))
    np.testing.assert_array_equal(components(pairs, count), connected_components(matrix, directed=False)[1])


def test_a_long_chain_is_one_component():
    order = np.random.default_rng(0).permutation(20_000)
    assert components(np.column_stack([order[:-1], order[1:]]), len(order)).max() == 0


@pytest.mark.parametrize("count", [1, 2, 7, 8])
def test_median_is_that_of_numpy(count):
    numbers = np.random.default_rng(count).normal(size=count)
    assert median(numbers) == np.median(numbers)


@pytest.mark.parametrize("share", [0.0, 0.01, 0.3, 0.99, 1.0])
@pytest.mark.parametrize("count", [1, 2, 7, 100])
def test_quantile_is_that_of_numpy(count, share):
    numbers = np.random.default_rng(3).random(count)
    assert quantile(numbers, share) == np.quantile(numbers, share)


@given(st.lists(st.tuples(st.integers(-2, 2), st.integers(-2, 2))))
def test_different_rows_are_those_of_numpy(rows):
    points = np.array(rows, float).reshape(-1, 2)
    for mine, known in zip(different_rows(points), np.unique(points, axis=0, return_inverse=True), strict=True):
        np.testing.assert_array_equal(mine, known.reshape(mine.shape))


@pytest.mark.parametrize("rows", [0, 1, 7])
def test_gathered_points_are_those_of_an_index_with_whole_columns(rows):
    random = np.random.default_rng(rows)
    points, which = random.random((9, 2)), random.integers(0, 9, (rows, 3))
    found = gathered(points, which)
    np.testing.assert_array_equal(found, points[which])
    assert all(found[:, corner, axis].flags.c_contiguous for corner in range(3) for axis in range(2))


@pytest.mark.parametrize("shape", [(9,), (9, 2), (9, 2, 3)])
@pytest.mark.parametrize("which", [[], [4, 4, -1, 0], [[8, 1], [3, 3]]])
def test_rows_are_taken_as_by_an_index(shape, which):
    table, numbers = np.arange(np.prod(shape)).reshape(shape), np.array(which, np.int64)
    np.testing.assert_array_equal(taken(table, numbers), table[numbers])
    some = np.isin(np.arange(9), numbers)
    np.testing.assert_array_equal(taken(table, some), table[some])


@given(st.integers(0, 8), st.lists(st.integers(-2, 10)))
def test_the_complement_is_the_numbers_up_to_a_count_that_are_not_among_some(count, numbers):
    assert complement(count, np.array(numbers, np.int64)).tolist() == sorted({*range(count)} - {*numbers})
