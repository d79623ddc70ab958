"""Pictures of the requested spacing, and what an estimate tells."""

import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from commands import within
from invariants import check_mesh
from matplotlib.colors import LogNorm, Normalize

from bubblemesh.case import load_case
from bubblemesh.pictures.spacing_plots import draw_spacing, spacing_figure
from bubblemesh.problem.prepare import prepare
from bubblemesh.problem.ruling import ruling
from bubblemesh.run.assembly import previewed
from bubblemesh.run.estimate import estimate

WIDE = """
name: wide
domain: {outer: {rectangle: [0, 0, 2, 1], labels: [s, e, n, w]}, holes: [{circle: {center: [1.5, 0.5], radius: 0.2}}]}
spacing: "0.01 + 0.3*hypot(x - 0.5, y - 0.25)"
"""
NARROW = WIDE.replace("0.01 +", "0.3 +")
UNIFORM = WIDE.replace('"0.01 + 0.3*hypot(x - 0.5, y - 0.25)"', "0.1")
STEEP = """
domain: {outer: {rectangle: [0, 0, 2, 1]}, holes: [{circle: {center: [1.5, 0.5], radius: 0.02}}]}
spacing: {value: "x < 0.5 ? 0.02 : 0.2", growth: 0.2, nodes: 700}
""".replace("x < 0.5 ? 0.02 : 0.2", "0.02 if x < 0.5 else 0.2")
REFINED = """
domain: {outer: {rectangle: [0, 0, 2, 1]}, holes: [{circle: {center: [1.5, 0.5], radius: 0.02}}]}
spacing: 0.2
"""


def problem_of(text, *overrides):
    return prepare(load_case("-", text=text, overrides=overrides))


def extremes_of(problem):
    return problem.packing_extremes.both


def figure_of(problem, title=None):
    return spacing_figure(*previewed(problem), extremes_of(problem), title)


@pytest.mark.long
@pytest.mark.parametrize("spacing", ["1e-5 + 0.3*hypot(x - 0.5, y - 0.25)", "0.004", "50"])
def test_the_mesh_of_a_picture_is_never_large_and_never_coarse(spacing):
    mesh, _ = previewed(problem_of(WIDE, f"spacing={spacing}"))
    check_mesh(mesh)
    assert 2000 < len(mesh.points) < 40_000
    assert mesh.labels == ("s", "e", "n", "w", "hole-1")


def test_regions_lines_and_points_have_their_names():
    problem = problem_of("""
domain:
  outer: {rectangle: [0, 0, 4, 2], label: wall}
  region: matrix
  regions:
    - {name: fibre, ring: {circle: {center: [1, 1.2], radius: 0.3}}}
    - {name: x$y, ring: {rectangle: [0, 0, 4, 0.8]}}
  lines: [{path: [[3, 1.1], [3.5, 1.5]], label: crack}]
  points: [{at: [0.5, 1.8], label: well}]
spacing: 0.12
""")
    (axes, *_) = figure_of(problem).axes
    places = {text.get_text(): text.xy for text in axes.texts if text.get_text() in ("matrix", "fibre", "x$y", "well")}
    assert places["well"] == (0.5, 1.8)
    assert places["fibre"] == pytest.approx((1, 1.2), abs=0.1)
    assert 0.2 < places["x$y"][1] < 0.6
    assert places["matrix"][1] > 1
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["wall", "crack", "fibre-rim", "x$y-rim"]


def test_values_and_extremes_are_those_that_the_packing_goes_by():
    problem = problem_of(REFINED)
    mesh, spacing = previewed(problem)
    extremes = problem.packing_extremes
    np.testing.assert_allclose(spacing, problem.packing_spacing(mesh.points))
    assert extremes.maximum == pytest.approx(0.2)
    assert extremes.minimum == pytest.approx(0.02 * np.pi / 3, rel=0.05)
    assert np.hypot(extremes.minimum_at[0] - 1.5, extremes.minimum_at[1] - 0.5) < 0.03


