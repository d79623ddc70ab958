import numpy as np
from metrics import random_tensors

from bubblemesh.meshes.tensors import of_axes
from bubblemesh.spacing.metric.field import TensorField

POINTS = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])
ALONG_X = np.tile([1.0, 0.0], (4, 1))


def test_at_the_nodes_the_tensors_are_those_given():
    tensors = random_tensors(np.random.default_rng(0), 4)
    found = TensorField.of(POINTS, TRIANGLES, tensors)(*POINTS.T).tensors
    np.testing.assert_allclose(found, tensors, rtol=1e-9, atol=1e-9 * np.abs(tensors).max())


def test_between_the_nodes_sizes_change_geometrically():
    across = np.array([0.01, 0.04, 0.04, 0.01])
    field = TensorField.of(POINTS, TRIANGLES, of_axes(across, np.full(4, 0.1), ALONG_X))
    found = field(np.array([0.5, 0.25]), np.array([0.2, 0.1]))
    np.testing.assert_allclose(found.across, [0.02, 0.01 * 4**0.25])
    np.testing.assert_allclose(found.along, 0.1)
    np.testing.assert_allclose(np.abs(found.direction), [[1, 0], [1, 0]], atol=1e-12)


def test_outside_the_mesh_the_nearest_point_counts():
    across = np.array([0.01, 0.04, 0.04, 0.01])
    field = TensorField.of(POINTS, TRIANGLES, of_axes(across, np.full(4, 0.1), ALONG_X))
    found = field(np.array([0.5, 3.0]), np.array([-1.0, 0.5]))
    np.testing.assert_allclose(found.across, [0.02, 0.04])
