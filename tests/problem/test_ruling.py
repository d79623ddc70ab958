"""What of a case sets the spacing at each place."""

import json

import numpy as np
import pytest

from bubblemesh.case import load_case
from bubblemesh.problem.prepare import prepare
from bubblemesh.problem.ruling import ruling

BASIN = {
    "outer": {"rectangle": [0, 0, 100, 40], "labels": ["south", "east", "north", "west"]},
    "lines": [{"path": [[75, 5], [75, 35]], "label": "line"}],
    "regions": [{"name": "spot", "ring": {"circle": {"center": [50, 20], "radius": 5}}, "spacing": 2.5}],
}


def rulers(spacing, places, domain=BASIN, **keys):
    problem = prepare(load_case("case.yaml", text=json.dumps({"domain": domain, "spacing": spacing} | keys)))
    return ruling(problem, np.array(places, float))


def test_terms_and_limits_are_called_by_their_keys():
    terms = {"value": "4 if x > 20 else 1", "near": {"label": "line", "size": 1.5, "growth": 0.2}}
    limits = {"minimum": 2, "maximum": 3}
    places = [(10, 20), (75.1, 20), (79, 20), (90, 20), (50, 20)]
    found = rulers(terms | limits, places)
    assert found == ["minimum", "minimum", "near", "maximum", "domain.regions.0.spacing"]


@pytest.mark.parametrize("size", [0.5, 1.5])
def test_near_and_labels_are_told_apart(size):
    near = {"near": {"label": "line", "size": size}, "labels": {"south": 0.5}}  # by one law, or by two
    places = [(75.1, 20), (10, 0.1), (75.1, 4), (40, 38)]
    assert rulers({"value": 4} | near, places) == ["near", "labels", "labels" if size > 1 else "near", "value"]


def test_terms_of_the_depth_are_told_apart():
    waves = {"depth": "10 + 0*x", "period": 2, "per_length": 10}  # sqrt(98.1) * 2 / 10, or 1.98
    slope = {"depth": "10 + 0.1*max(x - 80, 0)", "per_slope": 600, "filter": 2}  # 2 pi 10 / 60, or 1.05
    terms = {"value": 3, "near": {"point": [0, 20], "size": 0.5, "growth": 0.1}, "waves": waves, "slope": slope}
    places = [(3, 20), (50, 20), (90, 20)]
    assert rulers(terms, places, BASIN | {"regions": []}) == ["near", "waves", "slope"]
    courant = {"depth": "10 + 0*x", "dt": 0.15, "largest": 1}  # not below 1.49
    assert rulers(terms | {"courant": courant}, places, BASIN | {"regions": []}) == ["courant", "waves", "courant"]


def test_rules_and_the_boundary_are_named_where_they_make_it_finer():
    domain = {"outer": {"rectangle": [0, 0, 100, 40]}, "holes": [{"circle": {"center": [20, 20], "radius": 1}}]}
    places = [(21.1, 20), (60, 3), (80, 20)]
    steep = {"value": "8 if x < 70 else 1"}
    found = rulers(steep | {"growth": 0.2}, places, domain)
    assert found == ["growth", "growth", "value"]
    assert rulers("8 + 0*x", places, domain) == ["boundary", "spacing", "spacing"]


def test_the_growth_that_every_packing_has_is_no_boundary():
    domain, places = {"outer": {"rectangle": [0, 0, 10, 10]}}, [(5, 4.8), (5, 7), (5, 1)]
    steep = {"value": "0.1 if y > 5 else 0.5"}
    assert rulers(steep, places, domain) == ["growth", "value", "value"]
    assert rulers(steep | {"growth": 0.4}, places, domain) == ["growth", "value", "value"]


def test_periodic_sides_are_named_where_the_other_one_is_finer():
    domain = BASIN | {"periodic": [["east", "west"]], "regions": []}
    found = rulers({"value": "1 if x < 10 else 4"}, [(1, 20), (99.5, 20), (50, 20)], domain)
    assert found == ["value", "periodic", "value"]


@pytest.mark.parametrize("nodes", [2000, 20000])
def test_terms_are_named_at_any_scale(nodes):
    terms = {"value": 4, "near": {"label": "line", "size": 1}, "nodes": nodes}
    assert rulers(terms, [(75.1, 20), (5, 5)], BASIN | {"regions": []}) == ["near", "value"]
