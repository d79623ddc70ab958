"""Domains and spacings that travel to other processes are what they were."""

import pickle

import numpy as np
import pytest
from paths import ROOT

from bubblemesh.case import load_case
from bubblemesh.problem.prepare import prepare


@pytest.mark.parametrize("path", sorted(ROOT.glob("configs/gallery/*.yaml")), ids=lambda path: path.stem)
def test_what_packs_a_part_of_a_mesh_travels(path):
    problem = prepare(load_case(path))
    sent = problem.domain, problem.packing_spacing, problem.method
    domain, spacing, method = pickle.loads(pickle.dumps(sent))
    x0, y0, x1, y1 = problem.domain.bounds
    points = np.random.default_rng(1).uniform([x0, y0], [x1, y1], (500, 2))
    np.testing.assert_array_equal(spacing.extended(points), problem.packing_spacing.extended(points))
    np.testing.assert_array_equal(domain.contains(points), problem.domain.contains(points))
    assert method == problem.method
