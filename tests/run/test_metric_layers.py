"""Boundary layers beside a metric: the metric packs what they leave."""

import numpy as np
import pytest
from invariants import check_area, check_arrays, check_edges, check_facets_do_not_cross, check_labels
from metrics import metric_case

from bubblemesh.errors import CaseError
from bubblemesh.run.pipeline import mesh_case

SIDES = ["bottom", "right", "top", "left"]
CHANNEL = {"outer": {"rectangle": [0, 0, 2, 1], "labels": SIDES}}
FIVE = {"on": "bottom", "first": 0.002, "growth": 1.5, "count": 5}
TOP = 0.002 * float((1.5 ** np.arange(5)).sum())
ALONG_X = {"angle": 0, "across": 0.04, "along": 0.2}


def layered(metric, *layers, domain=CHANNEL, spacing=0.2, **keys):
    """Result of a case with layers, whose mesh is sound."""
    result = mesh_case(metric_case(metric, spacing=spacing, domain=domain, layers=list(layers), **keys))
    for invariant in (check_arrays, check_edges, check_facets_do_not_cross, check_area, check_labels):
        invariant(result.mesh)
    return result


def test_layers_stand_on_nodes_as_far_apart_as_the_metric_says_along_the_wall():
    result = layered(ALONG_X, FIVE)
    x, y = result.mesh.points.T
    assert ((y > 0) & (y < TOP - 1e-9)).any()
    np.testing.assert_allclose(np.unique(y[(y < TOP + 1e-9) & (x == 1)])[[1, -1]], [0.002, TOP])
    np.testing.assert_allclose(np.diff(np.unique(x[y == 0])), 0.2, rtol=1e-6)
    across = layered({**ALONG_X, "angle": "pi/2"}, FIVE)
    x, y = across.mesh.points.T
    np.testing.assert_allclose(np.diff(np.unique(x[y == 0])), 0.04, rtol=1e-6)


def test_the_report_tells_layers_and_the_packed_part_apart():
    result = layered(ALONG_X, FIVE)
    (row,) = result.report.layers
    assert (row.label, row.count["least"], row.complete) == ("bottom", 5, 1.0)
    assert result.report.quality["mean"] > 0.9  # though cells of the layers are flat in the metric, too
    assert result.fields["quality"].min() < 0.1
    in_layers = result.fields["layer"] > 0
    assert result.fields["quality"][~in_layers].mean() == pytest.approx(result.report.quality["mean"])
    assert result.report.metric.aspect == pytest.approx(5)
    assert result.report.nodes == pytest.approx(result.report.ideal_nodes + 5 * 11, rel=0.08)


def test_layers_end_where_they_are_as_high_as_the_metric_says_across_the_wall():
    wall = {"on": "bottom", "first": 0.002, "growth": 1.4, "until": "isotropic"}
    tops = []
    # The last one is finer along the wall: layers go on until they are four times as high as wide.
    for metric, across in (
        ({"angle": 0, "across": 0.01}, 0.01),
        ({"angle": 0, "across": 0.04}, 0.04),
        ({"m11": 400, "m22": 25}, 0.2),
    ):
        result = layered(metric, wall)
        y = result.mesh.points[np.unique(result.mesh.triangles[result.fields["layer"] > 0]), 1]
        heights = np.diff(np.unique(np.round(y, 12)))
        assert across / 1.4 < heights[-1] <= across
        assert 0.7 < result.report.layers[0].across_front < 1.5
        tops.append(y.max())
    assert tops == sorted(tops)


def test_a_front_with_shorter_edges_than_the_metric_asks_has_smaller_triangles_beside_it():
    disc = {"outer": {"circle": {"center": [0, 0], "radius": 1}, "label": "wall"}}
    layers = {"on": "wall", "first": 0.1, "growth": 1.0, "count": 5}
    result = layered({"angle": 0.3, "across": 0.1}, layers, domain=disc)
    assert result.report.layers[0].complete == 1
    assert result.report.quality["angle_min"] > 18  # in space: ellipses beside it are shorter along, too


def test_a_short_front_edge_along_the_short_axis_of_ellipses_leaves_their_long_axis_in_proportion():
    """As in a corner of two walls, whose column leans; an axis as short as the edge would make flat triangles."""
    domain = {"outer": {"rectangle": [0, 0, 0.8, 0.4], "labels": ["wall", "wall", "top", "left"]}}
    layers = {"on": "wall", "first": 0.002, "count": 5}
    quality = layered({"m11": 100, "m22": 2500}, layers, domain=domain).report.quality
    assert quality["mean"] > 0.97
    assert quality["p01"] > 0.7


def test_on_fronts_there_are_nodes_where_the_metric_is_finer_along_them():
    fine = {"m11": "1/min(0.2, 0.01 + 0.5*abs(y - 0.3))**2", "m22": 25}
    result = layered(fine, {**FIVE, "first": 0.02, "count": 6}, spacing=0.2)
    assert result.report.quality["mean"] > 0.8


def test_a_first_layer_higher_than_the_metric_is_across_the_wall_is_refused():
    with pytest.raises(CaseError, match=r"layers.0: the first layer, 0.05 high, is higher than the spacing"):
        layered(ALONG_X, {"on": "bottom", "first": 0.05, "count": 2})
    layered({**ALONG_X, "angle": "pi/2"}, {"on": "bottom", "first": 0.05, "count": 2})


def test_layers_of_periodic_sides_and_of_curved_walls_match_beside_a_metric():
    domain = {**CHANNEL, "periodic": [["left", "right"]], "holes": [{"circle": {"center": [1, 0.6], "radius": 0.2}}]}
    domain["holes"][0]["label"] = "hole"
    around = {"on": "hole", "first": 0.004, "growth": 1.4, "count": 4, "cells": "quads"}
    result = layered({"angle": "0.5*x*(2 - x)", "across": 0.05}, FIVE, around, domain=domain)
    (sides,) = result.mesh.periodic_sides
    left, right = (result.mesh.points[sides.nodes[:, k]] for k in (0, 1))
    np.testing.assert_allclose(right - left, np.broadcast_to(sides.shift, left.shape), atol=1e-12)
    assert {row.label for row in result.report.layers} == {"bottom", "hole"}
    assert len(result.mesh.quads) > 20