@pytest.mark.parametrize(("text", "norm"), [(WIDE, LogNorm), (NARROW, Normalize)])
def test_colours_tell_the_spacing(text, norm):
    problem = problem_of(text)
    figure = figure_of(problem)
    axes, bar = figure.axes
    colours = axes.collections[-1]
    assert type(colours.norm) is norm
    assert bar.get_ylabel() + bar.get_xlabel() == "spacing d"
    figure.canvas.draw()
    pixels = np.asarray(figure.canvas.buffer_rgba())[::-1] / 255
    for point in ((0.3, 0.8), (1.0, 0.2), (1.9, 0.9), (0.1, 0.1)):
        column, row = np.rint(axes.transData.transform(point)).astype(int)
        expected = mpl.colormaps["viridis"](colours.norm(problem.packing_spacing(np.array([point]))[0]))
        np.testing.assert_allclose(pixels[row, column, :3], expected[:3], atol=0.03)
    column, row = np.rint(axes.transData.transform((1.5, 0.5))).astype(int)
    np.testing.assert_allclose(pixels[row, column, :3], 1)  # the hole


def test_what_sets_the_spacing_has_a_panel_of_its_own():
    terms = "{value: 0.1, near: {point: [0.5, 0.5], size: 0.01, growth: 0.1}, maximum: 0.08}"
    problem = problem_of(UNIFORM.replace("spacing: 0.1", f"spacing: {terms}"))
    mesh, spacing = previewed(problem)
    setters = ruling(problem, mesh.points[mesh.triangles].mean(axis=1))
    figure = spacing_figure(mesh, spacing, extremes_of(problem), ruling=setters)
    (first, second, bar) = figure.axes
    assert first.get_position().y0 > second.get_position().y1  # the domain is wide
    assert bar.get_xlabel() == "spacing d"
    told = [text.get_text() for text in second.get_legend().get_texts()]
    assert [name.split()[0] for name in told] == ["near", "maximum"]
    x, y = np.meshgrid(np.linspace(0, 2, 801), np.linspace(0, 1, 401))
    inside = np.hypot(x - 1.5, y - 0.5) > 0.2
    near = np.hypot(x - 0.5, y - 0.5) < 0.7  # where 0.01 + 0.1 times it is below 0.08
    assert float(told[0].split()[1].rstrip("%")) == pytest.approx(100 * near[inside].mean(), abs=2)
    figure.canvas.draw()
    pixels = np.asarray(figure.canvas.buffer_rgba())[::-1] / 255
    colours = [patch.get_facecolor() for patch in second.get_legend().get_patches()]
    for point, name in (((0.6, 0.5), 0), ((1.9, 0.9), 1)):
        column, row = np.rint(second.transData.transform(point)).astype(int)
        np.testing.assert_allclose(pixels[row, column, :3], colours[name][:3], atol=0.1)


def test_one_term_that_sets_it_everywhere_needs_no_panel():
    problem = problem_of(UNIFORM)
    mesh, spacing = previewed(problem)
    figure = spacing_figure(mesh, spacing, extremes_of(problem), ruling=["value"] * len(mesh.triangles))
    assert len(figure.axes) == 2  # the map and its bar


@pytest.mark.long
@pytest.mark.parametrize("low", [1.1e-6, 0.0013, 0.02, 70])
@pytest.mark.parametrize("ratio", [4.5, 9.9, 11, 80, 990, 1100, 1e6, 1e12])
@pytest.mark.parametrize("turn", [1, -1])
def test_numbers_at_a_long_scale_keep_apart(low, ratio, turn):
    shown, spacing = previewed(problem_of("domain: {outer: {rectangle: [0, 0, 3, 1]}}\nspacing: 1\n"))
    x, y = shown.points[:, ::turn].T
    mesh = replace(shown, points=np.column_stack([x, y]))
    places = mesh.points[spacing.argmin()], mesh.points[-1]
    high = ratio * low
    figure = spacing_figure(mesh, low * ratio ** (x / x.max()), ((low, places[0]), (high, places[1])))
    figure.canvas.draw()
    axis = figure.axes[1].xaxis if turn == 1 else figure.axes[1].yaxis
    ticks = [tick.label1 if turn == 1 else tick.label2 for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks())]
    ends = [text for text in ticks if text.get_text() and low <= float(text.get_text()) <= high]
    assert len(ends) >= 2
    boxes = sorted(text.get_window_extent().extents[[0, 2] if turn == 1 else [1, 3]].tolist() for text in ends)
    assert all(one[1] < other[0] for one, other in pairwise(boxes))


