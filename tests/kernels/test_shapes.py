import numpy as np
import pytest
from scipy.spatial import Delaunay
from twins import needs_compiler

from bubblemesh.kernels.shapes import Descent, eta, eta_in_numpy

pytestmark = needs_compiler


@pytest.mark.parametrize("seed", range(6))
def test_both_engines_go_the_same_steps_to_the_last_bit(seed):
    random = np.random.default_rng(seed)
    x, d = random.random((300, 2)), random.uniform(0.02, 0.2, 300)
    x[107] = x[108]  # bubbles that coincide
    triangles = Delaunay(random.random((300, 2))).simplices.astype(np.int64)  # many triangles are flat or inverted
    edges = random.integers(0, 300, (900, 2))
    scale = np.where(random.random(300) < 0.8, d * d, 0.0)
    most, weights = 0.1 * d, (7.0, 0.8, 0.015)
    counts = random.choice([1.0, 2.5], len(triangles))
    descent = Descent(triangles, counts, edges, d, scale, most, 9, 40, *weights)
    angles = random.uniform(0, 7, 40)
    tangents = np.column_stack([np.cos(angles), np.sin(angles)])
    found = descent.moved(x, tangents, 3)
    np.testing.assert_array_equal(found, descent.moved_in_numpy(x, tangents, 3))
    moved = found - x
    assert (moved != 0).any(axis=1).tolist() == ((np.arange(300) >= 9) & (scale > 0)).tolist()
    assert (np.hypot(*moved.T) < 0.1 * 3 * d * (1 + 1e-9)).all()
    assert np.abs(moved).max() > 0.01
    np.testing.assert_allclose(moved[9:49, 0] * tangents[:, 1], moved[9:49, 1] * tangents[:, 0], atol=1e-15)


@pytest.mark.parametrize("seed", range(6))
def test_both_engines_give_the_same_shape_measures_to_the_last_bit(seed):
    random = np.random.default_rng(seed)
    x = random.random((300, 2)) * 10.0 ** random.integers(-8, 8)
    x[7] = x[8]
    triangles = random.integers(0, 300, (900, 3))
    triangles[0] = 7, 8, 9
    found = eta(x, triangles)
    assert found.tobytes() == eta_in_numpy(x, triangles).tobytes()
    assert np.isinf(found[0])
    assert 300 < np.isinf(found).sum() < 600  # about half are inverted
    assert found.min() >= 1 - 1e-12


def test_shape_measures_of_columns_of_narrow_numbers_and_of_none():
    x = np.asfortranarray([[0, 0], [2, 0], [1, np.sqrt(3)], [9, 9]])
    triangles = np.array([[0, 1, 2, 3, 0, 1], [1, 2, 0, 1, 3, 2]], np.int32)[:, :3]
    np.testing.assert_allclose(eta(x, triangles), 1, rtol=1e-15)
    assert eta(x, triangles[:0]).shape == (0,)
