"""What docs/batch.md shows is what is there: every line of it is run."""

import os
import re
import subprocess
import sys

import pytest
from batches import SMALL, lines_of
from paths import ROOT
from site_pages import followed

from bubblemesh.batch.row import COLUMN_KINDS, COLUMNS
from bubblemesh.workers.cluster import PATIENCE, SILENCE

DOCS = ROOT / "docs"
PAGE = (DOCS / "batch.md").read_text()
SHELL = re.findall(r"```sh\n(.*?)```", PAGE, flags=re.DOTALL)
# What a line of `parallel COMMAND ::: WORD...` does.
PARALLEL = """#!/bin/bash
command=()
while [ "$1" != ":::" ]; do command+=("$1"); shift; done
shift
for word in "$@"; do "${command[@]//\\{\\}/$word}" || exit; done
"""


def block(language):
    text, *_ = re.findall(rf"```{language}\n(.*?)```", PAGE, flags=re.DOTALL)
    return text


@pytest.fixture
def here(tmp_path):
    """A folder with the cases that the page speaks of, and with the programs that it calls."""
    quick = "method: accelerated\nschedule: {rounds: 1, iterations: 5}\noutput: {formats: [msh]}\n"
    for name, text in {
        "cases/plate.yaml": block("yaml") + quick,
        "cases/plate-b.yaml": SMALL,
    }.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    programs = {"bubblemesh": f'#!/bin/bash\nexec {sys.executable} -m bubblemesh "$@"\n', "parallel": PARALLEL}
    (tmp_path / "bin").mkdir()
    for name, text in programs.items():
        (tmp_path / "bin" / name).write_text(text)
        (tmp_path / "bin" / name).chmod(0o755)
    return tmp_path


def shell(script, folder, **environment):
    paths = {"PATH": f"{folder / 'bin'}:{os.environ['PATH']}"}
    return subprocess.run(
        ["bash", "-c", script],
        cwd=folder,
        env=os.environ | paths | environment,
        check=True,
        capture_output=True,
        text=True,
        timeout=120,
    )


@pytest.mark.long
def test_the_lines_shown_mesh_all_cases_and_the_rows_are_read(tmp_path):
    followed(DOCS / "batch.md", tmp_path)
    names = {"beam", *(f"plate-h={h}-seed={seed}" for h in (0.2, 0.3) for seed in (1, 2, 3))}
    for folder in ("out", "all"):
        assert {line["case"] for line in lines_of(tmp_path / folder / "summary.jsonl")} == names
    assert {path.stem for path in (tmp_path / "out").glob("*.msh")} == names


@pytest.mark.long
def test_a_job_array_does_everything_and_its_rows_are_gathered(here):
    (slurm,) = [text for text in SHELL if "#SBATCH" in text]
    fewer = slurm.replace("1-16", "1-2").replace("/16", "/2")
    assert fewer != slurm
    for task in ("1", "2"):
        shell(fewer, here, SLURM_CPUS_PER_TASK="1", SLURM_ARRAY_TASK_ID=task)
    parts = [len(lines_of(here / f"out/summary-{k}-of-2.jsonl")) for k in (1, 2)]
    assert parts == [4, 3]
    gathered = shell("bubblemesh batch cases -o out --resume", here)
    assert "7 cases: 7 unchanged" in gathered.stderr
    assert len(lines_of(here / "out/summary.jsonl")) == 7


@pytest.mark.long
def test_the_line_for_gnu_parallel_does_everything(here):
    (parallel,) = [text for text in SHELL if text.startswith("parallel")]
    shell(parallel.replace("/4", "/2").replace("1 2 3 4", "1 2"), here)
    assert [len(lines_of(here / f"out/summary-{k}-of-2.jsonl")) for k in (1, 2)] == [4, 3]


def test_the_page_tells_of_every_column():
    (table,) = re.findall(r"\| column \| holds \|\n(.*?)\n\n", PAGE, flags=re.DOTALL)
    assert set(re.findall(r"`(\w+)`", table.replace("bubblemesh run", ""))) == {*COLUMNS, *COLUMN_KINDS}


def test_the_page_tells_how_long_a_scheduler_has():
    text = " ".join(PAGE.split())
    assert f"answer within {PATIENCE:g} seconds at the beginning, is silent for {SILENCE:g} seconds later" in text
    assert "--cluster tcp://scheduler:8786" in PAGE
