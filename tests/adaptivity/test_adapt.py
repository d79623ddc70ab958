"""Meshes that follow a solution: the loop with a solver, what is kept, what is refused, and the page that shows it."""

import json
import re
from functools import cache

import meshio
import numpy as np
import pytest
from commands import within
from invariants import check_mesh
from paths import ROOT
from scipy.spatial import KDTree
from site_pages import followed
from solver_files import vtu
from sweeps import sweep

import bubblemesh
from benchmarks import adaptivity
from benchmarks.adaptivity import CASE, adaptive, order, singular, uniform
from bubblemesh.adaptivity.sizes import smooth_sizes
from bubblemesh.adaptivity.target import missed_error
from bubblemesh.errors import CaseError, LimitError

PATH = ROOT / "docs" / "adaptivity.md"
PAGE = PATH.read_text()
PLATE = """
name: plate
domain: {outer: {rectangle: [0, 0, 2, 1], label: wall}, holes: [{circle: {center: [1, 0.5], radius: 0.2}, label: hole}]}
spacing: 0.07
packing: {effort: fast}
"""


def case_of(text, *overrides):
    return bubblemesh.load_case("-", text=text, overrides=overrides)


@pytest.fixture(scope="module")
def plate():
    return bubblemesh.mesh_case(case_of(PLATE)).mesh


def bump(mesh):
    """A peak in the upper left."""
    x, y = mesh.points.T
    return bubblemesh.Solution.of(mesh.points, mesh.triangles, np.exp(-200 * ((x - 0.4) ** 2 + (y - 0.7) ** 2)))


def sizes_around(mesh, x, y, reach):
    middles = mesh.points[mesh.triangles].mean(axis=1)
    near = np.hypot(*(middles - [x, y]).T) < reach
    return np.sqrt(4 / np.sqrt(3) * np.abs(areas(mesh)[near])).mean()


def areas(mesh):
    (ux, uy), (vx, vy) = (mesh.points[mesh.triangles[:, k]].T - mesh.points[mesh.triangles[:, 0]].T for k in (1, 2))
    return (ux * vy - uy * vx) / 2


@pytest.mark.long
@pytest.mark.parametrize("scale", [1e200, 1e-200, 1e-290, 3e307])
def test_sizes_do_not_depend_on_the_unit_of_the_solution(scale, plate):
    found = bump(plate)
    scaled = bubblemesh.Solution.of(found.points, found.triangles, scale * found.values)
    exact = "exp(-200*((x - 0.4)**2 + (y - 0.7)**2))"
    one = bubblemesh.adapt(case_of(PLATE), found, error=0.1, exact=exact)
    other = bubblemesh.adapt(case_of(PLATE), scaled, error=0.1, exact=f"{scale}*{exact}")
    assert len(one.mesh.points) == len(other.mesh.points)
    one, other = one.report["adaptation"], other.report["adaptation"]
    for figure in ("error", "expected_error", "true_error"):
        assert other[figure] / scale == pytest.approx(one[figure], rel=1e-6) or other[figure] == np.inf
    for figure in ("relative_error", "effectivity"):
        assert other[figure] == pytest.approx(one[figure], rel=1e-6)


# The loop with a solver


@pytest.mark.long
def test_adapted_meshes_reach_the_optimal_order_and_uniform_ones_do_not():
    adapted, even = adaptive(5), uniform([0.25, 0.125, 0.0625, 0.04])
    assert order(adapted) < -0.48
    assert -0.38 < order(even) < -0.28
    assert adapted[-1].error < even[-1].error / 2
    assert [step.effectivity for step in adapted[2:]] == pytest.approx([1.04, 1.02, 1.01], abs=0.03)
    for step in adapted[2:]:
        check_mesh(step.mesh)


@pytest.mark.long
def test_a_wanted_error_is_met_after_a_few_loops():
    case, error = case_of(CASE), 0.04
    mesh = bubblemesh.mesh_case(case).mesh
    for _ in range(8):
        solution = bubblemesh.Solution.of(mesh.points, mesh.triangles, adaptivity.solved(mesh))
        result = bubblemesh.adapt(case, solution, error=error)
        figures = result.report["adaptation"]
        if figures["relative_error"] <= error:
            break
        mesh = result.mesh
    assert 0.9 * error < figures["relative_error"] <= error
    assert figures["start"] == "present nodes"
    assert len(mesh.points) < 280  # about the least


