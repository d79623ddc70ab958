import sys

import numpy as np
import pytest
from paths import ROOT

from benchmarks.peers import __main__ as peers
from benchmarks.peers import goals, with_distmesh, with_jigsaw, with_triangle
from benchmarks.peers.clock import Clock, peak_mb
from benchmarks.peers.figures import CAPTIONS, draw
from benchmarks.peers.matheval import matheval
from benchmarks.peers.measures import Figures, FlawError, measured
from benchmarks.peers.page import page
from benchmarks.peers.rows import COLUMNS, row
from benchmarks.peers.runs import CASES, CONFIGS, SIZES, CaseRuns, Run, problems, ran
from benchmarks.peers.tools import OURS, REFERENCE, TOOLS
from bubblemesh.case import load_case
from bubblemesh.meshes.quality import Measures, shape_quality
from bubblemesh.problem.prepare import prepare
from bubblemesh.spacing.expression import Expression

ROOT = ROOT
PAPER = ("example-1", "example-2", "example-3", "example-4", "dense")
FIGURES = Figures(nodes=1000, mean=0.99, p01=0.9, least=0.8, irregular=0.1, edge=1.0, spread=0.07, astray=0.0)
OTHERS = Figures(nodes=1100, mean=0.98, p01=0.8, least=0.7, irregular=0.2, edge=0.9, spread=0.09, astray=1e-3)


def case_of(name):
    return load_case(CONFIGS / f"{name}.yaml")


def run_of(seconds, **more):
    return Run(seconds, ready_mb=80, peak_mb=100, **({"figures": FIGURES} | more))


class TestCases:
    @pytest.mark.parametrize("name", PAPER)
    def test_domain_and_spacing_are_the_papers(self, name):
        ours, paper = case_of(name), load_case(ROOT / "configs" / "paper" / f"{name}.yaml")
        assert ours.domain == paper.domain
        x, y = np.random.default_rng(0).uniform(-3, 3, (2, 100))
        mine, theirs = (Expression.parse(str(case.spacing), case.parameters)(x, y) for case in (ours, paper))
        np.testing.assert_allclose(mine, theirs, rtol=1e-14)

    def test_every_case_has_a_file_and_no_options_of_a_method(self):
        assert {path.stem for path in CONFIGS.glob("*.yaml")} == set(CASES)
        assert not any(case_of(name).packing for name in CASES)

    @pytest.mark.long
    def test_sizes_are_those_of_the_names(self):
        for name in SIZES[1:]:
            assert prepare(case_of(name)).survey.ideal_nodes == pytest.approx(float(name.split("-")[-1]), rel=0.05)

    def test_the_largest_ones_are_left_out(self):
        assert list(problems(["example-3-900000", "example-4"], 1e5)) == ["example-4"]

    def test_goals_speak_of_cases_there_are(self):
        assert {*(case for case, _ in goals.SHAPES), *(case for case, *_ in goals.COSTS), *goals.GROWTH[1:3]} <= set(
            CASES
        )


class TestMathEval:
    @pytest.mark.parametrize(
        "text",
        [
            "0.1",
            "h*(1 + abs(x - 0.5)/7)",
            "-x**2 + 3e-7*y",
            "hypot(x + 0.4, -y)",
            "min(x, y, 0.2)",
            "sqrt(x**2 + y**2)/8",
        ],
    )
    def test_it_is_the_same_function(self, text):
        parameters = {"h": -0.003}
        x, y = np.random.default_rng(1).uniform(0, 1, (2, 20))
        names = {"sqrt": np.sqrt, "abs": np.abs, "min": lambda *parts: np.minimum.reduce(np.broadcast_arrays(*parts))}
        theirs = eval(matheval(text, parameters).replace("^", "**"), names | {"x": x, "y": y})
        np.testing.assert_allclose(theirs + 0 * x, Expression.parse(text, parameters)(x, y), rtol=1e-14)

    def test_what_gmsh_lacks_is_named(self):
        with pytest.raises(ValueError, match=r"where\(x > 0, 1, 2\)"):
            matheval("1 + where(x > 0, 1, 2)", {})

    def test_numbers_have_no_exponent(self):
        assert matheval("1e-7*x", {}) == "(0.0000001*x)"


