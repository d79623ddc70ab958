import numpy as np
import pytest

from bubblemesh.kernels.hilbert import along_hilbert_curve, hilbert_index, hilbert_index_in_numpy

pytestmark = pytest.mark.usefixtures("each_engine")


def grid(bits):
    """Cells (4**bits, 2) of a grid, row by row."""
    return np.stack(np.divmod(np.arange(4**bits), 2**bits), axis=1)


@pytest.mark.parametrize("bits", range(8))
def test_curve_visits_every_cell_once_with_steps_to_the_next_one(bits):
    cells = grid(bits)
    index = hilbert_index(cells, bits)
    assert sorted(index.tolist()) == list(range(4**bits))
    walk = cells[np.argsort(index)]
    assert (np.abs(np.diff(walk, axis=0)).sum(axis=1) == 1).all()


@pytest.mark.parametrize("bits", range(1, 7))
def test_index_of_a_cell_begins_with_that_of_the_larger_cell_around_it(bits):
    cells = grid(bits)
    np.testing.assert_array_equal(hilbert_index(cells, bits) >> 2, hilbert_index(cells >> 1, bits - 1))


def test_curve_fills_each_quarter_before_the_next():
    cells = grid(6)
    walk = cells[np.argsort(hilbert_index(cells, 6))]
    for size in (2, 4, 8, 16, 32):
        blocks = walk.reshape(-1, size * size, 2) // size
        assert (blocks == blocks[:, :1]).all()


def test_index_of_thirty_bits_does_not_overflow():
    rng = np.random.default_rng(0)
    cells = rng.integers(0, 2**30, (500, 2))
    index = hilbert_index(cells, 30)
    assert index.min() >= 0
    assert index.max() < 4**30
    np.testing.assert_array_equal(index >> 40, hilbert_index(cells >> 20, 10))


@pytest.mark.parametrize("n", [0, 1, 2, 1000])
def test_no_point_is_lost_or_doubled(n):
    points = np.random.default_rng(n).standard_normal((n, 2)) * [1.0, 1e-3]
    assert sorted(along_hilbert_curve(points).tolist()) == list(range(n))


def test_grid_of_points_is_met_in_the_order_of_its_cells():
    cells = grid(4)
    np.random.default_rng(0).shuffle(cells)
    walk = cells[along_hilbert_curve(0.1 * cells - 7.0)]
    assert (np.abs(np.diff(walk, axis=0)).sum(axis=1) == 1).all()


def test_points_in_one_place_keep_their_order():
    assert along_hilbert_curve(np.ones((5, 2))).tolist() == [0, 1, 2, 3, 4]
    assert along_hilbert_curve(np.array([[1.0, 1.0], [0.0, 0.0], [1.0, 1.0], [0.0, 0.0]])).tolist() == [1, 3, 0, 2]


def test_neighbours_on_the_curve_are_near_in_the_plane():
    points = np.random.default_rng(0).random((10_000, 2))
    walk = points[along_hilbert_curve(points)]
    steps = np.hypot(*np.diff(walk, axis=0).T)
    assert steps.mean() < 0.01  # the mean distance of random points is 0.52, that of a lattice's neighbours 0.0107
    assert steps.max() < 0.15


@pytest.mark.parametrize("scale", [2.0**-40, 2.0**40])
def test_order_does_not_depend_on_the_unit_of_length(scale):
    points = np.random.default_rng(0).random((1000, 2))
    np.testing.assert_array_equal(along_hilbert_curve(scale * points), along_hilbert_curve(points))


@pytest.mark.parametrize("bits", [0, 1, 2, 7, 20, 30])
def test_both_engines_give_the_same_index(bits):
    cells = np.random.default_rng(bits).integers(0, 2**bits, (3000, 2))
    np.testing.assert_array_equal(hilbert_index(cells, bits), hilbert_index_in_numpy(cells, bits))
