"""Cases with a metric, from the file to the mesh."""

import re

import numpy as np
import pytest
import scipy.linalg
from invariants import check_edges, check_mesh
from metrics import FRONT, metric_case
from sweeps import sweep

from bubblemesh.case import load_case
from bubblemesh.case.models import Case
from bubblemesh.errors import CaseError, LimitError
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.meshes.quality import inverted
from bubblemesh.problem.prepare import prepare
from bubblemesh.run.estimate import estimate
from bubblemesh.run.metric import MetricRow
from bubblemesh.run.pipeline import mesh_case, mesh_problem
from bubblemesh.run.warnings import unsteady_ellipses
from bubblemesh.spacing.survey import ideal_nodes

LONG = {"angle": 0.5, "across": 0.02}
WALL = {"like": "boundary", "label": "hole", "across": 0.005, "growth": 0.2}
HOLE = {"circle": {"center": [0.5, 0.5], "radius": 0.2}, "label": "hole"}


def meshed(metric, **keys):
    result = mesh_case(metric_case(metric, **keys))
    if "domain" not in keys:  # else there are lines inside, whose nodes are among those of the boundary
        check_mesh(result.mesh)
    check_edges(result.mesh)
    assert len(inverted(result.mesh.points, result.mesh.triangles)) == 0
    return result


@pytest.fixture(scope="module")
def long():
    """The result of a case with long ellipses."""
    return meshed(LONG)


def test_a_front_is_meshed_by_ellipses_that_fit_the_metric():
    report = meshed(FRONT, packing={}).report
    assert report.method == "ellipses"
    assert report.nodes == pytest.approx(report.ideal_nodes, rel=0.03)
    assert report.quality["mean"] > 0.985
    assert report.quality["p01"] > 0.9
    assert report.quality["min"] > 0.8
    assert report.metric.edges_within > 0.998
    assert report.metric.aspect == pytest.approx(3, rel=0.05)
    assert report.spacing["mean"] == pytest.approx(1, abs=0.03)
    assert report.quality["angle_min"] < 40  # those are in space


def test_most_of_the_nodes_that_shorter_ellipses_take_are_saved_elsewhere():
    narrow = {**FRONT, "across": FRONT["across"].replace("0.02 +", "0.004 +")}
    problem = prepare(metric_case(narrow))
    packing, requested = problem.packing_spacing, problem.spacing
    shorter = ideal_nodes(problem.domain, requested.straightened(), 10**6, 1e-3) / problem.survey.ideal_nodes
    assert shorter > 1.02
    assert problem.expected_nodes / problem.survey.ideal_nodes == pytest.approx(shorter**0.3, abs=0.003)
    ahead = np.array([[0.5, 0.5], [0.25, 0.7]])
    assert packing.axes(ahead).across / requested.axes(ahead).across == pytest.approx(shorter**0.35, abs=0.003)
    np.testing.assert_array_less([0.97, 0.4], packing.shares(ahead))
    np.testing.assert_array_less(packing.shares(ahead), [1.001, 0.9])


JUMP = "where(hypot(x - 0.5, y - 0.5) < 0.2, 0.03, 0.1)"
HAIR = {"polygon": [[0, 0], [0.5, 0], [0.51, 0.0], [1, 0], [1, 1], [0, 1]]}


@pytest.mark.parametrize(
    ("metric", "keys", "reasons"),
    [
        ({**FRONT, "across": FRONT["across"].replace("0.02", "0.004")}, {}, ["the metric turns faster"]),
        ({"m11": 1, "m22": 1}, {"spacing": JUMP}, ["the spacing grows faster than 0.4 per length"]),
        ({"angle": 0, "across": 0.02}, {"outer": HAIR, "spacing": 0.2}, ["the boundary is finer"]),
        ({"angle": 0.7, "across": 0.05}, {"spacing": 5}, ["the domain is smaller than the ellipses"]),
    ],
    ids=["turning", "growing", "boundary", "large"],
)
def test_why_ellipses_are_shorter_is_told(metric, keys, reasons):
    report = mesh_case(metric_case(metric, **keys)).report
    row = report.metric.shortened
    assert [text for text in row.reasons if any(text.startswith(reason) for reason in reasons)] == list(row.reasons)
    (told,) = (text for text in report.warnings if "shorter along than the metric asks for" in text)
    assert told.startswith(f"{row.reasons[0]}: at ")


