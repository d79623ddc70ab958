"""Batches: where the results go, what the rows tell."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from batch_cases import names, table_in, write
from batches import (
    BAD,
    SMALL,
    Begun,
    Finished,
    Note,
    batch,
    events_of,
    lines_of,
    results_in,
    rows_of,
)
from paths import ROOT
from typer.testing import CliRunner

from bubblemesh import __version__
from bubblemesh.batch import BatchOptions
from bubblemesh.batch.row import FIGURES
from bubblemesh.case import overrides_of
from bubblemesh.cli import app
from bubblemesh.errors import CaseError, FileError


def test_all_results_and_the_summary_go_to_the_folder(here):
    write(here, cases__a=SMALL, cases__sub__b=SMALL + "sweep: {packing.seed: [1, 2]}\n")
    rows = rows_of("cases", folder="out.v2")
    assert [(row.case, row.exit_code, row.folder) for row in rows] == [
        ("a", 0, "."),
        ("b-seed=1", 0, "."),
        ("b-seed=2", 0, "."),
    ]
    meshes = [f"{row.case}{end}" for row in rows for end in (".msh", ".report.json")]
    assert names("out.v2") == sorted([*meshes, "summary.csv", "summary.jsonl"])
    assert names(here) == ["cases", "out.v2"]


@pytest.mark.parametrize(
    ("options", "endings"),
    [
        (("--for", "freefem", "--for", "calculix"), (".inp", ".mesh")),
        (("--format", "vtk"), (".vtk",)),
        (("--for", "su2", "--set", "output.order=1"), (".su2",)),
    ],
)
@pytest.mark.usefixtures("workers_in_threads")
def test_solvers_and_formats_are_chosen_over_all_cases(options, endings, here):
    write(here, a=SMALL, b=SMALL.replace("formats: [msh]", "for: getdp"))
    done = CliRunner().invoke(app, ["batch", ".", "-o", "out", "-j", "1", "-q", *options])
    assert done.exit_code == 0, done.stderr
    found = {Path(name).suffix for name in names("out")} - {".json", ".csv", ".jsonl"}
    assert found == set(endings)
    assert all(f"{case}{ending}" in names("out") for case in "ab" for ending in endings)


def test_unknown_solvers_and_two_ways_to_choose_are_refused_before_the_batch(here):
    write(here, a=SMALL)
    for options, message in (
        (("--for", "fenics"), "--for: unknown solver"),
        (("--for", "su2", "--format", "vtk"), "--format and --for exclude each other"),
    ):
        done = CliRunner().invoke(app, ["batch", ".", "-o", "out", *options])
        assert (done.exit_code, message in done.stderr) == (2, True)
    assert not Path("out").exists()


def test_without_a_folder_the_results_go_where_each_case_says(here):
    write(here, cases__a=SMALL.replace("formats", "directory: own, formats"), b=SMALL)
    rows = rows_of("cases", "b.yaml")
    assert [row.folder for row in rows] == ["cases/own", "."]
    assert names("cases/own") == ["a.msh", "a.report.json"]
    assert names(here) == ["b.msh", "b.report.json", "b.yaml", "cases", "summary.csv", "summary.jsonl"]


def test_two_cases_that_write_the_same_file_are_named_before_anything_runs(here):
    write(here, a__plate=SMALL, b__plate=SMALL)
    with pytest.raises(CaseError, match=r"a/plate.yaml and b/plate.yaml would both write out/plate.msh"):
        events_of("a", "b", folder="out")
    write(here, b__plate=SMALL + "name: c\nsweep: {packing.seed: [1]}\n", a__plate=SMALL + "name: c-seed=1\n")
    with pytest.raises(CaseError, match=r"a/plate.yaml and b/plate.yaml \(c-seed=1\) would both write"):
        events_of("a", "b")
    assert names(here) == ["a", "b"]


def test_cases_of_the_same_name_in_folders_of_their_own_do_not_meet(here):
    text = SMALL.replace("formats", "directory: ., formats")
    write(here, a__plate=text, b__plate=text)
    assert [row.folder for row in rows_of("a", "b")] == ["a", "b"]
    (here / "c").symlink_to("b")
    with pytest.raises(CaseError, match=r"b/plate.yaml and c/plate.yaml would both write c/plate.msh"):
        events_of("b", "c")


def test_no_result_overwrites_a_case_of_the_batch(here):
    write(here, x=SMALL + "name: case\n", **{"case.report": SMALL})
    Path("case.report.yaml").rename("case.report.json")
    with pytest.raises(FileError, match=r"case.report.json: the results of x.yaml would overwrite this case file"):
        events_of("x.yaml", "case.report.json")


def test_options_hold_for_every_case(here):
    write(here, a=SMALL, b=SMALL + "packing: {w2: 0.5}\n")
    for row in rows_of(".", overrides=overrides_of(["spacing=0.3", "packing.w1=2"], method="fnpbs", seed=7)):
        report = json.loads(Path(f"{row.case}.report.json").read_text())
        assert report["method"] == row.figures["method"] == "fnpbs"
        assert report["seed"] == row.figures["seed"] == 7
        assert (report["parameters"]["spacing"], report["parameters"]["packing"]["w1"]) == (0.3, 2)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"folder": ""}, "a batch writes into a folder"),
        ({"folder": "-"}, "-o -: a batch writes into a folder"),
    ],
)
def test_a_wrong_option_is_an_error_of_its_own_and_no_case_s(settings, message):
    with pytest.raises(CaseError, match=message):
        BatchOptions(**settings)


def test_a_wrong_setting_is_an_error_of_its_own_and_no_case_s(here):
    write(here, a=SMALL)
    result = CliRunner().invoke(app, ["batch", ".", "--set", "spacing"])
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith("error: --set spacing: no '='")
    assert names(here) == ["a.yaml"]


def test_events_tell_of_all_cases_of_rounds_and_of_ends(here):
    write(here, a=SMALL, b=SMALL)
    begun, *events = events_of(".")
    assert isinstance(begun, Begun)
    assert [entry.row.case for entry in begun.entries] == ["a", "b"]
    for number in (1, 2):
        nodes = next(
            event.row.figures["nodes"] for event in events if isinstance(event, Finished) and event.number == number
        )
        notes = [event for event in events if isinstance(event, Note) and event.number == number]
        assert notes == [Note(number), Note(number, 1, nodes)]


def test_a_row_has_the_figures_of_the_report(here):
    write(here, plate=SMALL + "require: {quality_mean: 0.1}\n")
    (row,) = rows_of("plate.yaml")
    report = json.loads(Path("plate.report.json").read_text())
    (line,) = lines_of(Path("summary.jsonl"))
    assert line["case"] == "plate"
    assert line["source"] == "plate.yaml"
    assert (line["exit_code"], line["error"], line["traceback"]) == (0, None, None)
    assert line["warnings"] == report["warnings"] == list(row.warnings)
    assert (line["version"], line["attempts"], line["sweep"]) == (__version__, 1, {})
    assert sorted(line["files"]) == sorted(report["files"])
    for name, keys in FIGURES.items():
        value = report
        for key in keys:
            value = value[key]
        assert line[name] == value, name
    (cells,) = table_in(Path())
    assert json.loads(cells["sweep"]) == {}
    assert (cells["case"], cells["nodes"], cells["warnings"]) == ("plate", str(report["nodes"]), str(len(row.warnings)))
    assert float(cells["quality_min"]) == report["quality"]["min"]


def test_the_table_has_swept_values_as_json(here):
    write(here, plate=SMALL + "sweep: {packing.seed: [3], domain.outer.label: ['é']}\n")
    rows_of("plate.yaml")
    (cells,) = table_in(Path())
    assert json.loads(cells["sweep"]) == {"packing.seed": 3, "domain.outer.label": "é"}


@pytest.mark.long
def test_the_meshes_of_a_batch_are_those_of_single_runs_byte_for_byte(here):
    configs = ROOT / "configs"
    options = ["--set", "packing.effort=fast", "--seed", "3"]
    cases = [configs / "quickstart.yaml", configs / "gallery/letter.yaml"]
    process = batch(*cases, "-o", "out", "--jobs", "2", *options, folder=here)
    assert process.returncode == 0, process.stderr
    for case in cases:
        run = [sys.executable, "-m", "bubblemesh", "run", case, "-o", "single", "-q", *options]
        assert subprocess.run(run, timeout=60).returncode == 0
    assert results_in(here / "out") == results_in(here / "single")
    assert len(results_in(here / "out")) == 8  # a mesh for solvers, one for viewers, labels and a report, of each


@pytest.mark.long
def test_the_command_tells_of_each_case_in_plain_lines_and_ends_with_the_largest_code(here):
    write(here, a=SMALL, b=BAD, c=SMALL.replace("spacing: 0.4", "spacing: 9"), d="spacing: 1\n")
    process = batch(".", "-o", "out", "--jobs", "1", folder=here)
    assert process.returncode == 3
    assert process.stdout == ""
    lines = process.stderr.splitlines()
    assert any(line.startswith("[") and "/4] a: " in line and " nodes, q " in line for line in lines)
    assert any(line.startswith("error: [") and "/4] b.yaml:1: domain: the outer ring" in line for line in lines)
    assert any(line.startswith("warning: c: ") for line in lines)
    assert lines[-1] == "4 cases: 2 done, 2 failed; summary in out/summary.jsonl"
    assert "\x1b" not in process.stderr
    quiet = batch(".", "-o", "out", "--jobs", "1", "-q", "--json", "--resume", folder=here)
    assert {line.split(":")[0] for line in quiet.stderr.splitlines()} == {"error"}
    summary = json.loads(quiet.stdout)
    assert (summary["cases"], summary["failed"], summary["unchanged"], summary["exit_code"]) == (4, 2, 2, 3)
    assert [row["case"] for row in summary["rows"]] == ["a", "b", "c", "d"]
