"""Domains with a metric, packed in parts."""

import pickle

import numpy as np
import pytest
from invariants import check_area, check_arrays, check_edges, check_facets_do_not_cross, check_labels, check_mesh
from metrics import metric_case

from bubblemesh.meshes.metric import MeasuresInMetric
from bubblemesh.parts.cuts import find_cuts
from bubblemesh.parts.division import cut_domain
from bubblemesh.problem.prepare import prepare
from bubblemesh.run.pipeline import mesh_case

SLOPE = "0.4*pi*cos(2*pi*x)"
FRONT = {
    "angle": f"atan2({SLOPE}, 1)",
    "across": f"0.002 + 0.2*abs(y - 0.5 - 0.2*sin(2*pi*x))/hypot(1, {SLOPE})",
}
LONG = {"angle": 0.5, "across": 0.006}
FULL = {
    "outer": {"rectangle": [0, 0, 1, 1], "labels": ["bottom", "right", "top", "left"]},
    "holes": [{"circle": {"center": [0.3, 0.3], "radius": 0.1}, "label": "hole"}],
    "regions": [{"name": "inner", "ring": {"circle": {"center": [0.7, 0.7], "radius": 0.15}}}],
    "lines": [{"path": [[0.1, 0.6], [0.4, 0.9]], "label": "crack"}],
    "points": [{"at": [0.6, 0.2], "label": "probe"}],
    "periodic": [["left", "right"]],
}


@pytest.mark.long
@pytest.mark.parametrize(("metric", "parts"), [(FRONT, 2), (FRONT, 4), (LONG, 3)])
def test_a_mesh_of_parts_is_as_good_in_the_metric_as_that_of_one_piece(metric, parts):
    one, many = (mesh_case(metric_case(metric, spacing=0.02, parts=count)) for count in (1, parts))
    check_mesh(many.mesh)
    assert many.report.parts.number == parts
    assert many.report.nodes == pytest.approx(one.report.nodes, rel=0.03)
    assert many.report.quality["mean"] > one.report.quality["mean"] - 0.006
    assert many.report.quality["p01"] > one.report.quality["p01"] - 0.06
    assert many.report.quality["min"] > 0.4
    assert many.report.metric.edges_within > one.report.metric.edges_within - 0.01
    assert many.report.rounds[0].quality_mean > 0.9  # those of parts are in the metric, too


def test_nodes_on_cuts_are_as_far_apart_as_the_metric_says_along_them():
    problem = prepare(metric_case(LONG, spacing=0.06))
    spacing = problem.packing_spacing
    cuts = find_cuts(problem.domain, spacing, problem.expected_nodes, 4)
    division = cut_domain(problem.domain, cuts, spacing, coarsened=False)
    held = division.held
    for piece in held.pieces.tolist():
        s = np.concatenate([[0.0], held.s[held.piece == piece], [division.boundary.lengths[piece]]])
        x = division.boundary.points(np.full(len(s), piece), s)
        d = spacing.between(x, np.column_stack([np.arange(len(s) - 1), np.arange(1, len(s))]))
        if len(d) > 3:
            np.testing.assert_allclose(np.hypot(*np.diff(x, axis=0).T) / d, 1, atol=0.2)


def test_no_line_shows_where_the_cuts_were():
    result = mesh_case(metric_case(LONG | {"across": 0.01}, spacing=0.05, parts=4))
    points, triangles = result.mesh.points, result.mesh.triangles
    tensors = np.column_stack([result.fields[f"metric_{entry}"] for entry in ("11", "12", "22")])
    q = MeasuresInMetric(points, triangles, tensors).radius_ratios
    centers = points[triangles].mean(axis=1)
    inner = ((centers > 0.05) & (centers < 0.95)).all(axis=1)
    assert q[inner].min() > 0.6
    assert q[inner].mean() > 0.985


@pytest.mark.long
def test_regions_lines_points_layers_and_periodic_sides_go_with_parts_in_a_metric():
    metric = [
        {"angle": "x + 2*y", "across": "0.008 + 0.01*x*(1 - x)"},
        {"like": "boundary", "label": "crack", "across": 0.004, "growth": 0.3},
    ]
    layers = [{"on": "hole", "first": 0.001, "growth": 1.3, "count": 4}]
    result = mesh_case(metric_case(metric, spacing=0.04, domain=FULL, layers=layers, parts=4))
    mesh = result.mesh
    for check in (check_arrays, check_edges, check_facets_do_not_cross, check_area, check_labels):
        check(mesh)
    assert {"inner", "domain"} <= set(mesh.regions)
    assert {"crack", "hole"} <= set(mesh.labels)
    assert mesh.points[mesh.labelled_nodes].tolist() == [[0.6, 0.2]]
    (sides,) = mesh.periodic_sides
    left, right = mesh.points[sides.nodes[:, 0]], mesh.points[sides.nodes[:, 1]]
    np.testing.assert_allclose(right - left, np.broadcast_to(sides.shift, left.shape), atol=1e-12)
    assert result.report.layers[0].complete == 1
    assert result.report.quality["mean"] > 0.95


def test_embedded_points_stay_where_layers_and_parts_go_together():
    keys = {"layers": [{"on": "hole", "first": 0.005, "growth": 1.3, "count": 4}], "parts": 3}
    mesh = mesh_case(metric_case(None, spacing=0.03, domain=FULL, **keys)).mesh
    check_edges(mesh)
    assert mesh.points[mesh.labelled_nodes].tolist() == [[0.6, 0.2]]


def test_spacings_in_a_metric_travel_to_other_processes():
    wall = {"like": "boundary", "label": "outer", "across": 0.01, "gradation": 0.5}
    problem = prepare(metric_case([LONG | {"across": 0.02}, wall | {"across": 0.03}], spacing=0.1))
    points = np.random.default_rng(1).uniform(0, 1, (50, 2))
    for spacing in (problem.spacing, problem.packing_spacing):
        np.testing.assert_array_equal(pickle.loads(pickle.dumps(spacing)).at(points), spacing.at(points))
