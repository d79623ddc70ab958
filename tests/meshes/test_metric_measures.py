from dataclasses import replace

import numpy as np
import pytest
from metrics import random_tensors
from squares import holed_square

from bubblemesh.meshes.metric import (
    ENTRIES,
    MeasuresInMetric,
    measures_of,
    node_tensors,
    spacing_along_edges,
    tensors_in,
)
from bubblemesh.meshes.quality import Measures

POINTS = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])


def fields(tensors):
    return dict(zip(ENTRIES, np.asarray(tensors, float).T, strict=True))


def test_a_metric_of_a_file_is_used_if_it_is_whole_and_positive():
    given = [[4.0, 0.5, 1.0], [1.0, 0.0, 9.0]]
    found = measures_of(POINTS, TRIANGLES, fields(given))
    assert isinstance(found, MeasuresInMetric)
    np.testing.assert_array_equal(found.tensors, given)
    for bad in ([[4.0, 5.0, 1.0], [1.0, 0.0, 9.0]], [[np.nan, 0.0, 1.0], [1.0, 0.0, 9.0]]):
        assert tensors_in(fields(bad)) is None
    assert type(measures_of(POINTS, TRIANGLES, {"metric_11": np.ones(2)})) is Measures


def test_the_quality_is_that_of_the_stretched_triangle():
    equilateral = np.array([[0.0, 0.0], [2.0, 0.0], [1.0, 3**0.5]]) * [5, 1]
    tensors = np.array([[1 / 25, 0.0, 1.0]])
    found = MeasuresInMetric(equilateral, np.array([[0, 1, 2]]), tensors)
    assert found.radius_ratios[0] == pytest.approx(1)
    assert found.angles.min() < 20


def test_the_spacing_along_an_edge_is_that_by_the_mean_length_in_its_triangles():
    measures = MeasuresInMetric(POINTS, TRIANGLES, np.array([[4.0, 0.0, 1.0], [16.0, 0.0, 9.0]]))
    spacing = dict(zip(map(tuple, measures.edges[0].tolist()), spacing_along_edges(measures), strict=True))
    assert spacing[0, 1] == pytest.approx(1 / 2)
    assert spacing[1, 2] == pytest.approx(1)
    assert spacing[0, 3] == pytest.approx(1 / 3)
    assert spacing[0, 2] == pytest.approx(2**0.5 / ((5**0.5 + 25**0.5) / 2))


def test_an_unused_node_has_no_ellipse():
    found = node_tensors(TRIANGLES, random_tensors(np.random.default_rng(0), 2, 5), 5)
    assert np.isnan(found[4]).all()
    assert np.isfinite(found[:4]).all()


def test_nodes_of_second_order_have_geometric_means_of_sizes():
    flat = holed_square(3)
    sizes = 10.0 ** (np.arange(len(flat.points)) % 2)
    tensors = np.column_stack([sizes**-2, 0 * sizes, sizes**-2])
    mesh, _ = replace(flat, metric=tensors).second_order()
    ends = sizes[mesh.triangles[:, [0, 1, 2]]] * sizes[mesh.triangles[:, [1, 2, 0]]]
    np.testing.assert_allclose(mesh.metric[mesh.triangles[:, 3:], 0], 1 / ends)
