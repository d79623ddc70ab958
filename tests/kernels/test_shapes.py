import numpy as np
import pytest
from scipy.spatial import Delaunay
from twins import needs_compiler

from bubblemesh.kernels.shapes import Descent

pytestmark = needs_compiler


@pytest.mark.parametrize("seed", range(6))
def test_both_engines_go_the_same_steps_to_the_last_bit(seed):
    random = np.random.default_rng(seed)
    x, d = random.random((300, 2)), random.uniform(0.02, 0.2, 300)
    x[107] = x[108]  # bubbles that coincide
    corners = Delaunay(random.random((300, 2))).simplices.T.astype(np.int64)  # many triangles are flat or inverted
    ends = np.ascontiguousarray(random.integers(0, 300, (2, 900)))
    scale = np.where(random.random(300) < 0.8, d * d, 0.0)
    descent = Descent(np.ascontiguousarray(corners), d, ends, d[ends].mean(axis=0), scale, 0.1 * d, 9, 7.0, 0.8, 0.015)
    angles = random.uniform(0, 7, 40)
    tangents = np.column_stack([np.cos(angles), np.sin(angles)])
    found, plain = ((x.copy(), np.zeros_like(x)) for _ in range(2))
    for _ in range(3):
        descent(*found, tangents)
        descent.in_numpy(*plain, tangents)
    moved = found[0] - x
    np.testing.assert_array_equal(found, plain)
    assert (moved != 0).any(axis=1).tolist() == ((np.arange(300) >= 9) & (scale > 0)).tolist()
    assert (np.hypot(*moved.T) < 0.1 * 3 * d * (1 + 1e-9)).all()
    assert np.abs(moved).max() > 0.01
    np.testing.assert_allclose(moved[9:49, 0] * tangents[:, 1], moved[9:49, 1] * tangents[:, 0], atol=1e-15)
