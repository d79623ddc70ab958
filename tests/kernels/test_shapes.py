import numpy as np
import pytest
from scipy.spatial import Delaunay
from twins import needs_compiler

from bubblemesh.kernels.shapes import Links, eta, eta_in_numpy, gradient, gradient_in_numpy

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