@pytest.mark.long
def test_extremes_are_marked_where_they_are():
    problem = problem_of(WIDE)
    axes = figure_of(problem, "A title").axes[0]
    places = [line.get_xydata()[0] for line in axes.lines]
    np.testing.assert_allclose(places, [(0.5, 0.25), problem.packing_extremes.maximum_at], atol=1e-3)
    assert [text.get_text() for text in axes.texts] == ["least 0.01", f"largest {problem.packing_extremes.maximum:.4g}"]
    assert axes.get_title() == "A title"
    assert {text.get_text() for text in axes.get_legend().get_texts()} == {"s", "e", "n", "w", "hole-1"}


@pytest.mark.long
def test_a_uniform_spacing_has_one_colour_and_no_marks():
    axes, _ = figure_of(problem_of(UNIFORM)).axes
    assert len(axes.lines) == len(axes.texts) == 0
    assert axes.collections[-1].norm.vmin < 0.1 < axes.collections[-1].norm.vmax


@pytest.mark.long
@pytest.mark.parametrize("ending", ["png", "svg", "pdf"])
def test_same_problem_same_bytes(tmp_path, ending):
    problem = problem_of(WIDE)
    mesh, spacing = previewed(problem)
    for name in ("a", "b"):
        path = tmp_path / name / f"d.{ending}"
        draw_spacing(mesh, spacing, extremes_of(problem), path, "wide")
    assert (tmp_path / "a" / f"d.{ending}").read_bytes() == (tmp_path / "b" / f"d.{ending}").read_bytes()


@pytest.mark.long
def test_an_estimate_tells_what_the_rules_changed_and_the_scale():
    found = estimate(problem_of(STEEP))
    assert found["node_target"]["nodes"] == 700
    assert found["expected_nodes"] == pytest.approx(700, rel=0.01)
    assert found["rules"]["ratio"] > 3
    x, y = found["rules"]["ratio_at"]
    assert np.hypot(x - 1.5, y - 0.5) < 0.05  # the tight curve is finer than the step
    assert "rules" not in estimate(problem_of(UNIFORM))


@pytest.mark.long
def test_an_estimate_tells_the_extremes_of_both_spacings():
    found = estimate(problem_of(REFINED))
    assert (found["spacing"]["minimum"], found["spacing"]["maximum"]) == (0.2, 0.2)
    assert found["packed_spacing"]["minimum"] == pytest.approx(0.021, abs=0.001)
    assert "packed_spacing" not in estimate(problem_of(UNIFORM))
    assert problem_of(UNIFORM).packing_extremes.maximum == 0.1


# The commands


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "wide.yaml").write_text(WIDE)
    return tmp_path


def command(*arguments, folder):
    done = within(*arguments, folder=folder)
    done.stdout, done.stderr = done.stdout.decode(), done.stderr.decode()
    return done


@pytest.mark.long
@pytest.mark.parametrize("start", [["check", "wide.yaml"], ["run", "wide.yaml", "--dry-run"]], ids=["check", "dry run"])
def test_the_picture_is_drawn_and_told(folder, start):
    done = command(*start, "--plot", "pictures/d.svg", "--json", folder=folder)
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert report["plot"] == "pictures/d.svg"
    assert report["spacing"]["minimum_at"] == pytest.approx([0.5, 0.25], abs=1e-3)
    assert "least 0.01" in (folder / "pictures" / "d.svg").read_text()
    assert "d.svg in pictures" in done.stderr
    assert "packed     0.01 at (0.5, 0.25) to 0.4" in done.stderr
    assert sorted(path.name for path in folder.iterdir()) == ["pictures", "wide.yaml"]


@pytest.mark.long
@pytest.mark.parametrize(
    ("arguments", "exit_code", "message"),
    [
        (["check", "wide.yaml", "--plot", "d.jpg"], 2, "d.jpg: unknown ending '.jpg' for a picture"),
        (["run", "wide.yaml", "--plot", "d.png"], 2, "--plot: draws the spacing of a dry run: add --dry-run"),
        (["check", "wide.yaml", "--plot", "wide.yaml/d.png"], 5, "cannot write into wide.yaml"),
        (["check", "wide.yaml", "--set", "spacing=-x", "--plot", "d.png"], 2, "spacing: is -"),
    ],
)
def test_errors_leave_no_picture(folder, arguments, exit_code, message):
    done = command(*arguments, folder=folder)
    assert done.returncode == exit_code, done.stderr
    assert message in done.stderr
    assert "Traceback" not in done.stderr
    assert [path.name for path in Path(folder).iterdir()] == ["wide.yaml"]