def test_no_ellipse_is_longer_than_the_domain_is_wide():
    problem = prepare(metric_case({"angle": 0.7, "across": 0.05}, spacing=5))
    middle = np.array([[0.5, 0.5]])
    assert problem.spacing.axes(middle).along == pytest.approx(5)
    assert problem.packing_spacing.axes(middle).along <= 1.05


def test_files_have_the_quality_in_the_metric_and_its_tensors(long):
    result = long
    corners = result.mesh.points[result.mesh.triangles]
    m11, m12, m22 = (result.fields[f"metric_{entry}"] for entry in ("11", "12", "22"))
    np.testing.assert_allclose(m11 * m22 - m12**2, (0.02 * 0.06) ** -2, rtol=1e-6)
    np.testing.assert_allclose(result.fields["target_spacing"], np.sqrt(0.02 * 0.06), rtol=1e-6)
    assert result.fields["quality"].mean() == pytest.approx(result.report.quality["mean"])
    sides = corners - np.roll(corners, 1, axis=1)
    squared = m11[:, None] * sides[..., 0] ** 2 + 2 * m12[:, None] * sides[..., 0] * sides[..., 1]
    squared += m22[:, None] * sides[..., 1] ** 2
    a, b, c = np.sqrt(squared).T
    np.testing.assert_allclose(result.fields["quality"], (b + c - a) * (c + a - b) * (a + b - c) / (a * b * c))


def test_sizes_and_tensors_are_two_ways_to_say_the_same(long):
    c, s = np.cos(0.5), np.sin(0.5)
    along, across = 0.06**-2, 0.02**-2
    m11, m12, m22 = along * c * c + across * s * s, (along - across) * c * s, along * s * s + across * c * c
    given = meshed({"m11": m11, "m12": m12, "m22": m22}).mesh
    assert abs(len(given.points) / len(long.mesh.points) - 1) < 0.02


def test_of_two_metrics_the_smaller_size_counts_in_each_direction():
    both = meshed([{"angle": 0, "across": 0.04}, {"angle": "pi/2", "across": 0.06}], spacing=0.1).report
    one = meshed([{"angle": 0, "across": 0.04, "along": 0.06}], spacing=0.1).report
    assert both.ideal_nodes == pytest.approx(one.ideal_nodes, rel=1e-3)
    assert both.metric.aspect == pytest.approx(1.5)


def test_ellipses_lie_along_walls_and_grow_wider_away_from_them():
    result = meshed(WALL, holes=[HOLE])
    x, q = result.mesh.points, result.report.quality
    beside = np.hypot(*(x - 0.5).T)
    assert ((beside > 0.2 + 1e-9) & (beside < 0.21)).sum() > 20
    assert q["mean"] > 0.85


@pytest.mark.parametrize("label", ["missing", ["hole", "missing"]])
def test_walls_that_are_not_there_are_told_with_the_key(label):
    with pytest.raises(CaseError, match=r"metric\.label: .*missing"):
        prepare(metric_case({**WALL, "label": label}, holes=[HOLE]))


def test_regions_lines_points_and_periodic_sides_go_with_a_metric():
    domain = {
        "outer": {"rectangle": [0, 0, 1, 1], "labels": ["bottom", "right", "top", "left"]},
        "holes": [{"circle": {"center": [0.3, 0.3], "radius": 0.1}}],
        "regions": [{"name": "inner", "ring": {"circle": {"center": [0.7, 0.7], "radius": 0.15}}}],
        "lines": [{"path": [[0.1, 0.6], [0.4, 0.9]], "label": "crack"}],
        "points": [{"at": [0.6, 0.2], "label": "probe"}],
        "periodic": [["left", "right"]],
    }
    result = meshed({"angle": "x + 2*y", "across": "0.02 + 0.02*x*(1 - x)"}, domain=domain)
    mesh = result.mesh
    assert {"inner", "domain"} <= set(mesh.regions)
    assert "crack" in mesh.labels
    assert len(mesh.labelled_nodes) == 1
    (sides,) = mesh.periodic_sides
    left, right = mesh.points[sides.nodes[:, 0]], mesh.points[sides.nodes[:, 1]]
    np.testing.assert_allclose(right - left, np.broadcast_to(sides.shift, left.shape), atol=1e-12)
    assert result.report.quality["mean"] > 0.93


