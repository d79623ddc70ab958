import re
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import pytest
from paths import ROOT

from benchmarks.paper import runs as benchmark_runs
from benchmarks.paper.__main__ import main
from benchmarks.paper.costs import excess, priced, reduction
from benchmarks.paper.course import course, variants
from benchmarks.paper.figures import DRAWINGS
from benchmarks.paper.page import SECTIONS, page
from benchmarks.paper.published import CASES, COMPARISONS, ROWS, TABLE_1, TABLE_4, TABLES, VARIANTS, Comparison, Row
from benchmarks.paper.runs import CONFIGS, SEEDS, Runs, measured, profiled
from benchmarks.paper.verdicts import ABOVE, claim_verdict, round_verdict, verdict
from bubblemesh.case import load_case
from bubblemesh.run.pipeline import Result

ROOT = ROOT
ROW = Row("table-4", "FNPBS", 187.156, 1420, 712, 0.9435, note="why")
COST = 1000


def report_of(initial=1420, nodes=712, quality=0.95, cost=COST):
    """A report with the rounds of Table 4 but for the last one, which ends as told."""
    states = [(state.nodes, state.quality) for state in TABLE_4[:-1]] + [(nodes, quality)]
    return {
        "initial": {"nodes": initial, "quality_mean": TABLE_4[0].quality, "quality_min": 0.5},
        "rounds": [
            {
                "iterations": after.iterations - before.iterations,
                "nodes_before": states[number][0],
                "nodes_after": states[number + 1][0],
                "quality_mean": states[number + 1][1],
                "quality_min": 0.5,
                "force_evaluations": 2 * states[number][0] * (after.iterations - before.iterations),
                "seconds": 0.1,
            }
            for number, (before, after) in enumerate(pairwise(TABLE_4))
        ],
        "nodes": nodes,
        "boundary_nodes": 59,
        "ideal_nodes": 655.4,
        "force_evaluations": cost,
        "quality": {"mean": quality},
    }


def runs_of(*reports):
    results = tuple(Result(mesh=None, fields={}, report=report, speeds=()) for report in reports)
    return Runs(case=None, results=results, seconds=(1.0,) * len(results))


def as_published(row):
    """Runs that end as the paper says."""
    figures = {"initial": row.initial or 1000, "nodes": row.final or 500, "quality": row.quality or 0.95}
    return runs_of(*(report_of(**figures) for _ in SEEDS))


@pytest.fixture(scope="module")
def all_runs():
    return {name: as_published(ROWS.get(name, ROW)) for name in CASES}


@pytest.fixture(scope="module")
def text(all_runs):
    return page(all_runs, TABLE_1, DRAWINGS.values())


