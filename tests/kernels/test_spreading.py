import numpy as np
import pytest
from quadtrees import balanced
from twins import needs_compiler

from bubblemesh.kernels.spreading import spread, spread_in_numpy
from bubblemesh.spacing.grid.quadtree import Quadtree

pytestmark = needs_compiler


def cells(seed):
    """Corners and sides of the cells of a random quadtree, and the number of its vertices."""
    random = np.random.default_rng(seed)
    grid = Quadtree.around((0, 0, 1, 1))
    for _ in range(7):
        grid, _, _ = grid.split(random.random(len(grid)) < 0.55)
    grid = balanced(grid)
    return grid.vertices.corners, grid.sides, len(grid.vertices.key)


@pytest.mark.parametrize("seed", range(8))
def test_both_engines_spread_the_same_values_to_the_last_bit(seed):
    corners, sides, count = cells(seed)
    random = np.random.default_rng(seed + 100)
    values = np.where(random.random(count) < 0.1, random.uniform(0.01, 1, count), np.inf)
    some = random.random(len(corners)) < 0.9
    corners, rise = corners[some], 0.3 * sides[some]
    compiled = spread(corners, rise, values, 1e-6)
    assert compiled.tobytes() == spread_in_numpy(corners, rise, values, 1e-6).tobytes()
    assert (compiled <= values).all()
    assert (compiled < values).sum() > count // 4


def test_no_cells_change_nothing():
    values = np.array([1.0, np.inf])
    assert spread(np.zeros((0, 4), np.int64), np.zeros(0), values, 1e-6).tobytes() == values.tobytes()
