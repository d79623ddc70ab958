"""The metric of a solution, and meshes adapted by it."""

import json
from dataclasses import replace

import meshio
import numpy as np
import pytest
from invariants import check_edges, check_mesh
from sweeps import sweep
from typer.testing import CliRunner

import bubblemesh
from bubblemesh.adaptivity.metric import (
    area_in,
    best_metric,
    graded_across_sides,
    hessians,
    intersected_across_sides,
    scaled_for,
)
from bubblemesh.cli import app
from bubblemesh.errors import CaseError, LimitError
from bubblemesh.layers.pipeline import HighLayerError
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.meshes.tensors import axes
from bubblemesh.problem.domain import case_domain
from bubblemesh.problem.layers import ladders_of, left_out
from bubblemesh.problem.prepare import prepare_for
from bubblemesh.problem.spacing import case_spacing
from bubblemesh.problem.task import task_of
from bubblemesh.process.stopwatch import Stopwatch

FAST = "packing: {effort: fast}\n"
CASE = f"name: a\ndomain: {{outer: {{rectangle: [0, 0, 1, 1]}}}}\nspacing: 0.06\n{FAST}"


@pytest.fixture(scope="module")
def mesh():
    return bubblemesh.mesh_case(bubblemesh.load_case("-", text=CASE)).mesh


@pytest.fixture(scope="module")
def case():
    return bubblemesh.load_case("-", text=CASE)


def layer(x, y):
    return np.tanh((y - 0.5 - 0.2 * np.sin(2 * np.pi * x)) / 0.05)


def test_the_recovered_hessian_of_a_quadratic_function_is_exact_inside(mesh):
    x, y = mesh.points.T
    found = hessians(mesh.points, mesh.triangles, np.column_stack([x * x - 3 * x * y, 2 * y * y + x]))
    inside = (np.abs(mesh.points - 0.5) < 0.3).all(axis=1)
    assert inside.sum() > 50
    np.testing.assert_allclose(found[inside, 0], np.tile([2, -3, 0], (inside.sum(), 1)), atol=0.3)
    np.testing.assert_allclose(found[inside, 1], np.tile([0, 0, 4], (inside.sum(), 1)), atol=0.3)
    assert np.abs(np.median(found[inside, 0], axis=0) - [2, -3, 0]).max() < 0.05


def test_ellipses_are_as_long_as_the_root_of_the_second_derivatives_says(mesh):
    x, y = mesh.points.T
    inside = (np.abs(mesh.points - 0.5) < 0.3).all(axis=1)
    tensors = best_metric(mesh.points, mesh.triangles, (x * x + 100 * y * y)[:, None])
    found = axes(tensors[inside])
    assert np.median(found.aspects) == pytest.approx(10, rel=0.1)
    assert np.median(np.abs(found.direction[:, 0])) > 0.99
    both = best_metric(mesh.points, mesh.triangles, np.column_stack([x * x + 100 * y * y, 100 * x * x + y * y]))
    assert np.median(axes(both[inside]).aspects) < 1.2


NOTHING = {
    "zero": lambda x, y: 0 * x,
    "linear": lambda x, y: 3 * x - 2 * y,
    "rounding": lambda x, y: 1e-14 * np.sin(1e4 * x * y),
    "small": lambda x, y: 1e-6 * x * y,
}


@pytest.mark.parametrize("other", NOTHING.values(), ids=NOTHING)
def test_components_that_hardly_bend_ask_for_nothing(mesh, other):
    x, y = mesh.points.T
    one = best_metric(mesh.points, mesh.triangles, layer(x, y)[:, None])
    both = best_metric(mesh.points, mesh.triangles, np.column_stack([layer(x, y), other(x, y), 0 * x]))
    found, expected = axes(both), axes(one)
    steep = expected.across < np.median(expected.across)
    np.testing.assert_allclose(found.across[steep], expected.across[steep], rtol=0.02)
    assert np.median(np.abs(found.along / expected.along - 1)[steep]) < 0.05


def test_a_linear_solution_asks_for_circles_of_one_size(mesh):
    x, y = mesh.points.T
    found = axes(best_metric(mesh.points, mesh.triangles, (2 * x - 3 * y)[:, None]))
    assert found.aspects.max() < 1 + 1e-9
    assert np.ptp(found.along) < 1e-9 * found.along.max()


def test_a_number_of_nodes_that_cannot_be_had_is_refused(mesh, case):
    solution = bubblemesh.Solution.of(mesh.points, mesh.triangles, layer(*mesh.points.T))
    with pytest.raises(LimitError, match=r"nodes: 4 nodes are too few: .* need at least about"):
        bubblemesh.adapt(case, solution, anisotropic=True, nodes=4)