def test_a_metric_that_is_not_positive_is_refused_with_its_place():
    with pytest.raises(CaseError, match=r"^metric: is not positive definite and finite at \("):
        prepare(metric_case({"m11": 100, "m12": "200*x", "m22": 100}))
    with pytest.raises(CaseError, match=r"^metric.across: is -0.5 at \(0, 0\): it has to be positive and finite"):
        prepare(metric_case({"angle": 0, "across": "x - 0.5"}))


@pytest.mark.parametrize(
    ("second", "told"),
    [
        ({"angle": 0, "across": "x - 0.5"}, "metric.1.across: is -0.5 at (0, 0): it has to be positive and finite"),
        ({"angle": "log(x-1)", "across": 1}, "metric.1.angle: is nan at (0, 0): it has to be a finite number"),
        ({"m11": 1, "m22": 1, "m12": 1}, "metric.1: is not positive definite and finite at (0, 0)"),
    ],
)
def test_of_several_metrics_the_one_with_the_fault_is_told(second, told):
    with pytest.raises(CaseError, match=re.escape(told)):
        prepare(metric_case([{"angle": 0, "across": 0.05}, second]))


@pytest.mark.parametrize("nothing", [{"m11": 1e-300, "m22": 1e-300}, {"angle": 0, "across": 1e60}])
def test_a_metric_that_asks_for_nothing_leaves_the_spacing(nothing):
    problem = prepare(metric_case(nothing, spacing=0.1))
    np.testing.assert_allclose(problem.spacing(np.array([[0.5, 0.5]])), 0.1)


def test_an_estimate_tells_the_aspect():
    problem = prepare(metric_case(FRONT))
    assert estimate(problem)["metric"]["aspect"] == pytest.approx(3, rel=0.05)
    assert "metric" not in estimate(prepare(metric_case(None)))


@pytest.mark.parametrize(("angle", "radians"), [(45, "0.785398"), ("-3*30", "-1.5708")])
def test_a_constant_angle_beyond_a_full_turn_is_told_to_be_in_radians(angle, radians):
    problem = prepare(metric_case([{"angle": 1, "across": 1}, {"angle": angle, "across": 0.02}]))
    (told,) = [text for text in problem.warnings if "radians" in text]
    assert told.startswith("metric.1.angle: ")
    assert f"degrees are {radians}," in told


@pytest.mark.parametrize("angle", [-6.28, "2*pi", "20*x"])
def test_other_angles_of_a_metric_are_taken_without_a_word(angle):
    assert not any("radians" in text for text in prepare(metric_case({"angle": angle, "across": 0.05})).warnings)


def test_longer_ellipses_than_the_aspect_allows_are_told_and_made_wider():
    problem = prepare(metric_case({"angle": 0.3, "across": "0.00001*(1 + x)", "aspect": 20}))
    assert problem.spacing.aspect == pytest.approx(20)
    assert any("6000 times as long as wide" in text and "aspect raises it" in text for text in problem.warnings)


def test_a_size_that_is_all_but_zero_is_told_as_well():
    warnings = prepare(metric_case({"angle": 0, "across": "1e-320", "aspect": 20})).warnings
    assert any("1.798e+308 times as long as wide" in text for text in warnings)


def test_too_many_nodes_in_a_metric_are_no_fault_of_the_spacing():
    case = metric_case({"angle": 0, "across": 0.002}, limits={"max_nodes": 1000})
    with pytest.raises(LimitError, match=r"^limits.max_nodes: the metric needs about .*: coarsen the metric or raise"):
        prepare(case)


@pytest.mark.long
def test_too_few_nodes_in_a_metric_are_told():
    report = mesh_case(metric_case({"angle": 0.6, "across": "0.001 + 0.2*abs(x - 0.1)"}, spacing=0.3)).report
    assert report.nodes < 0.8 * report.ideal_nodes
    assert any(
        f"times the {report.ideal_nodes:.0f} nodes that the spacing asks for" in told for told in report.warnings
    )


@pytest.mark.long
def test_a_metric_that_jumps_is_told_and_graded_if_the_case_says_so():
    jump = {"angle": 0.3, "across": "0.01 if x > 0.5 else 0.1"}
    plain = meshed(jump, spacing=0.1).report
    assert any("the metric jumps" in text and "gradation: 0.3" in text for text in plain.warnings)
    assert plain.metric.steepest > 3
    graded = meshed({**jump, "gradation": 0.3}, spacing=0.1).report
    assert not any("jumps" in text for text in graded.warnings)
    assert graded.metric.steepest < 2
    assert graded.quality["mean"] > plain.quality["mean"] + 0.02
    assert graded.quality["p01"] > 0.7
    assert graded.nodes == pytest.approx(graded.ideal_nodes, rel=0.04)