def section(text, title):
    """Cells of the table below a heading, its header left out."""
    body = text.split(f"## {title}\n", 1)[1].split("\n## ", 1)[0]
    lines = [line for line in body.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


@pytest.mark.parametrize(
    ("figures", "expected"),
    [
        ({}, "reproduced"),
        ({"quality": 0.9435}, "reproduced"),
        ({"quality": 0.9435 + ABOVE}, "reproduced"),
        ({"quality": 0.9436 + ABOVE}, "better"),
        ({"nodes": 719}, "reproduced"),
        ({"nodes": 705}, "reproduced"),
        ({"nodes": 720}, "not reproduced: final nodes +1.1% (why)"),
        ({"nodes": 704}, "not reproduced: final nodes -1.1% (why)"),
        ({"initial": 1419}, "not reproduced: initial nodes -1 (why)"),
        ({"quality": 0.9434}, "not reproduced: mean q -0.0001 (why)"),
        ({"quality": 0.97, "nodes": 720}, "not reproduced: final nodes +1.1% (why)"),
        (
            {"initial": 1432, "nodes": 783, "quality": 0.9},
            "not reproduced: initial nodes +12, final nodes +10.0%, mean q -0.0435 (why)",
        ),
    ],
)
def test_verdict_of_a_row(figures, expected):
    assert verdict(ROW, runs_of(report_of(**figures))) == expected


def test_verdict_is_that_of_the_median():
    few, middle, many = (report_of(nodes=nodes) for nodes in (650, 712, 800))
    assert verdict(ROW, runs_of(many, few, middle)) == "reproduced"
    assert verdict(ROW, runs_of(many, few, many)).startswith("not reproduced: final nodes +12.4%")


def test_verdict_has_the_tolerance_of_its_table():
    run = runs_of(report_of(nodes=616))
    assert verdict(Row("", "", final=587), run, 0.05) == "reproduced"
    assert verdict(Row("", "", final=587), run, 0.04) == "not reproduced: final nodes +4.9%"


def test_a_row_without_figures_has_no_verdict():
    assert verdict(Row("", "", seconds=3.0), runs_of(report_of())) == "not in the paper"


@pytest.mark.parametrize(
    ("nodes", "quality", "expected"),
    [
        (1226, 0.8562, "reproduced"),
        (1178, 0.8762, "reproduced"),
        (1227, 0.8562, "not reproduced: nodes +2.1%"),
        (1177, 0.8562, "not reproduced: nodes -2.1%"),
        (1202, 0.8561, "not reproduced: mean q -0.0001"),
        (1202, 0.8763, "better"),
    ],
)
def test_verdict_of_a_round(nodes, quality, expected):
    assert round_verdict(TABLE_4[1], nodes, quality) == expected


def test_verdict_of_the_start_takes_the_exact_count():
    assert round_verdict(TABLE_4[0], 1420, 0.9743, tolerance=0) == "reproduced"
    assert round_verdict(TABLE_4[0], 1421, 0.9743, tolerance=0) == "not reproduced: nodes +0.1%"


def test_verdict_of_a_claim():
    claim = Comparison("", "", "", 0.7)
    assert claim_verdict(claim, 0.7) == "reproduced"
    assert claim_verdict(claim, 0.615) == "not reproduced: 8.5 % short"


def test_one_cost_read_in_two_ways():
    assert reduction(100, 25) == 0.75
    assert excess(100, 25) == 3.0
    assert reduction(None, 25) is excess(100, None) is None


def test_the_papers_rounds_have_the_papers_price():
    assert priced(runs_of(report_of())) == pytest.approx(187.156)


def test_boundary_nodes_follow_from_nodes_and_elements():
    assert [TABLE_4[number].boundary_nodes for number in (0, 10)] == [80, 59]


def test_every_published_row_has_a_case_of_its_own():
    assert len(ROWS) == sum(len(table.rows) for table in TABLES)


@pytest.mark.parametrize("name", CASES)
def test_every_published_case_loads(name):
    assert load_case(CONFIGS / f"{name}.yaml").name == Path(name).name


def test_every_case_of_a_table_is_published():
    files = {str(path.relative_to(CONFIGS).with_suffix("")) for path in CONFIGS.glob("*/*.yaml")}
    assert files <= set(CASES)


@pytest.mark.parametrize("table", TABLES, ids=lambda table: table.title)
def test_page_has_a_line_for_each_row(table, text):
    cells = section(text, table.title)
    assert [line[0] for line in cells] == [row.label for row in table.rows]
    for line, row in zip(cells, table.rows, strict=True):
        assert [line[1], line[3], line[6], line[8]] == [
            "" if figure is None else str(figure) for figure in (row.initial, row.final, row.rounds, row.quality)
        ]
        assert line[-1] in ("reproduced", "not in the paper")


def test_page_gives_the_spread_over_the_seeds(all_runs):
    spread_out = runs_of(*(report_of(nodes=nodes, quality=q) for nodes, q in ((700, 0.95), (720, 0.97), (710, 0.96))))
    line = section(
        page(all_runs | {"table-1": spread_out}, TABLE_1, ()), "Traditional method against FNPBS (Example 3)"
    )[1]
    assert line[4:6] == ["710 (700 to 720)", f"{710 / 655.4:.3f}"]
    assert line[9] == "0.9600 (0.9500 to 0.9700)"


def test_course_has_a_line_for_each_round():
    run = runs_of(*(report_of(nodes=nodes) for nodes in (712, 725, 690)))
    cells = section(course(run), "Table 4: FNPBS on Example 3, round by round")
    assert [line[0] for line in cells] == [str(number) for number in range(11)]
    assert [line[1] for line in cells] == [str(state.nodes) for state in TABLE_4]
    assert cells[0][7:] == ["", "", "", "reproduced"]
    assert cells[1][3:] == ["+0.0%", "1.834", "0.8562", "0.8562", "1.00", "1.00", "1.00", "reproduced"]
    assert cells[2][7:10] == ["0.64", f"{1202 / 1420:.2f}", "1.00"]
    assert cells[10][2] == "712 (690 to 725)"
    assert cells[10][8] == f"{2 * 712 / 1420:.2f}"


def test_variants_stand_below_the_papers_figures(all_runs):
    cells = section(variants(all_runs), "What Table 4 depends on")
    assert [line[0] for line in cells] == ["paper", *VARIANTS.values()]
    assert cells[0][1:] == ["1202", "1013", "847", "712", "0.8562", "0.8268", "0.8230", "0.9435", "59"]


def test_comparisons_are_between_published_rows():
    assert {name for comparison in COMPARISONS for name in (comparison.dear, comparison.cheap)} <= set(ROWS)


def test_costs_are_read_in_both_ways(all_runs):
    dear = {name: runs_of(report_of(cost=COST * 5 // 2)) for name in ("table-5/example-3-fnpbs", "table-1")}
    cells = section(page(all_runs | dear, TABLE_1, ()), "Costs, side by side")
    assert [line[0] for line in cells] == [comparison.label for comparison in COMPARISONS]
    by_label = {line[0]: line[1:] for line in cells}
    assert by_label["Example 3: FNPBS, accelerated"] == [
        *("70 %", "84 %", "60 %", "0 %", "not reproduced: 10.0 % short"),
        *("537 %", "150 %", "0 %", "reproduced"),
    ]
    assert by_label["Example 3: BPM, FNPBS"][4] == "reproduced"


def test_links_of_the_page_lead_to_its_headings(text):
    anchors = {re.sub(r"[^\w\- ]", "", line[3:].lower()).replace(" ", "-") for line in headings(text)}
    links = re.findall(r"\]\(#([\w-]+)\)", text)
    assert links
    assert set(links) <= anchors


def test_shipped_page_has_all_sections_and_figures(text):
    assert headings((ROOT / "docs/reproduction.md").read_text()) == headings(text)
    assert {path.name for path in (ROOT / "docs/figures").glob("fig-*")} == {
        drawing.file for drawing in DRAWINGS.values()
    }


def headings(text):
    return [line for line in text.splitlines() if line.startswith("## ")]


def test_cases_that_differ_by_name_only_run_once(monkeypatch):
    asked, told = [], []

    def mesh_case(case):
        asked.append((case.name, case.packing["seed"]))
        return SimpleNamespace(report={})

    monkeypatch.setattr(benchmark_runs, "mesh_case", mesh_case)
    found = measured(["table-4", "table-2/w1-1", "table-3/w2-0.8", "table-4"], told.append)
    assert asked == [(name, seed) for seed in SEEDS for name in ("table-4", "w2-0.8")]
    assert told == [
        f"[{2 * seed + number}/6] {name}, seed {seed}"
        for seed in SEEDS
        for number, name in enumerate(("table-4", "table-3/w2-0.8"), start=1)
    ]
    assert list(found) == ["table-4", "table-2/w1-1", "table-3/w2-0.8"]
    assert found["table-4"].results is not found["table-3/w2-0.8"].results
    assert [a is b for a, b in zip(found["table-4"].results, found["table-2/w1-1"].results, strict=True)] == [True] * 3


@pytest.fixture
def stubbed(monkeypatch):
    """Names of the cases that are run; each ends as the paper says."""
    asked = []

    def mesh_case(case):
        asked.append(case.name)
        return Result(mesh=None, fields={}, report=report_of(), speeds=())

    monkeypatch.setattr(benchmark_runs, "mesh_case", mesh_case)
    return asked


def test_one_table_is_printed_alone_and_its_progress_on_the_error_stream(stubbed, capsys, all_runs):
    main(["--table", "3"])
    out, told = capsys.readouterr()
    assert headings(out) == ["## Table 3: interior weight w2 (Example 3, FNPBS)"]
    assert [line[0] for line in section(out, headings(out)[0][3:])] == [row.label for row in TABLES[1].rows]
    assert stubbed == [Path(row.case).name for row in TABLES[1].rows] * len(SEEDS)
    assert told.splitlines()[0] == "[1/15] table-3/w2-1, seed 0"


def test_a_table_of_several_parts_is_written_whole(stubbed, tmp_path):
    main(["--table", "4", "-o", f"{tmp_path}/table.md"])
    assert [line[3:10] for line in headings((tmp_path / "table.md").read_text())] == ["Table 4", "What Ta"]
    assert len(stubbed) == len(VARIANTS) * len(SEEDS)


def test_one_figure_is_drawn_alone(stubbed, tmp_path):
    main(["--figure", "2", "-o", f"{tmp_path}/new/viscosity.svg"])
    assert (tmp_path / "new/viscosity.svg").read_text().startswith("<?xml")
    assert stubbed == []
    main(["--figure", "7", "-o", f"{tmp_path}/quality.png"])
    assert stubbed == ["example-3-fnpbs"] * len(SEEDS)
    assert [path.name for path in tmp_path.glob("*.*")] == ["quality.png"]


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["--help"], 0, "docs/reproduction.md"),
        (["--table", "6"], 2, "invalid choice: '6'"),
        (["--figure", "4"], 2, "invalid choice: 4"),
        (["--table", "1", "--figure", "2"], 2, "not allowed with"),
    ],
)
def test_arguments_are_explained_or_refused_before_anything_runs(arguments, code, message, stubbed, capsys):
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == code
    assert message in "".join(capsys.readouterr())
    assert stubbed == []


def test_every_table_that_can_be_asked_for_is_of_known_cases():
    assert {case for section in SECTIONS for case in section.cases} <= set(CASES)
    assert {case for drawing in DRAWINGS.values() for case in drawing.cases} <= set(CASES)


def test_every_stage_of_table_1_takes_time():
    text = (
        "domain: {outer: {rectangle: [0, 0, 1, 1]}}\nspacing: 0.2\nschedule: {rounds: 2, iterations: 5}\nmethod: bpm\n"
    )
    shares = profiled(load_case("square.yaml", text=text))
    assert list(shares) == list(TABLE_1)
    assert min(shares.values()) > 0
    assert sum(shares.values()) == pytest.approx(100)