@pytest.mark.long
def test_an_error_that_one_step_does_not_reach_is_told(case):
    coarse = bubblemesh.mesh_case(bubblemesh.load_case("-", text=CASE.replace("0.06", "0.15"))).mesh
    solution = bubblemesh.Solution.of(coarse.points, coarse.triangles, layer(*coarse.points.T))
    result = bubblemesh.adapt(case, solution, anisotropic=True, error=1e-6)
    assert any(
        text.startswith("an error of 1e-06 is asked for, and 0.") and "one step gives 16 times as many nodes" in text
        for text in result.report["warnings"]
    )


@pytest.mark.parametrize(
    ("function", "error"),
    sweep([(lambda x, y: x * x + y * y, 0.2), (lambda x, y: 2 * x - 3 * y, 0.05), (lambda x, y: 0 * x, 0.05)], quick=1),
)
def test_an_error_that_the_coarsest_mesh_does_not_have_leads_to_that(mesh, case, function, error, recwarn):
    solution = bubblemesh.Solution.of(mesh.points, mesh.triangles, function(*mesh.points.T))
    result = bubblemesh.adapt(case, solution, anisotropic=True, error=error)
    check_mesh(result.mesh)
    assert len(result.mesh.points) < 60
    assert result.report["quality"]["min"] > 0.8
    assert not recwarn.list


def test_methods_of_circles_are_refused(mesh):
    case = bubblemesh.load_case("-", text=CASE.replace(FAST, "method: bpm\n"))
    solution = bubblemesh.Solution.of(mesh.points, mesh.triangles, layer(*mesh.points.T))
    with pytest.raises(CaseError, match=r"method: bpm packs no metric: leave method out with anisotropic$"):
        bubblemesh.adapt(case, solution, anisotropic=True, nodes=300)


def test_a_metric_is_scaled_for_a_number_of_nodes_within_limits(mesh):
    x, y = mesh.points.T
    best = best_metric(mesh.points, mesh.triangles, layer(x, y)[:, None])
    tensors = scaled_for(mesh.points, mesh.triangles, best, 1000, (0.004, 0.1), 12.0)
    assert area_in(mesh.points, mesh.triangles, tensors) == pytest.approx(1000 * np.sqrt(3) / 2, rel=1e-3)
    found = axes(tensors)
    assert found.across.min() > 0.004 * (1 - 1e-6)
    assert found.along.max() < 0.1 * (1 + 1e-6)
    assert found.aspects.max() < 12 * (1 + 1e-6)


@pytest.mark.parametrize("target", sweep([{"nodes": 500}, {"error": 0.3}], quick=1))
def test_a_mesh_adapted_by_a_metric_follows_the_layer(mesh, case, target):
    solution = bubblemesh.Solution.of(mesh.points, mesh.triangles, layer(*mesh.points.T))
    result = bubblemesh.adapt(case, solution, anisotropic=True, **target)
    check_mesh(result.mesh)
    report = result.report
    assert report.method == "ellipses"
    assert report["adaptation"]["anisotropic"]
    assert report.metric.aspect > 3
    assert report.quality["mean"] > 0.95
    if "nodes" in target:
        assert report.nodes == pytest.approx(500, rel=0.05)
    middles = result.mesh.points[unique_edges(result.mesh.triangles)[0]].mean(axis=1)
    near = np.abs(middles[:, 1] - 0.5 - 0.2 * np.sin(2 * np.pi * middles[:, 0])) < 0.1
    assert near.mean() > 0.4  # of 0.2 of the area


