import math
import re
from collections import Counter
from itertools import pairwise

import numpy as np
import pytest
from examples import EXAMPLES
from invariants import check_mesh
from sweeps import sweep

from bubblemesh.case import load_case
from bubblemesh.errors import CaseError, GeometryError, LimitError
from bubblemesh.packing.progress import Progress
from bubblemesh.run.pipeline import mesh_case

REPORT = [
    "case",
    "method",
    "version",
    "engine",
    "seed",
    "parameters",
    "initial",
    "rounds",
    "stop_reason",
    "nodes",
    "triangles",
    "ideal_nodes",
    "force_evaluations",
    "quality",
    "spacing",
    "area",
    "area_error",
    "regions",
    "labels",
    "seconds",
    "peak_memory_mb",
    "warnings",
]
INITIAL = ["nodes", "boundary_nodes", "triangles", "quality_mean", "quality_min"]
ROUND = [
    "round",
    "iterations",
    "nodes_before",
    "nodes_after",
    "deleted",
    "inserted",
    "mean_speed",
    "quality_mean",
    "quality_min",
    "seconds",
]
QUALITY = ["mean", "min", "p01", "histogram", "irregular_fraction", "valence_max", "angle_min"]
SPACING = ["mean", "std", "p01", "p99"]
IDEAL_NODES = {"1": 985, "2": 530, "3": 655, "4": 291, "dense": 1524}
LEAST_MEAN_QUALITY = {"1": 0.9532, "2": 0.9564, "3": 0.945, "4": 0.9362}

SPACINGS = {
    "1": lambda x, y: 0.1,
    "2": lambda x, y: math.hypot(x, y) / 8,
    "3": lambda x, y: 0.2 * abs(math.hypot(x, y) - 2) + 0.15,
    "4": lambda x, y: min(
        0.25 - 0.15 * (math.hypot(x, y) - 1),
        0.05 + 0.08 * (math.hypot(x + 0.4, y) - 0.5),
        (math.hypot(x + 0.4, y) - 0.5 - math.hypot(x, y) + 1) / 2,
    ),
}

PLATE = """
name: plate
parameters: {h: 0.15}
domain:
  outer: {rectangle: [-1, -1, 1, 1], labels: [bottom, right, top, left]}
  holes: [{circle: {center: [0, 0], radius: 0.4}, label: hole}]
spacing: h
method: accelerated
schedule: {iterations: 60}
"""


def meshed(text, **options):
    result = mesh_case(load_case("case.yaml", text=text, **options))
    check_mesh(result.mesh)
    return result


@pytest.fixture(scope="module", params=sweep(["2", "1", "4", "3"], quick=2))
def example(request):
    return request.param, meshed(EXAMPLES[request.param])


@pytest.fixture(scope="module")
def plate():
    return meshed(PLATE)


def sides_of(points, triangle):
    i, j, k = triangle
    return math.dist(points[j], points[k]), math.dist(points[k], points[i]), math.dist(points[i], points[j])


def ratio_of(a, b, c):
    """2 r / R by Heron's formula: r = A / s, R = abc / 4A."""
    s = (a + b + c) / 2
    area = math.sqrt(s * (s - a) * (s - b) * (s - c))
    return 2 * (area / s) / (a * b * c / (4 * area))


def angle_of(a, b, c):
    return math.degrees(math.acos((b * b + c * c - a * a) / (2 * b * c)))


def quantile(values, share):
    ordered = sorted(values)
    at = share * (len(ordered) - 1)
    low = math.floor(at)
    return ordered[low] + (at - low) * (ordered[min(low + 1, len(ordered) - 1)] - ordered[low])


def edges_of(triangles):
    return Counter(tuple(sorted(side)) for i, j, k in triangles for side in pairwise((i, j, k, i)))


def test_report_has_every_key(plate):
    report = plate.report
    assert not set(REPORT) - report.keys()
    assert not set(INITIAL) - report["initial"].keys()
    assert not set(QUALITY) - report["quality"].keys()
    assert not set(SPACING) - report["spacing"].keys()
    for row in report["rounds"]:
        assert not set(ROUND) - row.keys()


def test_report_says_what_was_run(plate):
    report = plate.report
    assert (report["case"], report["method"], report["seed"]) == ("plate", "accelerated", 0)
    parameters = report["parameters"]
    assert parameters["parameters"] == {"h": 0.15}
    assert parameters["packing"]["w2"] == 0.6
    assert parameters["schedule"]["iterations"] == 60
    assert parameters["schedule"]["c_out"] == 0.2


