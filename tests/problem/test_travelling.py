"""Domains and spacings that travel to other processes are what they were."""

import pickle

import numpy as np
import pytest
from paths import ROOT
from sweeps import sweep

from bubblemesh.case import Case, load_case
from bubblemesh.problem.prepare import prepare

CASE = {
    "domain": {
        "outer": {"rectangle": [0, 0, 2, 1], "label": "wall"},
        "regions": [{"name": "A", "ring": {"circle": {"center": [1, 0.5], "radius": 0.2}}}],
    },
    "spacing": 0.2,
}
POINT = {"point": [1, 0.5], "size": 0.1, "growth": 0.2}
KEYS = {
    "value": {"spacing": "0.2 + 0.01*x"},
    "distance": {"spacing": '0.1 + 0.1*distance("wall")'},
    "near": {"spacing": {"near": [{"label": "wall", "size": 0.1}, POINT], "maximum": 0.2, "growth": 0.3}},
    "many points": {"spacing": {"near": [POINT | {"point": [x / 10, 0.5]} for x in range(20)], "maximum": 0.2}},
    "labels": {"spacing": {"labels": {"wall": 0.1}, "maximum": 0.2, "minimum": 0.01, "growth": 0.2}},
    "regions": {"spacing": {"value": 0.2, "regions": {"A": 0.1}}},
    "rules": {"spacing": {"value": 0.2, "per_circle": 20, "across": 2}},
    "nodes": {"spacing": {"value": 0.2, "nodes": 100}, "largest": 0.1},
    "largest": {"largest": 0.01},
    "metric": {"metric": {"across": 0.05, "along": 0.1, "angle": "x"}},
}


@pytest.mark.parametrize(
    "path", sweep(sorted(ROOT.glob("configs/gallery/*.yaml")), quick=4), ids=lambda path: path.stem
)
def test_what_packs_a_part_of_a_mesh_travels(path):
    require_same_elsewhere(prepare(load_case(path)))


@pytest.mark.parametrize("keys", KEYS.values(), ids=KEYS)
def test_spacings_of_all_keys_travel(keys):
    require_same_elsewhere(prepare(Case.model_validate(CASE | keys)))


def test_limits_of_regions_travel():
    """Areas of regions, as of a ``.poly`` file or a case, are spacings there that do not go with the rest."""
    (region,) = CASE["domain"]["regions"]
    domain = CASE["domain"] | {"regions": [region | {"largest": 0.004}]}
    require_same_elsewhere(prepare(Case.model_validate(CASE | {"domain": domain})))


def require_same_elsewhere(problem):
    sent = problem.domain, problem.packing_spacing, problem.method
    domain, spacing, method = pickle.loads(pickle.dumps(sent))
    x0, y0, x1, y1 = problem.domain.bounds
    points = np.random.default_rng(1).uniform([x0, y0], [x1, y1], (500, 2))
    np.testing.assert_array_equal(spacing.extended(points), problem.packing_spacing.extended(points))
    np.testing.assert_array_equal(domain.contains(points), problem.domain.contains(points))
    assert method == problem.method
