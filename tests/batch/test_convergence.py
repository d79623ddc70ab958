"""Histories in a batch, and the one picture that is made of them."""

from pathlib import Path

import numpy as np
import pytest
from batches import rows_of
from commands import command
from matplotlib.colors import to_hex

from bubblemesh.batch.convergence import write_convergence
from bubblemesh.batch.row import Row
from bubblemesh.errors import DONE
from bubblemesh.pictures.convergence import Course, convergence_figure

CASE = """
domain: {outer: {rectangle: [0, 0, 1, 1]}}
spacing: 0.2
sweep: {packing.seed: [1, 2, 3]}
"""
TOO_LONG = "iterations,quality_mean\n" + 30 * "1,0.5\n"


def test_a_batch_with_histories_has_tables_and_one_picture(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.yaml").write_text(CASE)
    rows_of("a.yaml", folder="out", history=True)
    tables = sorted(path.name for path in (tmp_path / "out").glob("*.rounds.csv"))
    assert tables == [f"a-seed={k}.rounds.csv" for k in (1, 2, 3)]
    assert len(list((tmp_path / "out").glob("*.history.csv"))) == 3
    assert (tmp_path / "out/convergence.svg").read_text().startswith("<?xml")
    assert not (tmp_path / "out/index.html").exists()


def test_each_case_is_a_line_over_its_steps():
    courses = [Course("a", *_line(0.1)), Course("$b$", *_line(0.2))]
    (axes,) = convergence_figure(courses).axes
    assert [line.get_label() for line in axes.lines] == ["a", "$b$"]
    assert axes.lines[0].get_ydata().tolist() == pytest.approx([0.1, 0.05])
    assert axes.get_yscale() == "log"
    assert len({to_hex(line.get_color()) for line in axes.lines}) == 2


def _line(first):
    return np.array([10.0, 20.0]), 1 - np.array([first, first / 2])


@pytest.mark.parametrize("content", ["", "round,iterations\n1,2\n", "iterations,quality_mean\nx,1\n", TOO_LONG, None])
def test_a_table_that_is_gone_or_none_is_left_out_and_told(content, tmp_path, monkeypatch):
    if content is not None:
        (tmp_path / "a.rounds.csv").write_text(content)
    row = Row("a", "a.yaml", DONE, folder=".", files={"a.rounds.csv": "hash"})
    told = []
    monkeypatch.setattr("bubblemesh.files.opening.MOST_BYTES", 100)
    write_convergence([row], tmp_path, tmp_path / "convergence.svg", told.append)
    assert not (tmp_path / "convergence.svg").exists()
    assert told == [f"{tmp_path / 'a.rounds.csv'}: the table is damaged or gone: a is not in convergence.svg"]


@pytest.mark.usefixtures("workers_in_threads")
def test_a_batch_warns_of_a_table_of_earlier_cases(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("a.yaml").write_text(CASE)
    Path("b.yaml").write_text(CASE.replace("[1, 2, 3]", "[1]"))
    assert command("batch", "a.yaml", "-o", "out", "--history", "-q")[0] == 0
    Path("out/a-seed=2.rounds.csv").write_text("round,iterations\n")
    code, _, message = command("batch", "b.yaml", "-o", "out", "--history", "-q", "--resume")
    assert code == 0
    assert "out/a-seed=2.rounds.csv: the table is damaged or gone: a-seed=2 is not in convergence.svg" in message
