"""Sweeps and batches that are checked only: every case with its nodes, and no file."""

import json

import pytest
from commands import command, contents

SWEPT = """\
domain: {outer: {rectangle: [0, 0, 1, 1]}, holes: [{circle: {center: [0.5, 0.5], radius: r}}]}
parameters: {r: 0.2}
spacing: 0.1
sweep: {parameters.r: [0.1, 0.2, 0.7], packing.seed: [1, 2]}
"""
PLAIN = "domain: {outer: {rectangle: [0, 0, 1, 1]}}\nspacing: 0.2\n"


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "swept.yaml").write_text(SWEPT)
    (tmp_path / "plain.yaml").write_text(PLAIN)
    return tmp_path


@pytest.mark.parametrize("arguments", [["check", "swept.yaml"], ["batch", "swept.yaml", "--dry-run", "-o", "out"]])
def test_all_cases_of_a_sweep_are_checked_and_alike_faults_told_once(arguments, here):
    before = contents(here)
    code, out, told = command(*arguments)
    assert code == 3
    lines = out.splitlines()
    assert [line.partition(":")[0] for line in lines[:4]] == [
        f"[{number}/6] swept-r={r}-seed={seed}"
        for number, (r, seed) in enumerate([(0.1, 1), (0.1, 2), (0.2, 1), (0.2, 2)], 1)
    ]
    assert all("about 1" in line and line.endswith("nodes, spacing 0.1 to 0.1") for line in lines[:4])
    assert lines[4].startswith("6 cases: 4 can be meshed, with about ")
    assert lines[4].endswith(" nodes in all, 2 failed, 1 message like those above left out")
    assert len(lines) == 5
    assert told.startswith("error: [5/6] swept-r=0.7-seed=1: swept.yaml:1: domain: hole 1 ")
    assert told.count("\n") == 1
    assert contents(here) == before


def test_figures_of_all_cases_are_json(here):
    code, out, told = command("batch", "swept.yaml", "plain.yaml", "--dry-run", "--json", "-q", "-o", "out")
    totals = json.loads(out)
    assert (code, totals["cases"], totals["failed"], totals["exit_code"]) == (3, 7, 2, 3)
    last = totals["rows"][-1]
    assert (last["case"], last["source"], last["sweep"], last["exit_code"]) == ("plain", "plain.yaml", {}, 0)
    assert last["files"] == ["plain.msh", "plain.vtu", "plain.labels.json", "plain.report.json"]
    assert last["folder"] == "."
    assert totals["rows"][0]["sweep"] == {"parameters.r": 0.1, "packing.seed": 1}
    assert totals["expected_nodes"] == pytest.approx(sum(row.get("expected_nodes", 0) for row in totals["rows"]))
    assert "error" in told
    assert not (here / "out").exists()


def test_a_sweep_comes_from_the_standard_input_too(here):
    code, out, _ = command("check", "-", stdin=SWEPT.replace(", 0.7", ""))
    assert code == 0
    assert out.splitlines()[-1].startswith("4 cases: 4 can be meshed, ")


def test_a_shard_of_a_batch_is_checked(here):
    _, out, _ = command("batch", "swept.yaml", "--dry-run", "--shard", "2/3", "--json", "-q")
    assert [row["case"] for row in json.loads(out)["rows"]] == ["swept-r=0.1-seed=2", "swept-r=0.7-seed=1"]


def test_faults_of_the_sweep_itself_and_of_pictures_are_told(here):
    (here / "bad.yaml").write_text(SWEPT.replace("[1, 2]", "3"))
    code, _, told = command("check", "bad.yaml")
    assert (code, told.count("error:")) == (2, 1)
    assert "bad.yaml:4: sweep.packing.seed: must be a list of values" in told
    code, _, told = command("check", "swept.yaml", "--plot", "a.png")
    assert (code, told.startswith("error: --plot: draws one case")) == (2, True)
    assert command("check", "swept.yaml", "--set", "sweep=null")[0] == 0
