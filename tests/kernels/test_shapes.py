import numpy as np
import pytest
from scipy.spatial import Delaunay
from twins import needs_compiler

from bubblemesh.kernels.shapes import Links, gradient, gradient_in_numpy

pytestmark = needs_compiler


@pytest.mark.parametrize("seed", range(6))
def test_both_engines_give_the_same_gradient_to_the_last_bit(seed):
    random = np.random.default_rng(seed)
    x = random.random((300, 2))
    x[7] = x[8]  # bubbles that coincide
    corners = Delaunay(random.random((300, 2))).simplices.T.astype(np.int64)  # many triangles are flat or inverted
    ends = np.ascontiguousarray(random.integers(0, 300, (2, 900)))
    d = random.uniform(0.02, 0.2, 300)
    links = Links(np.ascontiguousarray(corners), d, ends, d[ends].mean(axis=0))
    found = gradient(x, links, 7.0)
    assert found.tobytes() == gradient_in_numpy(x, links, 7.0).tobytes()
    assert np.isfinite(found).all()
    assert np.abs(found).min(axis=1).max() > 1