@pytest.mark.parametrize(
    ("step", "share", "told"),
    [
        (0.02, 0.123, "spacing.minimum holds at 12.3% of the nodes: lower it"),
        (0.02, 0.0, "limits of the case hold: lower them"),
        (0.05, 0.0, "one step gives sizes of 1/16 at most: adapt again to the new solution"),
        (
            0.04,
            0.123,
            "one step gives sizes of 1/16 at most, and spacing.minimum holds at 12.3% of the nodes: "
            "adapt again to the new solution, or lower it",
        ),
    ],
)
def test_what_keeps_a_wanted_error_out_of_reach_is_named(step, share, told):
    text = missed_error(0.03, 0.05, step, share, anisotropic=False)
    assert text == f"an error of 0.03 is asked for, and 0.05 is expected: {told}"


@pytest.mark.parametrize("keys", [["spacing.minimum=0.05"], ["spacing.minimum=0.001"]])
def test_an_error_that_is_out_of_reach_is_told(plate, keys):
    warnings = bubblemesh.adapt(case_of(PLATE, *keys), bump(plate), error=0.15).report["warnings"]
    told = r"an error of 0\.15 is asked for, and 0\.3.*: spacing\.minimum holds at \d+\.\d% of the nodes: lower"
    assert bool(re.search(told, "".join(warnings))) == (keys == ["spacing.minimum=0.05"])


@pytest.mark.long
def test_notes_on_the_file_are_warnings(plate, tmp_path):
    u = np.exp(plate.points[:, 0])
    for factor, name in ((1, "early"), (2, "late")):
        vtu(tmp_path / f"{name}.vtu", plate.points, plate.triangles, {"u": factor * u})
    entries = [f'<DataSet timestep="{time}" file="{name}.vtu"/>' for time, name in ((0, "early"), (1.5, "late"))]
    text = f'<VTKFile type="Collection"><Collection>{"".join(entries)}</Collection></VTKFile>'
    (tmp_path / "a.pvd").write_text(text)
    with pytest.warns(bubblemesh.MeshWarning, match=r"a\.pvd: holds 2 times: the last one, 1\.5, is read") as told:
        result = bubblemesh.adapt(case_of(PLATE), tmp_path / "a.pvd")
    assert told[0].filename == __file__
    assert result.report["adaptation"]["field"] == "u"


# The new mesh


@pytest.mark.long
def test_without_a_target_as_many_nodes_are_finer_where_the_error_is_and_coarser_elsewhere(plate):
    result = bubblemesh.adapt(case_of(PLATE), bump(plate))
    check_mesh(result.mesh)
    assert abs(len(result.mesh.points) / len(plate.points) - 1) <= 0.02
    assert sizes_around(result.mesh, 0.4, 0.7, 0.1) < 0.5 * 0.07
    assert sizes_around(result.mesh, 1.7, 0.3, 0.2) > 1.3 * 0.07
    assert result.mesh.labels == plate.labels
    figures = result.report["adaptation"]
    assert figures["expected_error"] < 0.5 * figures["error"]
    assert figures["nodes_before"] == len(plate.points)


@pytest.mark.long
@pytest.mark.parametrize(
    ("options", "override", "nodes"), [({"nodes": 250}, [], 250), ({}, ["spacing.nodes=450"], 450)]
)
def test_the_number_of_nodes_is_met(plate, options, override, nodes):
    report = bubblemesh.adapt(case_of(PLATE, *override), bump(plate), **options).report
    assert abs(report["nodes"] - nodes) <= 0.02 * nodes
    assert report["node_target"]["nodes"] == nodes


@pytest.mark.long
def test_limits_and_rules_of_the_case_hold(plate):
    case = case_of(PLATE, "spacing.minimum=0.05", "spacing.maximum=0.08", "spacing.growth=0.05")
    mesh = bubblemesh.adapt(case, bump(plate), error=0.01).mesh
    i, j = mesh.triangles[:, 0], mesh.triangles[:, 1]
    lengths = np.hypot(*(mesh.points[i] - mesh.points[j]).T)
    assert np.quantile(lengths, 0.02) > 0.8 * 0.05
    assert np.quantile(lengths, 0.98) < 1.2 * 0.08
    round_hole = bubblemesh.adapt(case_of(PLATE, "spacing.per_circle=60"), bump(plate), error=0.2).mesh
    assert np.sum(round_hole.facet_labels == round_hole.labels.index("hole")) > 50