def growths(problem, mesh):
    """Growth of ellipses, in the direction where they grow most, over a length of 1 in the metric, by all edges."""
    tensors = [np.array([[a, b], [b, c]]) for a, b, c in problem.spacing.at(mesh.points)]
    edges, _ = unique_edges(mesh.triangles)
    found = []
    for i, j in np.concatenate([edges, edges[:, ::-1]]):
        way = mesh.points[j] - mesh.points[i]
        least = scipy.linalg.eigh(tensors[j], tensors[i], eigvals_only=True)[0]
        found.append((least**-0.5 - 1) / np.sqrt(way @ tensors[i] @ way))
    return np.array(found)


@pytest.mark.long
def test_the_key_by_which_a_metric_grows_gently_is_one_that_the_case_can_have():
    row = MetricRow(2.0, 1.0, 9.0, (0.5, 0.5), 0.0, (0.0, 0.0), None)
    (given,), (found,) = (unsteady_ellipses(row, adapted=adapted) for adapted in (False, True))
    assert given.endswith("gradation: 0.3 in the metric makes it grow gently")
    assert found.endswith("a smaller spacing.growth makes it grow gently")


@pytest.mark.long
def test_a_metric_that_jumps_in_direction_is_told_and_graded_if_the_case_says_so():
    turned = {"angle": "pi/2 if x > 0.5 else 0", "across": 0.02}
    plain = meshed(turned, spacing=0.1).report
    assert any("differ by 90 degrees at (" in text and "gradation: 0.3" in text for text in plain.warnings)
    problem = prepare(metric_case({**turned, "gradation": 0.3}, spacing=0.1))
    result = mesh_problem(problem)
    assert not any("jumps" in text for text in result.report.warnings)
    assert result.report.quality["min"] > 0.75 > plain.quality["min"]
    found = growths(problem, result.mesh)
    assert found.max() < 0.5
    assert np.quantile(found, 0.99) < 0.36


@pytest.mark.parametrize(("across", "told"), [("0.2 if x > 0.5 else 0.3", 0), ("0.02 if x > 0.98 else 0.3", 1)])
def test_a_gradation_that_takes_many_nodes_is_told(across, told):
    problem = prepare(metric_case({"angle": 0, "across": across, "gradation": 0.05}, spacing=0.3))
    found = [re.search(r"gradation takes about (\d+) nodes in place of", text) for text in problem.warnings]
    counts = [int(each[1]) for each in found if each]
    assert counts == [round(problem.survey.ideal_nodes)] * told


def test_what_is_packed_of_a_graded_metric_is_nowhere_coarser_than_it():
    curved = {"angle": "sin(5*x)", "across": "0.15*exp(-0.8*(1+sin(3.6*x-4.3*y)))", "gradation": 0.3}
    holes = [{"rectangle": [0.6, 0.7, 0.63, 0.9]}]
    problem = prepare(metric_case(curved, holes=holes, spacing=0.15))
    x = np.random.default_rng(0).random((500, 2))
    x = x[problem.domain.contains(x)]
    fine = problem.packing_spacing.unstraightened(x) / problem.spacing(x)
    assert fine.max() < 1 + 1e-9
    assert fine.min() < 0.99  # beside the hole


def test_ellipses_along_walls_are_circles_at_ends_and_bends_and_longer_away_from_them():
    lines = [{"path": [[0.3, 0.5], [0.5, 0.55], [0.53, 0.45]], "label": "w"}]
    domain = {"outer": {"rectangle": [0, 0, 1, 1]}, "lines": lines}
    problem = prepare(metric_case({"like": "boundary", "label": "w", "across": 0.01}, domain=domain, spacing=0.1))
    at = problem.spacing.axes(np.array([[0.3, 0.5], [0.5, 0.55], [0.53, 0.45], [0.4, 0.525], [0.2, 0.475]]))
    np.testing.assert_allclose(at.aspects[:3], 1)
    np.testing.assert_allclose(at.along[3:], [0.01 + 0.7 * np.hypot(0.1, 0.025), 0.1], rtol=1e-6)
    report = mesh_problem(problem).report
    assert report.quality["p01"] > 0.6
    assert report.nodes < 400