class TestRows:
    CASE = CaseRuns(
        1000.0,
        {
            OURS: (run_of(1.0, floor=0.1), run_of(2.0, floor=0.1), run_of(9.0, floor=0.1)),
            REFERENCE: (run_of(0.5, figures=OTHERS), run_of(2.0), run_of(3.0)),
            "triangle": (Run(failure="no mesh within 20 minutes"),),
        },
        whole=(0.7, 0.9, 0.6),
    )

    def test_ratios_are_medians_over_the_repeats(self):
        ours = row(self.CASE, OURS)
        assert ours["seconds"] == 2
        assert ours["to_reference"] == 2
        assert ours["to_floor"] == pytest.approx(20)
        assert row(self.CASE, REFERENCE)["to_floor"] == pytest.approx(20)
        assert ours["density"] == 1

    def test_a_failed_tool_says_why(self):
        failed = row(self.CASE, "triangle")
        assert failed.failure == "no mesh within 20 minutes"
        assert COLUMNS["mean"].shown(failed["mean"]) == ""

    def test_verdicts_tell_the_margin(self):
        column = COLUMNS["mean"]
        assert goals.Goal("a", column, 0.9951, low=0.993).verdict == "met by 0.0021"
        assert goals.Goal("a", column, 0.9, low=0.993).verdict == "**missed** by 0.093"
        assert goals.Goal("a", column, 1.04, 0.97, 1.03).verdict == "**missed** by 0.01"
        assert goals.Goal("a", column, float("nan"), low=0.993).verdict == "not measured"
        assert goals.Goal("a", COLUMNS["peak_mb"], 400.0, high=1500.0).verdict == "met by 1100"
        assert goals.Goal("a", column, 0, 0.97, 1.03).bounds == "0.9700 to 1.0300"

    def test_goals_take_our_figures(self):
        shapes = {(goal.case, goal.column.title): goal for goal in goals.shapes({"example-1": self.CASE})}
        assert shapes["example-1", "mean q"].verdict == "**missed** by 0.005"
        assert shapes["example-4", "mean q"].verdict == "not measured"
        assert shapes["example-3, best", "mean q"].verdict == "not measured"
        whole = [goal for goal in goals.costs({"example-1": self.CASE}) if goal.case == "example-1"]
        assert [goal.verdict for goal in whole] == ["met by 0.1"]

    def test_the_page_shows_all(self, tmp_path):
        failed = CaseRuns(300.0, {OURS: (Run(failure="unknown method"),)})
        results = {"example-1": self.CASE, "example-4": failed}
        rows = {name: {tool: row(case, tool) for tool in case.tools} for name, case in results.items()}
        text = page(results, rows, "python -m benchmarks.peers", "multilevel", 3)
        assert "| Triangle | failed: no mesh within 20 minutes |" in text
        _, picture, _, told, after, *_ = text.split("\n\n")
        assert picture.startswith("![")
        assert "- **Mean quality** (1 is equilateral): 0.9900 to 0.9900; the best peers have 0.9800 to 0.9800." in told
        assert "bubblemesh is ahead on 1 of 1 cases" in told
        assert after == "## How it was measured"
        assert "but for Gmsh Frontal-Delaunay (up to 0.001 d)" in text
        assert "### example-4: N_id = 300" in text
        assert (
            "- **CPU s**: the best peer is Gmsh Frontal-Delaunay on example-1 (2). bubblemesh is ahead on 0 of 1"
            in text
        )
        draw(rows, ["example-1"], tmp_path / "figures")
        assert {path.name for path in (tmp_path / "figures").iterdir()} == set(CAPTIONS)


def test_the_shipped_page_leads_with_a_picture_and_a_few_lines():
    _, picture, _, told, after, *_ = (ROOT / "docs/peers.md").read_text(encoding="utf-8").split("\n\n")
    assert next(iter(CAPTIONS)) in picture
    assert 8 <= len(told.splitlines()) <= 10
    assert after == "## How it was measured"


class TestMeasures:
    SQUARE = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)

    def problem(self):
        text = "domain: {outer: {rectangle: [0, 0, 1, 1]}}\nspacing: 1"
        return prepare(load_case("square.yaml", text=text))

    def test_two_triangles(self):
        figures = measured(self.SQUARE, np.array([[0, 1, 2], [0, 2, 3]]), self.problem())
        assert figures.nodes == 4
        assert figures.least == pytest.approx(2 * (np.sqrt(2) - 1))
        assert figures.astray == 0

    @pytest.mark.parametrize(
        ("triangles", "flaw"),
        [
            ([[0, 1, 2], [0, 3, 2], [0, 1, 2]], "1 inverted"),
            ([[0, 1, 2]], "not a surface"),
            ([[0, 1, 2]] * 3, "more than two"),
        ],
    )
    def test_flaws(self, triangles, flaw):
        with pytest.raises(FlawError, match=flaw):
            measured(self.SQUARE, np.array(triangles), self.problem())

    def test_the_clock_counts_processor_time(self):
        with Clock() as clock:
            sum(range(10**6))
        assert 0 < clock.seconds < 10
        assert 0 < clock.ready_mb <= peak_mb()