@pytest.mark.long
def test_figures_agree_with_a_recomputation_by_loops(example):
    name, result = example
    mesh, report = result.mesh, result.report
    points, triangles = mesh.points.tolist(), mesh.triangles.tolist()
    sides = [sides_of(points, triangle) for triangle in triangles]
    q = [ratio_of(*abc) for abc in sides]
    assert report["nodes"] == len(points)
    assert report["triangles"] == len(triangles)
    quality = report["quality"]
    assert quality["mean"] == pytest.approx(math.fsum(q) / len(q), rel=1e-9)
    assert quality["min"] == pytest.approx(min(q), rel=1e-9)
    assert quality["p01"] == pytest.approx(quantile(q, 0.01), rel=1e-9)
    bins = len(quality["histogram"])
    assert list(quality["histogram"]) == [
        sum(min(int(value * bins), bins - 1) == number for value in q) for number in range(bins)
    ]
    least = min(angle_of(*rotated) for a, b, c in sides for rotated in ((a, b, c), (b, c, a), (c, a, b)))
    assert quality["angle_min"] == pytest.approx(least, rel=1e-9)

    counted = edges_of(triangles)
    on_boundary = {node for edge, count in counted.items() if count == 1 for node in edge}
    valence = Counter(node for edge in counted for node in edge)
    inner = [node for node in range(len(points)) if node not in on_boundary]
    irregular = sum(valence[node] != 6 for node in inner) / len(inner)
    assert quality["irregular_fraction"] == pytest.approx(irregular, rel=1e-9)
    assert quality["valence_max"] == max(valence.values())

    d = SPACINGS[name]
    fit = []
    for i, j in counted:
        (ax, ay), (bx, by) = points[i], points[j]
        fit.append(math.dist(points[i], points[j]) / d((ax + bx) / 2, (ay + by) / 2))
    mean = math.fsum(fit) / len(fit)
    deviation = math.sqrt(math.fsum((value - mean) ** 2 for value in fit) / len(fit))
    found = report["spacing"]
    assert (found["mean"], found["std"]) == (pytest.approx(mean, rel=1e-9), pytest.approx(deviation, rel=1e-9))
    assert found["p01"] == pytest.approx(quantile(fit, 0.01), rel=1e-9)
    assert found["p99"] == pytest.approx(quantile(fit, 0.99), rel=1e-9)

    area = math.fsum(math.sqrt(s * (s - a) * (s - b) * (s - c)) for a, b, c in sides for s in [(a + b + c) / 2])
    assert report["area"] == pytest.approx(area, rel=1e-9)
    assert abs(report["area_error"]) <= 1e-12


def test_report_of_the_rounds_is_consistent(example):
    _, result = example
    report = result.report
    rows = report["rounds"]
    assert [row["round"] for row in rows] == list(range(1, len(rows) + 1))
    assert rows[0]["nodes_before"] == report["initial"]["nodes"]
    assert rows[-1]["nodes_after"] == report["nodes"]
    # The same triangles, added up in another order.
    assert rows[-1]["quality_mean"] == pytest.approx(report["quality"]["mean"], rel=1e-13)
    assert rows[-1]["quality_min"] == report["quality"]["min"]
    for row, following in pairwise(rows):
        assert row["nodes_after"] == following["nodes_before"]
    for row in rows:
        assert row["nodes_before"] - row["deleted"] + row["inserted"] == row["nodes_after"]
        assert row["force_evaluations"] >= row["iterations"] * min(row["nodes_before"], row["nodes_after"])
    assert report["force_evaluations"] == sum(row["force_evaluations"] for row in rows)
    seconds = dict(report["seconds"])
    assert seconds.pop("total") == pytest.approx(sum(seconds.values()))


def test_a_packing_that_was_finished_as_the_time_was_over_is_not_told_to_be_cut_short(monkeypatch):
    def finish_late(progress, finish=Progress.finish):
        monkeypatch.setattr("bubblemesh.run.time_limit.time_left", lambda: 0.0)
        finish(progress)

    monkeypatch.setattr(Progress, "finish", finish_late)
    result = meshed("domain: {outer: {rectangle: [0, 0, 1, 1]}}\nspacing: 0.3\nlimits: {seconds: 100}\n")
    assert (result.report["finished"], result.verdict) == (True, None)


def test_fields_are_quality_and_target_spacing(example):
    name, result = example
    mesh = result.mesh
    q = [ratio_of(*sides_of(mesh.points.tolist(), triangle)) for triangle in mesh.triangles.tolist()]
    np.testing.assert_allclose(result.fields["quality"], q, rtol=1e-9)
    d = [SPACINGS[name](*point) for point in mesh.points[mesh.triangles].mean(axis=1).tolist()]
    np.testing.assert_allclose(result.fields["target_spacing"], d, rtol=1e-12)


def test_examples_reach_the_quality_of_the_paper(example):
    name, result = example
    report = result.report
    assert report["quality"]["mean"] >= LEAST_MEAN_QUALITY[name]
    assert report["quality"]["min"] >= 0.2
    assert 0.97 <= report["nodes"] / report["ideal_nodes"] <= 1.12
    assert report["ideal_nodes"] == pytest.approx(IDEAL_NODES[name], abs=0.006 * IDEAL_NODES[name])
    assert report["warnings"] == []