@pytest.mark.parametrize("radius", [0.02, 0.1])
def test_ellipses_along_a_round_hole_are_as_long_as_edges_that_can_go_around_it(radius):
    domain = {
        "outer": {"rectangle": [0, 0, 1, 1]},
        "holes": [{"circle": {"center": [0.5, 0.4], "radius": radius}, "label": "h"}],
    }
    problem = prepare(metric_case({"like": "boundary", "label": "h", "across": 0.002}, domain=domain, spacing=0.1))
    at = problem.spacing.axes(np.array([[0.5 + radius, 0.4], [0.5, 0.43 + radius], [0.9, 0.4]]))
    around = np.sqrt(2 * radius * np.array([0.002, 0.008]))
    np.testing.assert_allclose(at.along, [around[0], min(around[1] + 0.7 * 0.03, 0.1), 0.1], rtol=1e-3)
    quality = mesh_problem(problem).report.quality
    assert quality["p01"] > 0.6
    assert quality["min"] > 0.5


def test_ellipses_are_circles_around_points_that_share_a_label_with_walls():
    case = {
        "domain": {
            "outer": {"rectangle": [0, 0, 1, 1]},
            "points": [{"at": [0.4, 0.7], "label": "w"}],
            "lines": [{"path": [[0.2, 0.2], [0.8, 0.3]], "label": "w"}],
        },
        "spacing": 0.1,
        "metric": {"like": "boundary", "label": "w", "across": 0.02, "growth": 0.2},
    }
    problem = prepare(Case.model_validate(case))
    around = problem.spacing.axes(np.array([[0.4, 0.7], [0.4, 0.8], [0.5, 0.25]]))
    np.testing.assert_allclose(around.across, [0.02, 0.04, 0.02], rtol=1e-9)
    np.testing.assert_allclose(around.along, [0.02, 0.04, 0.1], rtol=1e-9)
    result = mesh_problem(problem)
    check_edges(result.mesh)
    assert len(inverted(result.mesh.points, result.mesh.triangles)) == 0
    assert result.report.nodes == pytest.approx(result.report.ideal_nodes, rel=0.05)
    at = np.hypot(*(result.mesh.points - [0.4, 0.7]).T).argmin()
    np.testing.assert_array_equal(result.mesh.points[at], [0.4, 0.7])


@pytest.mark.parametrize(
    ("keys", "match"),
    [
        ({"method": "multilevel"}, "method: multilevel packs no metric"),
        ({"method": "fnpbs"}, "method: fnpbs packs no metric"),
        ({"angle_min": 20}, "angle_min: does not go with a metric: its triangles are long"),
        ({"overconstrained": "split"}, "overconstrained: does not go with a metric: it adds nodes by circles"),
        ({"largest": 0.01}, "largest: does not go with a metric: it adds nodes by circles.*bound the sizes"),
    ],
)
def test_what_does_not_go_with_a_metric_is_refused(keys, match):
    with pytest.raises(CaseError, match=match):
        prepare(metric_case(LONG, **keys))


@pytest.mark.parametrize(
    ("keys", "match"),
    [
        ("packing: {population: thresholds}", "packing.population: in a metric only defects is possible: leave it out"),
        ("packing: {k0: 2}", "packing.k0: it has no effect in a metric: leave it out"),
    ],
)
def test_what_of_a_method_does_not_go_with_a_metric_is_told_where_the_case_is_read(keys, match):
    outer, metric = "{rectangle: [0, 0, 1, 1]}", "{angle: 0, across: 0.05}"
    text = f"domain: {{outer: {outer}}}\nspacing: 0.1\nmetric: {metric}\n{keys}\n"
    with pytest.raises(CaseError, match=f"case.yaml:4: {match}"):
        load_case("case.yaml", text=text)


@pytest.mark.parametrize("nodes", sweep([200, 3000], quick=1))
def test_a_metric_is_scaled_for_a_number_of_nodes(nodes):
    result = meshed(FRONT, spacing={"value": 0.06, "nodes": nodes})
    assert result.report.nodes == pytest.approx(nodes, rel=0.02)
    assert result.report.metric.aspect == pytest.approx(3, rel=0.1)  # all sizes go with the scale
    assert result.report.node_target.nodes == nodes