class TestTools:
    def test_distmesh_makes_a_valid_mesh(self):
        text = "domain: {outer: {rectangle: [0, 0, 1, 1]}, holes: [{circle: {center: [0.5, 0.5], radius: 0.2}}]}\n"
        case = load_case("plate.yaml", text=text + "spacing: 0.1")
        problem = prepare(case)
        figures = measured(*with_distmesh.mesh(case, Clock()), problem)
        assert figures.mean > 0.9
        assert figures.nodes == pytest.approx(problem.survey.ideal_nodes, rel=0.15)

    def test_boundary_nodes_are_equidistributed(self):
        problem = prepare(case_of("example-1"))
        points, edges = with_triangle.boundary_nodes(
            problem.domain.boundary, problem.spacing, problem.survey.extremes.minimum
        )
        assert len(points) == len(edges) == 2 * (20 + 40)
        np.testing.assert_allclose(np.hypot(*(points[edges[:, 0]] - points[edges[:, 1]]).T), 0.1)

    def test_triangle_keeps_its_angles(self):
        pytest.importorskip("triangle", reason="Triangle is not installed")
        case = case_of("example-2")
        points, triangles = with_triangle.mesh(case, Clock())
        assert measured(points, triangles, prepare(case)).nodes > 400
        assert shape_quality(Measures(points, triangles)).angle_min > 29

    @pytest.mark.long
    @pytest.mark.parametrize("name", ["example-2", "example-4"])
    def test_gmsh_keeps_the_arcs(self, name):
        try:
            import gmsh  # noqa: F401
        except (ImportError, OSError) as error:
            pytest.skip(f"Gmsh cannot be imported: {error}")
        (problem,) = problems([name], 1e5).values()
        (run,) = ran(problem, [REFERENCE], "accelerated", 1, print).tools[REFERENCE]
        assert not run.failure
        assert run.figures.astray < 1e-9
        assert run.figures.nodes == pytest.approx(problem.survey.ideal_nodes, rel=0.2)
        assert 0 < run.seconds < 10

    @pytest.mark.long
    def test_a_run_that_fails_says_why_and_is_not_repeated(self):
        told = []
        (problem,) = problems(["dense"], 1e5).values()
        found = ran(problem, ["bubblemesh-fast"], "sorting", 2, told.append)
        (run,) = found.tools["bubblemesh-fast"]
        assert "unknown method 'sorting'" in run.failure
        assert told == [f"dense 1/2 bubblemesh-fast: {run.failure}"]

    def test_tools_for_small_cases_are_left_out(self):
        (problem,) = problems(["example-3-9000"], 1e5).values()
        assert ran(problem, ["distmesh"], "accelerated", 1, print).tools == {}
        assert TOOLS["distmesh"].most_nodes < problem.survey.ideal_nodes

    def test_jigsaws_files(self, tmp_path, monkeypatch):
        """An executable that cuts the rectangle of the outline in two, if it finds the spacing where it belongs."""
        script = tmp_path / with_jigsaw.COMMAND
        script.write_text(f"#!{sys.executable}\n{JIGSAW}")
        script.chmod(0o755)
        monkeypatch.setenv("PATH", str(tmp_path))
        assert with_jigsaw.installed()
        text = "domain: {outer: {rectangle: [0, 0, 2, 1]}}\nspacing: 1 + x + 10*y"
        points, triangles = with_jigsaw.mesh(load_case("bar.yaml", text=text), Clock())
        assert sorted(points.tolist()) == [[0, 0], [0, 1], [2, 0], [2, 1]]
        assert triangles.tolist() == [[0, 1, 2], [0, 2, 3]]


JIGSAW = """
import sys
settings = dict(line.split(" = ") for line in open(sys.argv[1]).read().splitlines())
grid = open(settings["HFUN_FILE"]).read().split("VALUE=")[1].split()
assert grid[0] == "251001;1" and float(grid[1]) == 1 and float(grid[501]) == 11 and float(grid[-501]) == 3
points = open(settings["GEOM_FILE"]).read().split("POINT=4\\n")[1].splitlines()[:4]
lines = ["# a comment", "MSHID=3;euclidean-mesh", "NDIMS=2", "POINT=5", *points, "9;9;0", "EDGE2=1", "0;1;0"]
lines += ["TRIA3=2", "0;1;2;0", "0;2;3;0"]
open(settings["MESH_FILE"], "w").write("\\n".join(lines))
"""


def test_runs_of_other_cases_are_kept(monkeypatch, tmp_path):
    kept, page_of, asked = tmp_path / "runs.json", tmp_path / "peers.md", []

    def measured_now(problem, tools, method, repeats, tell):
        asked.append(problem.task.name)
        runs = {OURS: (run_of(2.0, floor=1.0),), REFERENCE: (run_of(1.0, figures=OTHERS), Run(failure="fell"))}
        return CaseRuns(1000, runs, (float(len(asked)),))

    monkeypatch.setattr(peers, "ran", measured_now)
    monkeypatch.setattr(peers, "draw", lambda *arguments: None)
    for case in ("example-2", "example-1", "example-2"):
        options = ["--case", case, "--tool", OURS, REFERENCE, "--results", str(kept), "-o", str(page_of)]
        monkeypatch.setattr(sys, "argv", ["peers", *options])
        peers.main()
    assert asked == ["example-2", "example-1", "example-2"]
    found = peers.RUNS.validate_json(kept.read_bytes())
    assert {name: case.whole for name, case in found.items()} == {"example-2": (3.0,), "example-1": (2.0,)}
    assert found["example-1"].tools[REFERENCE][1].failure == "fell"
    assert np.isnan(found["example-1"].tools[REFERENCE][1].seconds)
    text = page_of.read_text(encoding="utf-8")
    assert 0 < text.index("### example-1") < text.index("### example-2")
