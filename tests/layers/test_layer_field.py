"""The number of the layer that a triangle is in, among the fields of a mesh."""

import numpy as np
import pytest

from bubblemesh.case import load_case
from bubblemesh.run.pipeline import mesh_case

CASE = """
domain: {outer: {rectangle: [0, 0, 2, 1], labels: [floor, right, top, left]}}
spacing: 0.1
layers: [{on: floor, first: 0.01, growth: 1.5, count: 4}]
"""


def test_triangles_tell_the_layer_that_they_are_in():
    result = mesh_case(load_case("floor.yaml", text=CASE))
    layer, height = result.fields["layer"], result.mesh.points[result.mesh.triangles[:, :3], 1]
    tops = np.append(0, np.cumsum(0.01 * 1.5 ** np.arange(4)))
    assert set(layer) == {0, 1, 2, 3, 4}
    for k in range(1, 5):
        assert height[layer == k].min() == pytest.approx(tops[k - 1], abs=1e-12)
        assert height[layer == k].max() == pytest.approx(tops[k])
    assert height[layer == 0].min() == pytest.approx(tops[4])