@pytest.mark.long
def test_most_nodes_stay_where_the_sizes_do():
    case = case_of(PLATE, "spacing=0.04")
    mesh = bubblemesh.mesh_case(case).mesh
    for _ in range(3):
        before, result = mesh, bubblemesh.adapt(case, bump(mesh), error=0.05)
        mesh = result.mesh
    figures = result.report["adaptation"]
    assert figures["start"] == "present nodes"
    assert figures["unchanged"] > 0.7
    sizes = smooth_sizes(before.points, before.triangles)
    there = smooth_sizes(mesh.points, mesh.triangles)[KDTree(mesh.points).query(before.points)[1]]
    same = np.abs(there / sizes - 1) < 0.03
    away = KDTree(mesh.points).query(before.points[same])[0]
    assert same.mean() > 0.5
    assert np.mean(away < 0.25 * sizes[same]) > 0.6  # by seed .7 to .93; of nodes placed anew it were 0.23


@pytest.mark.long
def test_same_solution_same_mesh(plate):
    one, other = (bubblemesh.adapt(case_of(PLATE), bump(plate), error=0.2).mesh for _ in range(2))
    assert one.points.tobytes() == other.points.tobytes()
    assert one.triangles.tobytes() == other.triangles.tobytes()


def test_a_published_method_adapts_too(plate):
    case = case_of(PLATE, "method=accelerated", "schedule.iterations=60")
    check_mesh(bubblemesh.adapt(case, bump(plate), error=0.3).mesh)


@pytest.mark.long
def test_regions_recover_their_own_gradients():
    regions = "{name: a, ring: {rectangle: [0, 0, 0.7, 1]}}, {name: b, ring: {rectangle: [0, 0, 0.3, 1]}}"
    case = case_of(f"domain: {{outer: {{rectangle: [0, 0, 2, 1]}}, regions: [{regions}]}}\nspacing: 0.1")
    mesh = bubblemesh.mesh_case(case).mesh
    kink = np.interp(mesh.points[:, 0], [0, 0.3, 0.7, 2], [0, 3, 3.4, 0])
    result = bubblemesh.adapt(case, bubblemesh.Solution.of(mesh.points, mesh.triangles, kink))
    assert result.report["adaptation"]["relative_error"] < 1e-12
    assert result.mesh.regions == mesh.regions


# What of the case holds


HALVES = """
domain: {outer: {rectangle: [0, 0, 2, 1]}, regions: [{name: left, ring: {rectangle: [0, 0, 1, 1]}}]}
spacing: {value: 0.15, regions: {left: 0.05}}
"""
SQUARE = "domain: {outer: {rectangle: [0, 0, 1, 1]}}\nspacing: 0.2\n"
SEA = """
domain: {outer: {rectangle: [0, 0, 2, 1]}}
spacing: {value: 0.15, courant: {depth: 10 + x, dt: 0.01, largest: 1}}
"""


@cache
def flat(text):
    """A case, and a solution on its mesh that bends in one corner."""
    case = case_of(text)
    mesh = bubblemesh.mesh_case(case).mesh
    x, y = mesh.points.T
    return case, bubblemesh.Solution.of(mesh.points, mesh.triangles, np.exp(-50 * ((x - 2) ** 2 + y**2)))


def longest(mesh, lowest, highest):
    """Length of the longest edge between two values of x."""
    corners = mesh.points[mesh.triangles]
    inside = (corners[..., 0] > lowest).all(axis=1) & (corners[..., 0] < highest).all(axis=1)
    return np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)[inside].max()


@pytest.mark.parametrize("anisotropic", sweep([False, True], quick=1))
def test_limits_of_regions_hold(anisotropic):
    case, solution = flat(HALVES)
    result = bubblemesh.adapt(case, solution, error=0.2, anisotropic=anisotropic)
    assert longest(result.mesh, -1, 0.95) < 0.08
    assert longest(result.mesh, 1.1, 3) > 0.12
    assert not any("regions" in told for told in result.report["warnings"])