@pytest.mark.long
def test_the_loop_lowers_the_interpolation_error_more_than_without_direction(mesh, case):
    error = {}
    for anisotropic in (False, True):
        now = mesh
        for _ in range(3):
            solution = bubblemesh.Solution.of(now.points, now.triangles, layer(*now.points.T))
            now = bubblemesh.adapt(case, solution, nodes=600, anisotropic=anisotropic).mesh
        corners = now.points[now.triangles]
        u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        areas = (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / 2
        shares = np.array([[2, 2, 2], [4, 1, 1], [1, 4, 1], [1, 1, 4]]) / 6
        places = np.einsum("qk,tkd->qtd", shares, corners)
        there = np.einsum("qk,tk->qt", shares, layer(corners[..., 0], corners[..., 1]))
        error[anisotropic] = np.sqrt(((there - layer(places[..., 0], places[..., 1])) ** 2).mean(axis=0) @ areas)
    assert error[True] < 0.5 * error[False]


SQUARE = """
name: a
domain: {{outer: {{rectangle: [0, 0, 1, 1], labels: [b, r, t, l]}}{more}}}
spacing: 0.06
packing: {{effort: fast}}
"""
PERIODIC = SQUARE.format(more=", periodic: [[l, r], [b, t]]")
LAYERS = SQUARE.format(more="") + "layers: [{on: b, first: 0.001, until: isotropic}]\n"


@pytest.mark.long
@pytest.mark.parametrize("text", [PERIODIC, LAYERS], ids=["periodic sides", "layers"])
def test_a_requested_number_of_nodes_is_met_by_what_is_made(mesh, text):
    solution = bubblemesh.Solution.of(mesh.points, mesh.triangles, layer(*mesh.points.T))
    result = bubblemesh.adapt(bubblemesh.load_case("-", text=text), solution, anisotropic=True, nodes=700)
    check_edges(result.mesh)
    assert result.report.nodes == pytest.approx(700, rel=0.02)


@pytest.mark.long
def test_ellipses_are_longer_than_a_thin_strip_is_wide_where_else_there_would_be_too_many():
    case = bubblemesh.load_case("-", text=CASE.replace("[0, 0, 1, 1]", "[0, 0, 4, 0.1]"))
    mesh = bubblemesh.mesh_case(case).mesh
    solution = bubblemesh.Solution.of(mesh.points, mesh.triangles, np.tanh(60 * (mesh.points[:, 0] - 2)))
    report = bubblemesh.adapt(case, solution, nodes=60, anisotropic=True).report
    assert report.nodes == pytest.approx(60, abs=3)


TOO_HIGH = SQUARE.format(more="") + "layers: [{on: b, first: 0.3, count: 1}]\n"


def test_a_spacing_of_a_solution_leaves_out_layers_for_which_it_is_too_fine():
    case = bubblemesh.load_case("-", text=TOO_HIGH)
    domain = case_domain(case)
    request, task = case_spacing(case, domain), task_of(case, domain)
    with pytest.raises(HighLayerError, match=r"layers\.0: the first layer, 0\.3 high, is higher .* across these walls"):
        prepare_for(case, domain, request, task, Stopwatch())
    problem = prepare_for(case, domain, request, replace(task, adapted=True), Stopwatch())
    assert problem.rest is None
    assert any("less than the first layer, 0.3: these layers are left out" in text for text in problem.warnings)


@pytest.mark.long
@pytest.mark.parametrize("anisotropic", [False, True])
def test_layers_that_are_too_high_for_the_sizes_of_a_solution_are_left_out_and_told(mesh, anisotropic):
    case = bubblemesh.load_case("-", text=TOO_HIGH)
    solution = bubblemesh.Solution.of(mesh.points, mesh.triangles, layer(*mesh.points.T))
    report = bubblemesh.adapt(case, solution, nodes=100, anisotropic=anisotropic).report
    assert report.layers is None
    (told,) = (text for text in report.warnings if text.startswith("layers.0: "))
    assert "less than the first layer, 0.3: these layers are left out" in told
    assert report.nodes == pytest.approx(100, abs=5)


def test_a_counterpart_of_layers_that_are_left_out_has_none_either():
    entries = [
        "{on: b, first: 0.02, count: 1}",
        "{on: t, first: 0.02, count: 1}",
        "{on: [l, r], first: 0.02, count: 1}",
    ]
    text = PERIODIC + f"layers: [{', '.join(entries)}]\n"
    case = bubblemesh.load_case("-", text=text)
    domain = case_domain(case)
    _, above, beside = ladders = ladders_of(case.layers, domain)
    error = HighLayerError()
    error.ladder, error.spacing = above, 0.01
    assert left_out(error, domain, ladders)[0] == (beside,)


@pytest.mark.long
def test_a_metric_of_a_solution_goes_on_across_periodic_sides(mesh):
    case = bubblemesh.load_case("-", text=PERIODIC)
    x, y = mesh.points.T
    solution = bubblemesh.Solution.of(mesh.points, mesh.triangles, np.tanh(10 * np.sin(2 * np.pi * (x + y))))
    once = bubblemesh.adapt(case, solution, anisotropic=True, nodes=800)
    assert not any("periodic sides" in text for text in once.report["warnings"])
    assert once.report["metric"]["edges_within"] > 0.93


def test_the_metric_of_a_solution_is_the_finer_one_of_both_periodic_sides(mesh):
    case = bubblemesh.load_case("-", text=PERIODIC)
    x, y = mesh.points.T
    tensors = np.tile([1.0, 0.0, 1.0], (len(x), 1))
    tensors[x == 0] = 100.0, 0.0, 4.0
    tensors[x == 1] = 9.0, 0.0, 25.0
    found = intersected_across_sides(case_domain(case), mesh.points, mesh.triangles, tensors)
    inner = (y > 0.2) & (y < 0.8)
    for side in (0, 1):
        np.testing.assert_allclose(
            found[inner & (x == side)], [[100.0, 0.0, 25.0]] * (inner & (x == side)).sum(), atol=1e-9
        )
    inside = (x > 0) & (x < 1) & (y > 0) & (y < 1)
    np.testing.assert_array_equal(found[inside], tensors[inside])


def test_the_metric_of_the_other_side_is_turned_as_the_side_is(mesh):
    domain = case_domain(bubblemesh.load_case("-", text=SQUARE.format(more=", periodic: [[b, l]]")))
    x, y = mesh.points.T
    tensors = np.tile([1.0, 0.0, 1.0], (len(x), 1))
    tensors[y == 0] = 100.0, 3.0, 4.0
    found = intersected_across_sides(domain, mesh.points, mesh.triangles, tensors)
    inner = (x == 0) & (y > 0.2) & (y < 0.8)
    np.testing.assert_allclose(found[inner], [[4.0, -3.0, 100.0]] * inner.sum(), atol=1e-9)


def test_what_is_fine_at_a_corner_is_so_at_all_of_its_copies_and_sizes_grow_from_each(mesh):
    domain = case_domain(bubblemesh.load_case("-", text=PERIODIC))
    tensors = np.tile([1.0, 0.0, 1.0], (len(mesh.points), 1))
    tensors[np.hypot(*mesh.points.T).argmin()] = 2500.0, 0.0, 10000.0
    found = graded_across_sides(domain, mesh.points, mesh.triangles, tensors, 0.3)
    near = [np.hypot(*(mesh.points - corner).T) for corner in ((0, 0), (1, 0), (1, 1), (0, 1))]
    at = np.array([found[distance.argmin()] for distance in near])
    np.testing.assert_allclose(at[:, 0], 2500, rtol=0.03)
    np.testing.assert_allclose(at[:, 2], 10000, rtol=0.03)
    across = axes(found).across
    beside = [across[(distance > 0.05) & (distance < 0.15)].mean() for distance in near]
    assert max(beside) < 1.2 * min(beside) < 0.1


def test_a_case_with_a_metric_of_its_own_is_refused(mesh):
    case = bubblemesh.load_case("-", text=CASE + "metric: {angle: 0, across: 0.01}\n")
    solution = bubblemesh.Solution.of(mesh.points, mesh.triangles, layer(*mesh.points.T))
    with pytest.raises(CaseError, match="metric: remove `metric` from the case"):
        bubblemesh.adapt(case, solution, nodes=300)


@pytest.mark.long
def test_regions_are_adapted_each_by_its_own_derivatives(tmp_path):
    text = CASE + "output: {formats: [vtu]}\n"
    text = text.replace("}}\n", "}, regions: [{name: east, ring: {rectangle: [0.5, 0, 1, 1]}}]}\n", 1)
    path = tmp_path / "a.yaml"
    path.write_text(text)
    case = bubblemesh.load_case(path)
    mesh = bubblemesh.mesh_case(case).mesh
    x, y = mesh.points.T  # the solution is linear in the east, and has a kink
    bubblemesh_solution = tmp_path / "solution.vtu"
    points = np.column_stack([mesh.points, 0 * x])
    data = {"u": np.where(x < 0.5, (x - 0.5) * layer(x, y), 0.5 - x)}
    meshio.write(bubblemesh_solution, meshio.Mesh(points, [("triangle", mesh.triangles)], point_data=data))
    given = ["adapt", str(path), "--solution", str(bubblemesh_solution), "--nodes", "500", "--anisotropic", "-q"]
    done = CliRunner().invoke(app, [*given, "-o", str(tmp_path / "next")])
    assert done.exit_code == 0, done.output
    found = bubblemesh.Mesh.read(tmp_path / "next" / "a.vtu")
    assert set(found.regions) == {"domain", "east"}
    assert len(found.points) == pytest.approx(500, rel=0.08)
    report = json.loads((tmp_path / "next" / "a.report.json").read_text())
    assert report["metric"]["steepest"] < 3  # sizes grow from the west into the east
    assert report["quality"]["min"] > 0.65
