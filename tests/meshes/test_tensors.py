import numpy as np
import pytest
from metrics import matrices, random_tensors

from bubblemesh.kernels.tensors import intersections, lengths, mapped, mean_lengths, roots, unmapped
from bubblemesh.meshes.tensors import area_sizes, axes, edge_lengths, of_axes, size_ratios, turned


@pytest.fixture
def some():
    random = np.random.default_rng(3)
    return random_tensors(random, 200), random.normal(size=(200, 2))


def test_lengths_are_those_of_the_matrices(some):
    tensors, vectors = some
    squared = np.einsum("ni,nij,nj->n", vectors, matrices(tensors), vectors)
    np.testing.assert_allclose(lengths(tensors, vectors), np.sqrt(squared), rtol=1e-12)


def test_a_root_turns_lengths_in_the_metric_into_plain_ones_and_back(some):
    tensors, vectors = some
    plain = mapped(roots(tensors), vectors)
    np.testing.assert_allclose(np.hypot(*plain.T), lengths(tensors, vectors), rtol=1e-10)
    np.testing.assert_allclose(unmapped(roots(tensors), plain), vectors, rtol=1e-8)


def test_axes_are_those_that_a_tensor_is_made_of(some):
    tensors, _ = some
    across, along, direction = axes(tensors)
    np.testing.assert_allclose(of_axes(across, along, direction), tensors, rtol=1e-8, atol=1e-8 * tensors.max())
    np.testing.assert_allclose(lengths(tensors, along[:, None] * direction), 1, rtol=1e-9)
    np.testing.assert_allclose(area_sizes(tensors), np.sqrt(across * along), rtol=1e-9)


def test_a_tensor_that_is_not_positive_has_no_size():
    assert np.isnan(area_sizes(np.array([[1.0, 2.0, 1.0], [-1.0, 0.0, -1.0], [np.nan, 0.0, 1.0]]))).all()


def test_an_intersection_is_within_both_ellipses_and_touches_them():
    random = np.random.default_rng(5)
    some, others = random_tensors(random, 100, 20), random_tensors(random, 100, 20)
    both = intersections(some, others)
    angle = np.linspace(0, np.pi, 721)
    around = np.column_stack([np.cos(angle), np.sin(angle)])
    for one, two, met in zip(some, others, both, strict=True):
        mine, other, found = (lengths(np.broadcast_to(m, (721, 3)), around) for m in (one, two, met))
        assert (found >= np.maximum(mine, other) * (1 - 1e-9)).all()
        assert (found / np.maximum(mine, other)).min() < 1.001
    np.testing.assert_allclose(np.linalg.det(matrices(intersections(some, some))), np.linalg.det(matrices(some)))


def test_the_ratio_of_sizes_is_the_largest_of_all_directions():
    random = np.random.default_rng(5)
    some, others = random_tensors(random, 100, 20), random_tensors(random, 100, 20)
    angle = np.linspace(0, np.pi, 7201)
    around = np.column_stack([np.cos(angle), np.sin(angle)])
    for one, two, ratio in zip(some, others, size_ratios(some, others), strict=True):
        mine, other = (lengths(np.broadcast_to(m, (len(angle), 3)), around) for m in (one, two))
        assert ratio == pytest.approx(max((mine / other).max(), (other / mine).max()), rel=1e-4)
    np.testing.assert_allclose(size_ratios(some, some), 1, rtol=1e-6)


def test_the_intersection_with_a_size_across_only_leaves_the_other_direction():
    circle = np.array([[100.0, 0.0, 100.0]])
    strip = of_axes(np.array([0.01]), np.array([1e100]), np.array([[0.6, 0.8]]))
    across, along, direction = axes(intersections(circle, strip))
    assert (across[0], along[0]) == (pytest.approx(0.01), pytest.approx(0.1))
    assert abs(direction[0] @ [0.6, 0.8]) == pytest.approx(1)


def test_the_mean_length_is_nearly_the_logarithmic_mean():
    ratio = np.geomspace(1.01, 15, 50)
    exact = (ratio - 1) / np.log(ratio)
    assert (np.abs(mean_lengths(np.ones(50), ratio) / exact - 1) < 0.02).all()
    assert mean_lengths(np.array([2.0]), np.array([2.0]))[0] == 2.0


def test_an_edge_in_one_metric_has_its_length_there():
    tensors = np.array([[4.0, 0.0, 1.0]] * 2)
    assert edge_lengths(np.array([[0.0, 0.0], [1.0, 0.0]]), tensors, np.array([[0, 1]]))[0] == pytest.approx(2)


def test_lengths_of_turned_vectors_in_turned_tensors_are_the_same(some):
    tensors, vectors = some
    angle = np.linspace(-4, 4, len(vectors))
    (x, y), c, s = vectors.T, np.cos(angle), np.sin(angle)
    there = lengths(turned(tensors, angle), np.column_stack([c * x - s * y, s * x + c * y]))
    np.testing.assert_allclose(there, lengths(tensors, vectors), rtol=1e-9)
    np.testing.assert_array_equal(turned(tensors, np.zeros(len(tensors))), tensors)