def test_limits_that_spacing_nodes_scales_do_not_hold_and_that_is_told():
    case, solution = flat(HALVES.replace("0.15", "0.15, nodes: 400"))
    told = bubblemesh.adapt(case, solution).report["warnings"]
    assert told == ["spacing.regions: does not hold, since with spacing.nodes its values are no lengths"]


def test_the_depth_is_written_and_the_courant_number_holds():
    case, solution = flat(SEA)
    result = bubblemesh.adapt(case, solution, error=0.02)
    assert result.report["adaptation"]["expected_relative_error"] > 0.05  # it would be far finer
    np.testing.assert_allclose(result.mesh.depth, 10 + result.mesh.points[:, 0])
    assert 0.01 / result.report["water"]["time_step"] < 1.5
    other = bubblemesh.adapt(case, solution, nodes=200, anisotropic=True)
    assert "spacing.courant: does not hold for ellipses: give spacing.minimum" in other.report["warnings"]
    np.testing.assert_allclose(other.mesh.depth, 10 + other.mesh.points[:, 0])


def test_the_depth_is_that_of_the_output(plate):
    case = case_of(PLATE + "output: {formats: [fort.14], depth: 10 + x}\n")
    mesh = bubblemesh.adapt(case, bump(plate), error=0.5).mesh
    np.testing.assert_allclose(mesh.depth, 10 + mesh.points[:, 0])


def test_a_smallest_angle_is_refused_in_words_that_fit_without_a_metric_in_the_case(plate):
    with pytest.raises(CaseError, match=r"angle_min: .*no fault: leave it out$"):
        bubblemesh.adapt(case_of(PLATE + "angle_min: 20\n"), bump(plate), nodes=200, anisotropic=True)


@pytest.mark.parametrize("anisotropic", sweep([False, True], quick=1))
@pytest.mark.parametrize(
    ("spacing", "fewest", "most", "told"),
    [
        ("{maximum: 0.14}", 60, 100, " nodes .* 43, are too few: .* take about .* ask for more by nodes"),
        (
            "{value: 1, minimum: 0.4}",
            9,
            16,
            " nodes .* 43, are more than the limits of the case allow: .* about 1",
        ),
    ],
)
def test_as_many_nodes_as_before_are_the_nearest_number_that_can_be_had(spacing, fewest, most, told, anisotropic):
    _, solution = flat(SQUARE)
    assert len(solution.points) == 43
    case = case_of(SQUARE, f"spacing={spacing}")
    report = bubblemesh.adapt(case, solution, anisotropic=anisotropic).report
    assert fewest <= report["nodes"] <= most
    assert [bool(re.search(told, warning)) for warning in report["warnings"]].count(True) == 1
    with pytest.raises((CaseError, LimitError), match=r"^nodes: 43 nodes are"):
        bubblemesh.adapt(case, solution, nodes=43, anisotropic=anisotropic)


def test_a_limit_below_the_fewest_nodes_is_told_with_its_line(tmp_path):
    points, triangles = 1.0 * np.array([(0, 0), (1, 0), (1, 1), (0, 1)]), [("triangle", [(0, 1, 2), (0, 2, 3)])]
    meshio.Mesh(np.pad(points, ((0, 0), (0, 1))), triangles, {"u": points[:, 0] ** 2}).write(tmp_path / "u.vtu")
    text = "domain: {outer: {rectangle: [0, 0, 1, 1]}}\nspacing: {value: 0.3, maximum: 0.2}\nlimits:\n  max_nodes: 20\n"
    (tmp_path / "a.yaml").write_text(text)
    done = command("adapt", "a.yaml", "--solution", "u.vtu", folder=tmp_path)
    assert done.returncode == 6
    assert done.stderr.startswith("error: a.yaml:4: limits.max_nodes: 20 nodes are too few: ")


@pytest.mark.long
def test_as_many_nodes_as_before_are_no_more_than_the_limit():
    _, solution = flat(SQUARE)
    report = bubblemesh.adapt(case_of(SQUARE, "limits.max_nodes=30"), solution).report
    assert report["nodes"] in (29, 30, 31)
    assert "43, are more than the limits of the case allow: the new mesh gets about 30" in report["warnings"][0]


def test_an_error_that_needs_too_many_nodes_is_to_be_larger():
    _, solution = flat(SQUARE)
    with pytest.raises(LimitError, match=r"^limits.max_nodes: .*: ask for a larger error or raise the limit$"):
        bubblemesh.adapt(case_of(SQUARE), solution, error=1e-5)


