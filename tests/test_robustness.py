"""The trial of robustness: a sample of it, and that it would notice what is wrong."""

import random
import time
from functools import partial
from itertools import islice

import numpy as np
import pytest

from benchmarks.intake.collection import KINDS
from benchmarks.robustness import fuzz
from benchmarks.robustness.capped import called
from benchmarks.robustness.corpus import FAMILIES, glyphs, random_domains
from benchmarks.robustness.meshes import mesh_one, row_of, tasks
from benchmarks.robustness.page import OTHERS, others, table
from benchmarks.robustness.soundness import faults
from benchmarks.robustness.trials import note, noted, tell

POINTS = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.5]], float)
TRIANGLES = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
FACETS = np.array([[0, 1], [1, 2], [2, 3], [3, 0]])

BROKEN = {
    "clockwise": (POINTS, TRIANGLES[:, [1, 0, 2]], FACETS, 1.0),
    "unused": (np.vstack([POINTS, [[0.2, 0.2]]]), TRIANGLES, FACETS, 1.0),
    "at one place": (np.vstack([POINTS[:4], [[0, 0]]]), TRIANGLES, FACETS, 1.0),
    "one side": (POINTS, np.vstack([TRIANGLES, TRIANGLES[:1]]), FACETS, 1.0),
    "boundary edges are not": (POINTS, TRIANGLES[:3], FACETS, 1.0),
    "of the domain": (POINTS, TRIANGLES, FACETS, 1.0 + 1e-11),
    "finite": (POINTS + [[np.nan, 0]] * 5, TRIANGLES, FACETS, None),
}


@pytest.fixture(autouse=True)
def _quiet():
    with np.errstate(invalid="ignore"):
        yield


def test_a_sound_mesh_has_no_faults():
    assert faults(POINTS, TRIANGLES, FACETS, 1.0) == []


@pytest.mark.parametrize("words", BROKEN)
def test_a_broken_mesh_is_noticed(words):
    assert any(words in fault for fault in faults(*BROKEN[words]))


def test_the_corpus_is_the_same_at_every_call_and_has_all_families():
    names = [name for name, _ in random_domains(22)]
    assert {name.rpartition("-")[0] for name in names} == FAMILIES.keys()
    assert list(random_domains(22)) == list(random_domains(22))
    assert [name for name, _ in glyphs(5)] == [name for name, _ in glyphs(5)]
    assert len(list(glyphs(40))) == 40


def wait_or_fail(task):
    if task == "crash":
        raise KeyError("lost")
    if task == "die":
        import os

        os._exit(3)
    time.sleep(task)
    return task


@pytest.mark.long
def test_calls_that_hang_die_or_crash_end_no_other():
    ended = {call.task: call for call in called(wait_or_fail, [0, "crash", 60, "die", 0.1], 2, 2.0, 4000)}
    assert (ended[0].value, ended[0.1].value) == (0, 0.1)
    assert "KeyError" in ended["crash"].crash
    assert "exit code 3" in ended["die"].crash
    assert "no end" in ended[60].crash


@pytest.mark.long
def test_a_sample_of_the_trial_is_sound():
    cases = islice((case for case in tasks(60, 44) if "tiny-holes" not in case["name"]), 16)
    rows = [row_of(call) for call in called(mesh_one, cases, 2, 100, 3000)]
    assert len(rows) == 16
    assert [row for row in rows if row["outcome"] not in ("sound", "refused, and invalid")] == []
    assert len(list(table(rows))) > 3


def test_every_kind_of_the_collection_is_damaged():
    assert {name.partition("-")[0] for name in fuzz.seeds()} >= {*KINDS}


@pytest.mark.parametrize("number", range(3))
def test_a_few_damaged_files_are_read_or_refused_by_an_error_of_ours(number):
    known = fuzz.seeds()
    for kind in [*known][number::24]:
        row = fuzz.read_one(known, {"name": f"{kind}-{number}", "kind": kind})
        assert row["outcome"] == "read" or row["outcome"].startswith("refused ("), kind


@pytest.mark.long
def test_damaged_files_are_read_or_refused_by_an_error_of_ours():
    """Each kind of file that a case can name, and cases, in processes with a cap on memory and time."""
    tasks = list(fuzz.tasks(each=3))
    rows = [
        fuzz.row_of(call)
        for call in called(partial(fuzz.read_one, fuzz.seeds()), tasks, jobs=2, seconds=20, megabytes=4000)
    ]
    assert len(rows) == len(tasks) > 150
    assert [row for row in rows if row["outcome"] == "finding"] == []


@pytest.mark.parametrize("change", fuzz.CHANGES)
def test_damage_changes_what_it_is_given(change):
    text = b"domain: {outer: {circle: {center: [0, 0], radius: 1}}}"
    found = {change(text, random.Random(k)) for k in range(20)}
    assert len(found - {text}) > 10
    assert change(b"", random.Random(0)) is not None


def test_trials_tell_what_is_wrong_and_note_how_many_there_were(tmp_path, capsys):
    outcomes = tmp_path / "outcomes.json"
    note("kills, run", {"trials": 1, "wrong": 1}, outcomes)
    with pytest.raises(SystemExit) as ended:
        tell([("disk, run", [("write 1", []), ("write 2", ["a file is lost"])])], outcomes)
    assert ended.value.code == 1
    assert "disk, run, write 2: a file is lost" in capsys.readouterr().out
    assert noted(outcomes) == {
        "disk, run": {"trials": 2, "wrong": 1},
        "kills, run": {"trials": 1, "wrong": 1},
    }
    lines = list(others(noted(outcomes)))
    assert len(lines) == 2 + len(OTHERS)
    assert "run: 2 trials, 1 wrong" in next(line for line in lines if "robustness disk" in line)