STRIPS = [(0.1, 0.2), (0.1, 10.0), (0.05, 10.0), (0.05, 0.2), (0.02, 0.2), (0.02, 10.0)]


@pytest.mark.parametrize(("height", "spacing"), sweep(STRIPS, quick=3))
def test_a_strip_that_is_narrow_beside_the_spacing_but_wide_in_the_metric_is_filled_by_that(height, spacing):
    metric = {"angle": 0, "across": height / 10, "along": 0.2}
    result = mesh_case(metric_case(metric, {"rectangle": [0, 0, 1, height]}, spacing=spacing))
    check_mesh(result.mesh)
    assert result.report.nodes == pytest.approx(result.report.ideal_nodes, rel=0.1)
    assert result.report.quality["mean"] > 0.95
    assert not result.report.warnings


def test_a_slot_that_is_narrow_in_the_metric_too_is_told():
    metric = {"angle": "pi/2", "across": 0.01, "along": 0.2}
    result = mesh_case(metric_case(metric, {"rectangle": [0, 0, 1, 0.05]}, spacing={"value": 0.2, "across": 0}))
    (text,) = (text for text in result.report.warnings if "only boundary nodes fit" in text)
    assert "0.05 wide" in text


def test_without_a_metric_the_method_packs_circles():
    data = {"name": "m", "domain": {"outer": {"rectangle": [0, 0, 1, 1]}}, "spacing": "0.05 + 0.1*x"}
    from bubblemesh.case.models import Case

    circles = mesh_case(Case.model_validate(data | {"method": "ellipses"}))
    check_mesh(circles.mesh)
    usual = mesh_case(Case.model_validate(data))
    assert abs(circles.report.nodes / usual.report.nodes - 1) < 0.05
    assert circles.report.quality["mean"] > usual.report.quality["mean"] - 0.01
    assert circles.report.ideal_nodes == pytest.approx(usual.report.ideal_nodes, rel=1e-3)


def random_case(seed):
    """A random metric, of up to 300 times longer than wide ellipses, on a random domain."""
    random = np.random.default_rng(seed)
    corners, angles = int(random.integers(3, 12)), random.uniform(-0.5, 0.5, 12)
    turns = 2 * np.pi * (np.arange(corners) + angles[:corners]) / corners
    radii = random.uniform(0.25, 0.6, corners)
    star = [[float(0.5 + r * np.cos(t)), float(0.5 + r * np.sin(t))] for r, t in zip(radii, turns, strict=True)]
    outer = [
        {"rectangle": [0, 0, 1, float(random.uniform(0.3, 1.5))]},
        {"circle": {"center": [0.5, 0.5], "radius": float(random.uniform(0.3, 0.6))}},
        {"ellipse": {"center": [0.5, 0.5], "radii": [0.5, float(random.uniform(0.3, 0.5))]}},
        {"polygon": star},
    ][random.integers(4)]
    along = float(random.uniform(0.08, 0.2))
    across = along / float(np.exp(random.uniform(0, np.log(300))))
    f, g, p, q = random.uniform(2, 9, 4)
    less = max(across, along / 30)  # long ellipses in the whole domain, or turning ones, are too many for a test
    metric = [
        {"angle": float(p), "across": less},
        {"angle": f"{f}*x + {g}*y", "across": f"{less}*(1.2 + sin({g}*x + {p})*sin({f}*y + {q}))"},
        {"angle": "atan2(y - 0.4, x - 0.3) + pi/2", "across": f"{across} + 0.2*abs(hypot(x - 0.3, y - 0.4) - 0.3)"},
        {"angle": 0.3, "across": f"{less} if x > 0.5 else {along}"},
        {"like": "boundary", "label": "outer", "across": across, "growth": float(random.uniform(0.1, 0.5))},
    ][random.integers(5)]
    return metric_case(metric, outer, spacing=along, limits={"max_nodes": 40_000}, packing={"effort": "fast"})


@pytest.mark.parametrize("seed", range(1))
def test_random_metrics_on_random_domains_invert_no_triangle(seed):
    result = mesh_case(random_case(seed))
    check_mesh(result.mesh)
    assert result.report.quality["mean"] > 0.3


@pytest.mark.long
@pytest.mark.parametrize("seed", range(1, 312))
def test_many_random_metrics_on_random_domains_invert_no_triangle(seed):
    check_mesh(mesh_case(random_case(seed)).mesh)