def test_the_exact_solution_tells_the_effectivity(plate):
    values = plate.points[:, 0] ** 2
    solution = bubblemesh.Solution.of(plate.points, plate.triangles, values)
    figures = bubblemesh.adapt(case_of(PLATE), solution, nodes=200, exact="x**2").report["adaptation"]
    assert figures["effectivity"] == pytest.approx(1, abs=0.03)
    assert figures["true_error"] == pytest.approx(figures["error"] / figures["effectivity"])


@pytest.mark.long
def test_layers_that_take_most_of_the_nodes_are_told():
    text = "domain: {outer: {rectangle: [0, 0, 1, 1]}}\nspacing: 0.25\n"
    points, triangles = (mesh := bubblemesh.mesh_case(case_of(text)).mesh).points, mesh.triangles
    solution = bubblemesh.Solution.of(points, triangles, points[:, 0] ** 2)
    case = case_of(text + "layers: [{on: outer, first: 0.005, until: isotropic}]\n")
    few, many = (bubblemesh.adapt(case, solution, nodes=nodes).report for nodes in (300, 1500))
    (told,) = few["warnings"]
    assert "of the 300 nodes: the spacing beside them is 2.9" in told
    assert few["spacing"]["mean"] < 0.7
    assert many["warnings"] == []
    assert many["spacing"]["mean"] == pytest.approx(1, abs=0.05)


@pytest.mark.parametrize("values", sweep([lambda x: x**2, np.ones_like], quick=1))
def test_figures_of_an_adaptation_are_plain_numbers(plate, values):
    solution = bubblemesh.Solution.of(plate.points, plate.triangles, values(plate.points[:, 0]))
    report = bubblemesh.adapt(case_of(PLATE), solution, nodes=200).report
    figures = report["adaptation"]
    assert any("u is the same at all nodes" in told for told in report["warnings"]) == (values is np.ones_like)
    names = ("error", "relative_error", "expected_error", "expected_relative_error")
    assert {type(figures[name]) for name in names} == {float}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"error": 0.1, "nodes": 100}, "error and nodes exclude each other"),
        ({"error": 1.5}, r"^error: .* between 0 and 1 \(found 1.5\)"),
        ({"error": "small"}, r"between 0 and 1 \(found 'small'\)"),
        ({"nodes": 2}, "^nodes: must be a whole number of at least 3"),
        ({"nodes": 400.5}, r"^nodes: must be a whole number of at least 3 \(found 400.5\)"),
        ({"field": "u"}, "field: names data of a file"),
        ({"exact": "x +"}, "^exact: "),
        ({"exact": "1e400"}, r"^exact: the exact solution has no gradient at "),
        ({"exact": 3}, r"^exact: must be an expression in x and y \(found 3\)"),
        ({"anisotropic": "no"}, r"^anisotropic: must be true or false \(found 'no'\)"),
        ({"on_round": 5}, r"^on_round: must be a function of the round that is done \(found 5\)"),
    ],
)
def test_options_that_make_no_sense_are_refused(plate, options, message):
    with pytest.raises(CaseError, match=message):
        bubblemesh.adapt(case_of(PLATE), bump(plate), **options)


@pytest.mark.long
def test_too_few_nodes_for_the_domain_are_refused(plate):
    with pytest.raises(LimitError, match=r"^nodes: 4 nodes are too few"):
        bubblemesh.adapt(case_of(PLATE), bump(plate), nodes=4)


# The command


def command(*arguments, folder):
    done = within(*arguments, folder=folder)
    done.stdout, done.stderr = done.stdout.decode(), done.stderr.decode()
    return done


@pytest.fixture(scope="module")
def folder(tmp_path_factory, plate):
    """A folder with a case and a solution."""
    folder = tmp_path_factory.mktemp("adapt")
    (folder / "plate.yaml").write_text(PLATE)
    u = bump(plate).values[:, 0]
    data = {"u": u, "flow": np.column_stack([u, 2 * u, 0 * u])}
    points = np.pad(plate.points, ((0, 0), (0, 1)))
    meshio.Mesh(points, [("triangle", plate.triangles)], point_data=data).write(folder / "solution.vtu")
    return folder


