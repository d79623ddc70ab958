"""`bubblemesh quality A B`: two meshes side by side."""

import io
import json
import re

import meshio
import numpy as np
import pytest
from rich.console import Console
from squares import holed_square
from typer.testing import CliRunner

from bubblemesh import console, load_case, mesh_case
from bubblemesh.cli import app
from bubblemesh.console.report import show_comparison
from bubblemesh.meshes import comparison
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.meshes.histograms import histogram, lowest_shown, quality_histogram
from bubblemesh.meshes.quality import Measures, angles, edge_means, inverted, radius_ratios
from bubblemesh.meshfiles.read import read_mesh
from bubblemesh.meshfiles.writing import write_file


def run(*arguments):
    done = CliRunner().invoke(app, ["quality", *map(str, arguments)])
    return done.exit_code, done.stdout, done.stderr


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A mesh of right triangles, and one that random displacements made worse; the first has a target spacing."""
    folder = tmp_path_factory.mktemp("meshes")
    first, second = holed_square(9), holed_square(12)
    inner = np.setdiff1d(np.arange(len(second.points)), second.facets)
    second.points[inner] += np.random.default_rng(0).uniform(-0.05, 0.05, (len(inner), 2))
    target = 0.3 + 0.1 * first.points[first.triangles].mean(axis=1)[:, 0]
    write_file(first, {"target_spacing": target}, {}, folder / "a.vtu")
    write_file(second, {}, {}, folder / "b.msh")
    return folder / "a.vtu", folder / "b.msh", first, second, target


def brute_force_ratios(mesh, target):
    """Length of each edge over the mean target of the triangles that have it."""
    found = {}
    for triangle, size in zip(mesh.triangles.tolist(), target, strict=True):
        for i, j in zip(triangle, triangle[1:] + triangle[:1], strict=True):
            found.setdefault((min(i, j), max(i, j)), []).append(size)
    return np.array([np.linalg.norm(mesh.points[i] - mesh.points[j]) / np.mean(d) for (i, j), d in found.items()])


def test_json_has_both_meshes_and_what_the_second_has_more(files):
    a, b, first, second, target = files
    code, text, said = run(a, b, "--json")
    assert (code, said) == (0, "")
    report = json.loads(text)
    for mesh, path, entry in ((first, a, report["meshes"][0]), (second, b, report["meshes"][1])):
        assert entry["mesh"] == str(path)
        assert entry["nodes"] == len(mesh.points)
        assert entry["quality"]["min"] == radius_ratios(mesh.points, mesh.triangles).min()
        assert entry["quality"]["angle_max"] == angles(mesh.points, mesh.triangles).max()
        bins = entry["histograms"]["quality"]
        assert sum(bins["counts"]) + bins["below"] + bins["above"] == len(mesh.triangles)
    ratios = brute_force_ratios(first, target)
    assert report["meshes"][0]["spacing"]["mean"] == pytest.approx(ratios.mean(), rel=1e-12)
    assert report["meshes"][0]["spacing"]["std"] == pytest.approx(ratios.std(), rel=1e-12)
    bins = report["meshes"][0]["histograms"]["spacing"]
    assert bins["counts"] == np.histogram(ratios, bins["edges"])[0].tolist()
    assert report["meshes"][1]["histograms"]["spacing"] is None
    assert "spacing" not in report["meshes"][1]
    assert report["differences"]["triangles"] == len(second.triangles) - len(first.triangles)
    means = [entry["quality"]["mean"] for entry in report["meshes"]]
    assert report["differences"]["quality"]["mean"] == means[1] - means[0] < 0
    assert "spacing" not in report["differences"]


def test_a_given_spacing_counts_for_both_and_over_that_of_the_file(files):
    a, b, first, second, _ = files
    code, text, _ = run(a, b, "--json", "--spacing", "0.25")
    assert code == 0
    for mesh, entry in zip((first, second), json.loads(text)["meshes"], strict=True):
        ratios = brute_force_ratios(mesh, np.full(len(mesh.triangles), 0.25))
        assert entry["spacing"]["mean"] == pytest.approx(ratios.mean(), rel=1e-12)


def test_the_terminal_shows_figures_with_differences_and_histograms(files):
    a, b, first, second, _ = files
    code, text, said = run(a, b)
    assert (code, said) == (0, "")
    lines = text.splitlines()
    assert lines[:2] == [f"A          {a}", f"B          {b}"]
    rows = {line[:18].strip(): line[18:].split() for line in lines if line}
    n, m = len(first.triangles), len(second.triangles)
    assert rows["triangles"] == [str(n), str(m), f"{m - n:+d}"]
    q, p = (radius_ratios(mesh.points, mesh.triangles) for mesh in (first, second))
    assert rows["least q"] == [f"{q.min():.3f}", f"{p.min():.3f}", f"{p.min() - q.min():+.3f}"]
    assert rows["mean l/d"][1:] == ["-", "-"]
    # The first mesh has triangles of one shape only: they are in one bin, with the longest bar.
    (full,) = [line for line in lines if "100.0%" in line]
    low, high = map(float, re.match(r"([\d.]+) to ([\d.]+)", full).groups())
    assert low - 0.005 <= q.min() <= high + 0.005
    assert "█" * 22 in full


def test_the_same_mesh_differs_in_nothing(files):
    a = files[0]
    code, text, _ = run(a, a, "--json")

    def numbers(value):
        return [n for item in value.values() for n in numbers(item)] if isinstance(value, dict) else [value]

    assert code == 0
    assert set(numbers(json.loads(text)["differences"])) == {0}


@pytest.mark.parametrize(
    ("arguments", "exit_code", "message"),
    [
        (["A", "missing.msh"], 5, "error: missing.msh: the file cannot be read"),
        (["A", "B", "--spacing", "x - 9"], 2, "error: --spacing: spacing: is "),
        (["A", "B", "--spacing", "x +"], 2, "error: --spacing: "),
        (["A", "B", "A"], 2, "unexpected extra argument"),
    ],
)
def test_errors_name_the_file_or_the_option(arguments, exit_code, message, files):
    paths = {"A": files[0], "B": files[1]}
    code, text, said = run(*(paths.get(argument, argument) for argument in arguments))
    assert (code, text) == (exit_code, "")
    assert message in said


def test_a_target_spacing_that_is_not_positive_is_named(files, tmp_path):
    mesh = files[2]
    write_file(mesh, {"target_spacing": np.zeros(len(mesh.triangles))}, {}, tmp_path / "zero.vtu")
    code, _, said = run(tmp_path / "zero.vtu", files[1])
    assert code == 2
    assert re.search(r"zero\.vtu: target_spacing is not positive", said)


def test_cells_that_are_no_faces_are_told(files, tmp_path):
    points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    mixed = meshio.Mesh(points, [("triangle", [(0, 1, 2)]), ("tetra", [(0, 1, 2, 3)])])
    mixed.write(tmp_path / "mixed.vtu")
    code, _, said = run(files[0], tmp_path / "mixed.vtu")
    assert code == 0
    assert "mixed.vtu: cells that are no triangles or quadrilaterals are left out: tetra" in said


def written(folder, name, *triangles):
    meshio.Mesh([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [("triangle", list(triangles))]).write(folder / name)
    return folder / name


def test_triangles_that_turn_both_ways_are_told_and_areas_do_not_cancel(files, tmp_path):
    mixed = written(tmp_path, "mixed.vtk", (0, 1, 2), (0, 3, 2))
    code, text, said = run(mixed, "--json")
    assert (code, json.loads(text)["area"]) == (0, 1)
    warning = f"warning: {mixed}: 1 triangle turns the other way than the rest, the first at (0.333333, 0.666667): "
    assert said.startswith(warning)
    assert warning in run(mixed)[2]
    assert warning in run(files[0], mixed)[2]


@pytest.mark.parametrize("triangles", [[(0, 1, 2), (0, 2, 3)], [(0, 2, 1), (0, 3, 2)], [(0, 2, 1), (0, 0, 1)]])
def test_a_mesh_may_turn_either_way(triangles, tmp_path):
    code, text, said = run(written(tmp_path, "turned.vtk", *triangles), "--json")
    assert (code, "turns" in said) == (0, False)
    assert json.loads(text)["area"] == sum(len(set(triangle)) == 3 for triangle in triangles) / 2


def test_the_fewer_triangles_are_the_inverted_ones(files):
    mesh = files[3]
    for most in (mesh.triangles, mesh.triangles[:, ::-1]):
        turned = most.copy()
        turned[[5, 9]] = turned[[5, 9], ::-1]
        assert inverted(mesh.points, turned).tolist() == [5, 9]


@pytest.mark.parametrize("name", ["empty.vtk", "empty.msh", "empty.vtu"])
def test_an_empty_file_is_told_to_be_so(name, tmp_path):
    (tmp_path / name).touch()
    assert run(tmp_path / name) == (5, "", f"error: {tmp_path / name}: is empty\n")


@pytest.mark.parametrize("width", [36, 40, 60, 76, 200])
def test_histograms_fit_the_terminal(width, monkeypatch):
    stream = io.StringIO()
    monkeypatch.setattr(console, "output", Console(file=stream, width=width, soft_wrap=True, _environ={}))
    counted = histogram(np.repeat([0.05, 0.95], [1, 8]), 0, 1, 10)
    show_comparison(["a", "b"], [], {"quality": [counted, counted]})
    lines = stream.getvalue().splitlines()
    (fullest,) = [line for line in lines if line.startswith("0.90 to 1.00")]
    assert fullest.split()[-1] == "█" * min((width - 32) // 2, 22)
    assert fullest.count("88.9%") == 2
    assert max(map(len, lines)) <= width


def test_bars_end_at_eighths_of_a_character(monkeypatch):
    stream = io.StringIO()
    monkeypatch.setattr(console, "output", Console(file=stream, width=100, soft_wrap=True, _environ={}))
    shares = np.repeat([0.05, 0.15, 0.95], [1, 3, 8])
    both = [histogram(shares, 0, 1, 10), histogram(shares[:4], 0.0, 1.0, 10)]
    show_comparison(["a", "b"], [], {"quality": both})
    lines = {line[:12].strip(): line[12:].split() for line in stream.getvalue().splitlines()}
    # Of 12 values the largest share is that of 3 among 4: 22 characters; 8 of 12 are 19 and 4/8, rounded.
    assert lines["0.90 to 1.00"] == ["66.7%", "█" * 19 + "▌", "0.0%"]
    assert lines["0.10 to 0.20"] == ["25.0%", "█" * 7 + "▍", "75.0%", "█" * 22]
    assert "below 0.00" not in lines


# What it is made of


def test_means_at_edges_agree_with_a_loop(files):
    mesh, target = files[2], files[4]
    sides, counts = unique_edges(mesh.triangles)
    means = edge_means(mesh.triangles, target)
    for k in range(0, len(sides), 7):
        mine = [t for t, triangle in enumerate(mesh.triangles.tolist()) if {*sides[k].tolist()} <= {*triangle}]
        assert len(mine) == counts[k]
        assert means[k] == pytest.approx(target[mine].mean(), rel=1e-14)


@pytest.mark.parametrize(("least", "start"), [(0.05, 0.0), (0.47, 0.4), (0.75, 0.7), (0.99, 0.8)])
def test_a_scale_begins_at_a_round_number_below_nearly_all(least, start):
    ratios = np.linspace(least, 1, 1000)
    assert lowest_shown(ratios) == pytest.approx(start)
    assert lowest_shown(np.append(ratios, 0.001)) == pytest.approx(start)


def test_histograms_count_every_value_once():
    values = np.array([-1, 0, 0.05, 0.1, 0.95, 1, 1 + 1e-12, 7])
    counted = histogram(values, 0, 1, 10)
    assert (counted.below, counted.above, counted.total) == (1, 2, 8)
    assert counted.counts.tolist() == [2, 1, *[0] * 7, 2]
    rounded = quality_histogram(np.array([0.86, 1 + 1e-16, 1 + 1e-9]), 4, 0.8)
    assert (rounded.counts.tolist(), rounded.above) == ([0, 1, 0, 2], 0)


def test_a_mesh_is_measured_as_its_file_has_it(files):
    a, _, first, *_ = files
    found = comparison.compared(a, read_mesh(a).mesh, read_mesh(a).cell_data, None)
    assert np.array_equal(np.sort(found.quality), np.sort(radius_ratios(first.points, first.triangles)))
    assert len(found.spacing) == len(unique_edges(first.triangles)[0])


def test_quality_in_the_metric_of_a_file(tmp_path):
    mesh = holed_square()
    count = len(mesh.triangles)
    tensors = {"metric_11": np.full(count, 36.0), "metric_12": np.zeros(count), "metric_22": np.full(count, 9.0)}
    write_file(mesh, tensors, {}, tmp_path / "long.vtu")
    code, out, _ = run(tmp_path / "long.vtu", "--metric", "--json")
    assert code == 0
    figures = json.loads(out)
    stretched = radius_ratios(mesh.points * [6, 3], mesh.triangles)
    assert figures["quality"]["mean"] == pytest.approx(stretched.mean())
    assert figures["quality"]["angle_min"] == pytest.approx(45)
    along = mesh.points[unique_edges(mesh.triangles)[0]] * [6, 3]
    assert figures["spacing"]["mean"] == pytest.approx(np.hypot(*(along[:, 1] - along[:, 0]).T).mean())
    assert run(tmp_path / "long.vtu", "--metric")[0] == 0


def test_layers_do_not_count_in_a_metric(tmp_path):
    case = """
    domain: {outer: {rectangle: [0, 0, 2, 1], labels: [bottom, right, top, left]}}
    spacing: 0.1
    layers: [{on: bottom, first: 0.002, growth: 1.3, until: isotropic}]
    metric: {angle: 0, along: 0.1, across: "0.02+0.1*y"}
    """
    result = mesh_case(load_case("a.yaml", text=case))
    write_file(result.mesh, result.fields, {}, tmp_path / "a.vtu")
    code, out, error = run(tmp_path / "a.vtu", "--metric", "--json")
    assert code == 0
    assert "triangles of boundary layers are left out, as in reports" in error.replace("\n", " ")
    found = json.loads(out)
    assert found["quality"]["mean"] == pytest.approx(result.report.quality["mean"], abs=1e-3)
    assert found["spacing"]["std"] == pytest.approx(result.report.spacing["std"], abs=5e-3)


def test_a_metric_that_is_not_there_is_told(tmp_path):
    write_file(holed_square(), {}, {}, tmp_path / "plain.vtu")
    code, _, error = run(tmp_path / "plain.vtu", "--metric")
    assert code == 2
    assert "holds no metric" in " ".join(error.split())
    code, _, error = run(tmp_path / "plain.vtu", tmp_path / "plain.vtu", "--metric")
    assert code == 2
    assert "it goes with one mesh" in " ".join(error.split())


def test_the_share_of_obtuse_triangles_is_told(files):
    _, b, _, second, _ = files
    share = (angles(second.points, second.triangles).max(axis=1) > 90 + 1e-9).mean()
    assert json.loads(run(b, "--json")[1])["quality"]["obtuse_fraction"] == share > 0
    assert f", {share:.1%} of the triangles are obtuse" in run(b)[1]


def test_right_angles_are_not_obtuse():
    square = Measures(np.array([[0.1, 0.3], [0.4, 0.3], [0.4, 0.6], [0.1, 0.6]]), np.array([[0, 1, 2], [0, 2, 3]]))
    assert square.obtuse_fraction == 0