@pytest.mark.long
def test_third_example_stops_by_itself():
    report = meshed(EXAMPLES["3"]).report
    assert report["stop_reason"] == "population changed by at most 0.5% in two rounds"
    assert 3 <= len(report["rounds"]) <= 6
    assert 693 <= report["nodes"] <= 721
    assert report["initial"]["nodes"] == 826


@pytest.mark.long
def test_boundary_follows_the_true_curves_of_the_fourth_example():
    mesh = meshed(EXAMPLES["4"]).mesh
    assert mesh.labels == ("base", "rim", "bore")
    for facet, label in zip(mesh.facets.tolist(), mesh.facet_labels.tolist(), strict=True):
        for x, y in mesh.points[facet].tolist():
            if mesh.labels[label] == "base":
                assert abs(y) < 1e-12
            else:
                cx, radius = {"rim": (0.0, 1.0), "bore": (-0.4, 0.5)}[mesh.labels[label]]
                assert math.hypot(x - cx, y) == pytest.approx(radius, abs=1e-12)


def test_labels_lie_on_their_sides(plate):
    mesh = plate.mesh
    middle = {"bottom": (0, -1), "right": (1, 0), "top": (0, 1), "left": (-1, 0)}
    assert set(mesh.labels) == {*middle, "hole"}
    for facet, label in zip(mesh.facets, mesh.facet_labels, strict=True):
        name, at = mesh.labels[label], mesh.points[facet]
        if name == "hole":
            np.testing.assert_allclose(np.hypot(*at.T), 0.4, rtol=1e-12)
        else:
            normal = np.array(middle[name])
            np.testing.assert_allclose(at @ normal, 1, rtol=1e-12)


def test_points_of_one_label_are_one_group():
    text = """
domain:
  outer: {rectangle: [0, 0, 2, 1]}
  points: [{at: [0.5, 0.5], label: well}, {at: [1, 0]}, {at: [1.5, 0.5], label: well}]
spacing: 0.25
"""
    mesh = mesh_case(load_case("points.yaml", text=text)).mesh
    assert mesh.point_labels == ("well", "point-2")
    found = zip(mesh.points[mesh.labelled_nodes].tolist(), mesh.node_labels.tolist(), strict=True)
    assert list(found) == [([0.5, 0.5], 0), ([1, 0], 1), ([1.5, 0.5], 0)]


def test_rounds_are_told_as_they_end():
    told = []
    result = mesh_case(load_case("case.yaml", text=PLATE), told.append)
    assert [row.round for row in told] == [row["round"] for row in result.report["rounds"]]
    assert [row.nodes_after for row in told] == [row["nodes_after"] for row in result.report["rounds"]]


@pytest.mark.parametrize(
    ("override", "error", "message"),
    [
        ("limits.max_nodes=50", LimitError, "limits.max_nodes"),
        ("spacing=0.1 - 0.1*x", CaseError, "spacing: "),
        ("spacing=x", CaseError, "has to be positive"),
        ("domain.holes.0.circle.radius=1.2", GeometryError, "hole 1 crosses the outer ring"),
    ],
)
def test_wrong_cases_end_with_an_error_of_the_user(override, error, message):
    with pytest.raises(error, match=message):
        meshed(PLATE, overrides=[override])


def test_spacing_larger_than_the_domain_is_warned_of():
    result = meshed("domain: {outer: {rectangle: [0, 0, 1, 1]}}\nspacing: 50\n")
    assert result.report["nodes"] == 4
    assert any("all nodes are on the boundary" in warning for warning in result.report["warnings"])


def test_a_missed_requirement_is_told_in_numbers_that_differ():
    text = "{name: a, domain: {outer: {rectangle: [0, 0, 1, 1]}}, spacing: 0.3, packing: {effort: fast}"
    least = mesh_case(load_case("a.yaml", text=text + "}")).report["quality"]["min"]
    required = f", require: {{quality_min: {least * (1 + 1e-7)!r}, valence_max: 4}}}}"
    told = str(mesh_case(load_case("a.yaml", text=text + required)).verdict)
    low, high = re.search(r"quality_min is (\S+), below (\S+);", told).groups()
    assert 4 < len(low) < 14
    assert float(low) < float(high)
    assert re.search(r"valence_max is \d, above 4$", told)


def test_the_largest_angle_may_be_required():
    text = "{name: a, domain: {outer: {rectangle: [0, 0, 1, 1]}}, spacing: 0.3, packing: {effort: fast}"
    largest = mesh_case(load_case("a.yaml", text=text + "}")).report["quality"]["angle_max"]
    for required, met in ((largest, True), (largest - 0.1, False)):
        verdict = mesh_case(load_case("a.yaml", text=f"{text}, require: {{angle_max: {required!r}}}}}")).verdict
        assert (verdict is None) == met
    assert re.search(r"angle_max is \S+, above \S+$", str(verdict))