@pytest.mark.long
def test_the_command_writes_the_files_of_a_run(folder, plate):
    done = command(
        *("adapt", "plate.yaml", "--solution", "solution.vtu", "--field", "u", "--error", 0.3, "-o", "out", "--json"),
        folder=folder,
    )
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert report == json.loads((folder / "out" / "plate.report.json").read_text())
    assert {"plate.msh", "plate.vtu"} <= {path.name for path in (folder / "out").iterdir()}
    assert report["adaptation"]["field"] == "u"
    python = bubblemesh.adapt(case_of(PLATE), folder / "solution.vtu", "u", error=0.3)
    assert len(meshio.read(folder / "out" / "plate.vtu").points) == len(python.mesh.points)
    assert "estimated error" in done.stderr


@pytest.mark.long
@pytest.mark.parametrize(
    ("arguments", "exit_code", "message"),
    [
        (["--field", "v"], 2, "solution.vtu: has no data 'v' at its nodes: it has u, flow"),
        ([], 2, "choose one by --field"),
        (["--field", "u", "--error", "2"], 2, "error: --error: must be a share of the gradient's norm"),
        (["--field", "u", "--nodes", "2"], 2, "error: --nodes: must be a whole number of at least 3 (found 2)"),
        (["--field", "u", "--nodes", "9", "--error", "0.1"], 2, "error: --error and --nodes exclude each other"),
        (["--field", "u", "--exact", "x +"], 2, "plate.yaml: --exact: "),
        (["--field", "flow", "--exact", "x"], 2, "--exact: must be one expression, but flow has several components"),
        (["--field", "u", "--set", "domain.holes=[]"], 2, "plate.yaml: the mesh of the solution does not cover"),
        (["--field", "u", "--nodes", "5"], 6, "plate.yaml: --nodes: 5 nodes are too few"),
        (["--field", "u", "--set", "spacing.nodes=5"], 6, "--set spacing.nodes: spacing.nodes: 5 nodes are too few"),
        (["--field", "u", "-o", "solution.vtu"], 5, "solution.vtu: the results would overwrite this file"),
        (["--field", "u", "-o", "-", "--json"], 2, "drop one of them"),
    ],
)
def test_errors_of_the_command(folder, arguments, exit_code, message):
    before = (folder / "solution.vtu").read_bytes()
    done = command("adapt", "plate.yaml", "--solution", "solution.vtu", *arguments, folder=folder)
    assert done.returncode == exit_code, done.stderr
    assert message in done.stderr
    assert "Traceback" not in done.stderr
    assert (json.loads(done.stdout)["error"] in done.stderr) if "--json" in arguments else done.stdout == ""
    assert (folder / "solution.vtu").read_bytes() == before


def test_a_solution_that_is_not_there_is_a_file_error(folder):
    done = command("adapt", "plate.yaml", "--solution", "none.vtu", folder=folder)
    assert (done.returncode, "none.vtu: the file cannot be read" in done.stderr) == (5, True)


# The page


@pytest.mark.long
def test_the_page_runs_and_its_errors_fall(tmp_path):
    ((_, printed),) = followed(PATH, tmp_path)
    errors = [float(line.split()[-1]) for line in printed.splitlines()]
    assert errors == sorted(errors, reverse=True)
    assert len(errors) == 3
    assert json.loads((tmp_path / "second" / "l-shape.report.json").read_text())["adaptation"]["field"] == "u"


def test_keys_of_the_report_are_all_on_the_page(plate):
    solution = bubblemesh.Solution.of(plate.points, plate.triangles, plate.points[:, 0] ** 2)
    figures = bubblemesh.adapt(case_of(PLATE), solution, exact="x**2").report["adaptation"]
    assert {key for key in figures if f"`{key}`" not in PAGE} == set()


def test_the_example_s_solution_is_harmonic_and_zero_beside_the_corner():
    t, h = np.linspace(0.01, 1, 9), 1e-4
    np.testing.assert_allclose(singular(-t, 0 * t), 0, atol=1e-12)
    np.testing.assert_allclose(singular(0 * t, -t), 0, atol=1e-12)
    x, y = np.array([0.3, 0.5, -0.4]), np.array([-0.5, 0.4, 0.7])
    around = singular(x + h, y) + singular(x - h, y) + singular(x, y + h) + singular(x, y - h)
    np.testing.assert_allclose((around - 4 * singular(x, y)) / h**2, 0, atol=1e-5)
