from itertools import product

import numpy as np
import pytest
from metrics import random_tensors
from scattered_points import SIDES, scattered
from sweeps import sweep
from twins import needs_compiler

from bubblemesh.kernels import grading
from bubblemesh.kernels.grading import grown, grown_in_numpy
from bubblemesh.kernels.tensors import lengths
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.meshes.triangulation import linked


def neighbours(triangles, count):
    """Where the neighbours of each node begin, and the neighbours."""
    edges, _ = unique_edges(triangles)
    pairs = np.concatenate([edges, edges[:, ::-1]])
    pairs = pairs[np.lexsort(pairs.T[::-1])]
    return np.append(0, np.cumsum(np.bincount(pairs[:, 0], minlength=count))), pairs[:, 1].copy()


@needs_compiler
@pytest.mark.parametrize(("growth", "seed"), sweep(product([0.0, 0.02, 0.5], range(4)), quick=5))
def test_both_engines_pass_tensors_on_alike(seed, growth):
    x = scattered(seed)
    begin, ends = neighbours(linked(x, SIDES)[0], len(x))
    tensors = random_tensors(np.random.default_rng(seed), len(x), 100)
    given = x, begin, ends, tensors, growth, 1e-3
    found = grown(*given)
    np.testing.assert_array_equal(found, grown_in_numpy(*given))
    assert (found != tensors).any()


@needs_compiler
def test_both_engines_pass_circles_on_alike():
    x = scattered(1)
    begin, ends = neighbours(linked(x, SIDES)[0], len(x))
    tensors = np.random.default_rng(1).uniform(1, 1e4, len(x))[:, None] * [1.0, 0.0, 1.0]
    given = x, begin, ends, tensors, 0.1, 1e-3
    np.testing.assert_array_equal(grown(*given), grown_in_numpy(*given))


@pytest.mark.parametrize("engine", [grown_in_numpy, pytest.param(grown, marks=needs_compiler)])
def test_there_are_no_more_sweeps_than_the_cap(engine, monkeypatch):
    monkeypatch.setattr(grading, "SWEEPS", 2)
    x = np.column_stack([np.arange(5.0), np.zeros(5)])
    begin, ends = np.array([0, 1, 3, 5, 7, 8]), np.array([1, 0, 2, 1, 3, 2, 4, 3])
    tensors = np.array([4.0, 1e-4, 1e-4, 1e-4, 1e-4])[:, None] * [1.0, 0.0, 1.0]
    found = engine(x, begin, ends, tensors, 0.5, 1e-3)
    np.testing.assert_array_equal(found[:, 0] > 1e-3, [True, True, True, False, False])


def test_a_tensor_is_passed_on_larger_by_the_growth_over_its_length():
    x, chain = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]), (np.array([0, 1, 3, 4]), np.array([1, 0, 2, 1]))
    circles = np.array([4.0, 1e-4, 1e-4])[:, None] * [1.0, 0.0, 1.0]
    found = grown(x, *chain, circles, 0.5, 1e-3)
    # A size of 0.5 grows to 0.5 (1 + 0.5 * 2) in a length of 2, and that by as much again in a length of 1.
    np.testing.assert_allclose(found, np.array([4.0, 1.0, 1 / 1.5**2])[:, None] * [1.0, 0.0, 1.0], atol=1e-12)
    np.testing.assert_allclose(lengths(found, np.tile([1.0, 0.0], (3, 1))), [2.0, 1.0, 1 / 1.5])
