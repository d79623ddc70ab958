from collections import Counter
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from bubblemesh.meshes.edges import (
    SideTable,
    directed_sides,
    find_sides,
    numbered_edges,
    one_sided,
    rim_nodes,
    unique_edges,
)


def random_triangles(seed, nodes=60):
    """Counter-clockwise triangles with holes, since some are missing."""
    random = np.random.default_rng(seed)
    triangles = Delaunay(random.random((nodes, 2))).simplices.astype(np.int64)
    return triangles[random.random(len(triangles)) < 0.8]


def reference_edges(triangles):
    return Counter(tuple(sorted(pair)) for i, j, k in triangles.tolist() for pair in pairwise((i, j, k, i)))


def reference_owners(triangles):
    """Triangle and number of each directed side."""
    return {
        pair: (number, side)
        for number, (i, j, k) in enumerate(triangles.tolist())
        for side, pair in enumerate(pairwise((i, j, k, i)))
    }


@pytest.mark.parametrize("seed", range(5))
def test_edges_agree_with_a_plain_loop(seed):
    triangles = random_triangles(seed)
    found, counts = unique_edges(triangles)
    expected = reference_edges(triangles)
    assert [tuple(edge) for edge in found.tolist()] == sorted(expected)
    assert counts.tolist() == [expected[edge] for edge in sorted(expected)]


def test_edges_of_32_bit_triangles_do_not_overflow():
    found, counts = unique_edges(np.array([[0, 99_999, 100_000]], dtype=np.int32))
    assert found.tolist() == [[0, 99_999], [0, 100_000], [99_999, 100_000]]
    assert counts.tolist() == [1, 1, 1]


@pytest.mark.parametrize("seed", range(5))
def test_the_sides_of_each_triangle_have_the_numbers_of_their_edges(seed):
    triangles = random_triangles(seed)
    edges, number = numbered_edges(triangles)
    np.testing.assert_array_equal(edges, unique_edges(triangles)[0])
    for triangle, own in zip(triangles.tolist(), number.tolist(), strict=True):
        assert [tuple(edges[k].tolist()) for k in own] == [
            tuple(sorted(pair)) for pair in pairwise((*triangle, triangle[0]))
        ]


@pytest.mark.parametrize("seed", range(5))
def test_sides_are_found_by_their_nodes(seed):
    triangles = random_triangles(seed)
    expected = reference_owners(triangles)
    pairs = np.random.default_rng(seed).integers(0, 60, (2000, 2))
    table = SideTable.of(triangles, 60)
    rows = table.find(pairs)
    owners = np.column_stack(table.owner(rows)).tolist()
    for pair, row, owner in zip(pairs.tolist(), rows.tolist(), owners, strict=True):
        assert (tuple(owner) if row >= 0 else None) == expected.get(tuple(pair))
    assert (rows >= 0).any()
    few = np.column_stack(find_sides(triangles, 60, pairs))
    assert [tuple(side) if side[0] >= 0 else None for side in few.tolist()] == [
        expected.get(tuple(pair)) for pair in pairs.tolist()
    ]
    assert [len(column) for column in find_sides(triangles, 60, pairs[:0])] == [0, 0]


@pytest.mark.parametrize("seed", range(5))
def test_the_opposite_of_a_side_runs_the_other_way_in_the_triangle_across(seed):
    triangles = random_triangles(seed)
    expected = reference_owners(triangles)
    table = SideTable.of(triangles, 60)
    for (i, j), row in zip(table.sides.tolist(), table.opposite().tolist(), strict=True):
        assert (tuple(table.sides[row].tolist()) if row >= 0 else None) == ((j, i) if (j, i) in expected else None)


@pytest.mark.parametrize("seed", range(5))
def test_the_rim_is_what_one_triangle_only_has(seed):
    triangles = random_triangles(seed)
    rim = [edge for edge, count in reference_edges(triangles).items() if count == 1]
    assert rim_nodes(triangles).tolist() == sorted({node for edge in rim for node in edge})
    sides = directed_sides(triangles)
    assert sorted(tuple(sorted(side)) for side in sides[one_sided(sides, 60)].tolist()) == sorted(rim)


@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5)).filter(lambda side: side[0] != side[1]), max_size=30))
def test_one_sided_sides_are_those_left_when_each_cancels_another(sides):
    left = Counter(sides)
    for i, j in list(left):
        both = min(left[i, j], left[j, i])
        left[i, j] -= both
        left[j, i] -= both
    found = np.array(sides, np.int64).reshape(-1, 2)[one_sided(np.array(sides, np.int64).reshape(-1, 2), 6)]
    assert Counter(map(tuple, found.tolist())) == +left


def test_one_sided_edges_of_triangles_that_overlap_begin_and_end_alike():
    sides = directed_sides(np.array([[0, 1, 2], [0, 1, 3], [1, 0, 4]]))
    left = sides[one_sided(sides, 5)]
    assert sorted(left.tolist()) == [[0, 1], [0, 4], [1, 2], [1, 3], [2, 0], [3, 0], [4, 1]]
    np.testing.assert_array_equal(np.sort(left[:, 0]), np.sort(left[:, 1]))
