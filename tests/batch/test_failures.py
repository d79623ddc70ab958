"""Cases that fail are rows beside the others."""

import errno
import json
import os
import subprocess
import sys
from dataclasses import replace
from importlib import import_module
from itertools import product
from pathlib import Path

import pytest
from batch_cases import between, names, table_in, write
from batches import (
    BAD,
    SMALL,
    events_of,
    finished,
    lines_of,
    results_in,
    rows_of,
)
from commands import command, refused
from sweeps import sweep

from bubblemesh.batch import BatchOptions, plan_cases
from bubblemesh.batch.worker import mesh_job
from bubblemesh.case import overrides_of
from bubblemesh.errors import FileError

NODES = "4 2 0 0\n1 0 0\n2 1 0\n3 1 1\n4 0 1\n"


GEOJSON = {"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]]]}


def test_failing_cases_are_rows_beside_the_others(here):
    write(here, a=BAD, b="domain: {}\n", c=SMALL, d=SMALL + "limits: {max_nodes: 2}\n", f="sweep: 1\n")
    write(here, e=SMALL + "require: {quality_mean: 1}\n", g=SMALL.replace("rectangle: [0, 0, 1, 1]", "file: no.csv"))
    rows = rows_of(".", "missing.yaml", folder="out")
    assert [(row.case, row.exit_code) for row in rows] == [
        ("a", 3),
        ("b", 2),
        ("c", 0),
        ("d", 6),
        ("e", 4),
        ("f", 2),
        ("g", 5),
        ("missing", 5),
    ]
    for row, part in [
        (0, "a.yaml:1: domain: the outer ring"),
        (1, "b.yaml:1: domain"),
        (3, "max_nodes"),
        (4, "e.yaml: the mesh is made, but misses what the case requires: quality_mean is 0."),
        (6, "g.yaml:1: the outer ring: no.csv: the file cannot be read: No such file"),
        (7, "missing.yaml: the case file cannot be read"),
    ]:
        assert part in rows[row].error
    assert names("out") == ["c.msh", "c.report.json", "e.msh", "e.report.json", "summary.csv", "summary.jsonl"]
    assert {line["case"]: line["exit_code"] for line in lines_of(Path("out/summary.jsonl"))} == {
        row.case: row.exit_code for row in rows
    }
    table = table_in(Path("out"))
    assert len(table) == len(rows) == len(Path("out/summary.csv").read_text().splitlines()) - 1
    assert next(cells for cells in table if cells["case"] == "b")["error"].count("; b.yaml") == 1


UNREAD = {  # keys of cases with files that are not there, or no files
    "domain": "domain:\n  # a remark\n  file: no.geojson\nspacing: 1\n",
    "hole": "domain:\n  outer: {rectangle: [0, 0, 1, 1]}\n  holes:\n    - {file: no.csv}\nspacing: 1\n",
    "points": "domain:\n  outer: {rectangle: [0, 0, 1, 1]}\n  points:\n    - {file: sub.csv}\nspacing: 1\n",
    "field": "domain:\n  outer: {rectangle: [0, 0, 1, 1]}\nspacing:\n  field: {file: no.vtu}\n",
    "raster": "domain:\n  outer: {rectangle: [0, 0, 1, 1]}\nspacing:\n  value: 1\n  raster: {file: no.asc}\n",
}


@pytest.mark.parametrize("name", UNREAD)
def test_a_file_that_is_not_read_is_told_as_a_run_tells_it(name, here):
    write(here, case=UNREAD[name], z=SMALL)
    (here / "sub.csv").mkdir()
    for resume in (False, True):
        row, other = rows_of(".", folder="out", resume=resume)
        assert (row.exit_code, row.inputs, other.exit_code) == (5, None, 0)
        assert f"error: {row.error}" in refused(here, UNREAD[name], 5)
        assert "case.yaml:" in row.error


def test_an_error_of_the_program_is_a_row_with_its_place(here, monkeypatch):
    def broken(*arguments):
        raise ZeroDivisionError("oh")

    monkeypatch.setattr("bubblemesh.batch.worker.prepare", broken)
    write(here, a=SMALL)
    (row,) = rows_of(".")
    assert row.exit_code == 1
    assert "a.yaml: this is an error of bubblemesh, not of the case: ZeroDivisionError: oh" in row.error
    assert "in broken" in row.traceback
    monkeypatch.setattr("bubblemesh.batch.worker.prepare", lambda case: bytes(10**18))
    assert [(row.exit_code, "out of memory" in row.error) for row in rows_of(".")] == [(6, True)]


HUGE = "0x" + "f" * 5000
HARMFUL = {  # texts of cases that ended a batch, with the exit code of each and a part of its message
    "hexadecimal": (SMALL.replace("0.4", HUGE), 2, "a.yaml:2: spacing: must be a finite number"),
    "octal": (SMALL.replace("0.4", "0o" + "7" * 9000), 2, "a.yaml:2: spacing: must be a finite number"),
    "seed": (SMALL + f"packing: {{seed: {HUGE}}}\n", 2, "a.yaml:6: packing.seed"),
    "swept": (SMALL + f"sweep: {{packing.seed: [{HUGE}]}}\n", 2, "a.yaml:6: packing.seed"),
    "root": (SMALL.replace("0.4", "{field: {file: /}}"), 2, "a.yaml:2: spacing.field.file: must be the name of a file"),
    "here": (SMALL.replace("0.4", "{image: {file: ., range: [1, 2]}}"), 2, "a.yaml:2: spacing.image.file: must be"),
    "above": (SMALL.replace("rectangle: [0, 0, 1, 1]", "file: .."), 2, "a.yaml:1: domain.outer.file: must be the name"),
    "folder": (SMALL.replace("0.4", "{field: {file: folder.vtu}}"), 5, "folder.vtu"),
}


@pytest.mark.parametrize("name", HARMFUL)
def test_a_case_that_asks_for_the_impossible_is_a_row_and_the_others_are_meshed(name, here):
    text, code, message = HARMFUL[name]
    write(here, a=text, b=SMALL)
    (here / "folder.vtu").mkdir()
    for resume in (False, True):
        rows = rows_of(".", folder="out", resume=resume)
        assert [row.exit_code for row in rows] == [code, 0]
        assert message in rows[0].error
    if "sweep" not in text:
        assert message in refused(here, text, code).replace("case.yaml", "a.yaml")


PARTS = ("plan.case_variants", "plan.load_case", "plan.destination", "plan.contents_or_errors", "worker.inputs_digest")
ERRORS = (ZeroDivisionError, RecursionError, OSError, MemoryError)


@pytest.mark.parametrize(("part", "error"), sweep(product(PARTS, ERRORS), quick=8))
def test_an_error_of_the_program_in_any_part_of_a_batch_is_a_row_of_the_case_alone(part, error, here, monkeypatch):
    def broken(*arguments, **options):
        if "a.yaml" in str(arguments) or "ring.txt" in str(arguments):
            raise error("oh")
        return function(*arguments, **options)

    (here / "ring.txt").write_text("0 0\n1 0\n1 1\n0 1\n")
    write(here, a=SMALL.replace("rectangle: [0, 0, 1, 1]", "file: ring.txt"), z=SMALL)
    module = import_module(f"bubblemesh.batch.{part.partition('.')[0]}")
    function = getattr(module, part.partition(".")[2])
    rows_of(".", folder="out")
    monkeypatch.setattr(module, part.partition(".")[2], broken)
    for resume in (True, False):
        rows = rows_of(".", folder="out", resume=resume)
        assert [row.exit_code for row in rows] == [6 if error is MemoryError else 1, 0]
        if error is not MemoryError:
            assert rows[0].error == f"a.yaml: this is an error of bubblemesh, not of the case: {error.__name__}: oh"
            assert "in broken" in rows[0].traceback
    assert len(lines_of(here / "out/summary.jsonl")) == 2


def test_a_library_that_was_removed_is_named_in_the_row(here, monkeypatch):
    def broken(*arguments, **options):
        raise ModuleNotFoundError("No module named 'matplotlib'", name="matplotlib.figure")

    write(here, a=SMALL)
    monkeypatch.setattr("bubblemesh.batch.plan.contents_or_errors", broken)
    (row,) = rows_of(".", folder="out")
    assert (row.exit_code, row.traceback) == (5, None)
    assert row.error == "a.yaml: matplotlib is needed for this and not installed: install bubblemesh anew"


def test_a_name_that_is_no_text_is_told_in_a_row_and_kept(here):
    source = os.fsdecode(b"\xff.yaml")
    write(here, b=SMALL)
    (here / source).write_text(SMALL)
    assert [(row.source, row.exit_code) for row in rows_of(source, "b.yaml", folder="out")] == [
        (source, 2),
        ("b.yaml", 0),
    ]
    rows_of("b.yaml", folder="out", resume=True)
    assert [line["source"] for line in lines_of(here / "out/summary.jsonl")] == [source, "b.yaml"]


@pytest.mark.parametrize("line", ["[" * 100_000, '{"case": ' + "9" * 5000 + "}", '{"case": "\\ud800"}', "\0"])
def test_a_summary_with_a_line_that_is_none_is_gone_on_from(line, here):
    write(here, a=SMALL)
    rows_of(".", folder="out")
    with (here / "out/summary.jsonl").open("a") as file:
        file.write(line + "\n")
    code, _, told = command("batch", ".", "-o", "out", "--resume")
    assert (code, told.count("warning: out/summary.jsonl: 1 damaged row dropped")) == (0, 1), told
    assert [end.unchanged for end in finished(".", folder="out", resume=True)] == [True]


@pytest.mark.long
def test_files_that_a_case_names_are_read_when_its_turn_comes_and_reported_as_by_a_run(here):
    (here / "data").mkdir()
    (here / "data/square.geojson").write_text(json.dumps(GEOJSON))
    write(
        here, data__a=SMALL.replace("outer: {rectangle: [0, 0, 1, 1], label: wall}", "file: square.geojson, label: w")
    )
    (row,) = rows_of("data", folder="out")
    assert row.error is None
    process = subprocess.run(
        [sys.executable, "-m", "bubblemesh", "run", "data/a.yaml", "-q", "-o", "single"], timeout=60
    )
    assert process.returncode == 0
    assert results_in(here / "out") == results_in(here / "single")


def test_a_job_has_all_parts_of_a_file_with_it(here):
    for name in ("part.shp", "part.shx", "part.dbf", "part.prj", "part.txt", "party.shx", "p.poly", "p.node"):
        (here / name).write_bytes(name.encode())
    write(here, a="domain: {outer: {file: part.shp}, holes: [{file: p.poly}]}\nspacing: 1\n")
    (entry,) = plan_cases(["a.yaml"], BatchOptions())
    job = entry.job()
    assert sorted(job.files) == ["p.node", "p.poly", "part.dbf", "part.prj", "part.shp", "part.shx"]
    assert all(content == name.encode() for name, content in job.files.items())
    for name in job.files:
        (here / name).write_text("other")
        assert entry.job().digest() != job.digest()
        (here / name).write_bytes(job.files[name])
    assert entry.job().digest() == job.digest()


def test_a_job_is_done_where_its_files_are_not(here):
    (here / "data").mkdir()
    for name, text in {"p.poly": "0 2 0 0\n4 0\n1 1 2\n2 2 3\n3 3 4\n4 4 1\n0\n", "p.node": NODES}.items():
        (here / "data" / name).write_text(text)
    write(here, data__a=SMALL.replace("outer: {rectangle: [0, 0, 1, 1], label: wall}", "file: p.poly"))
    (entry,) = plan_cases(["data/a.yaml"], BatchOptions())
    job = entry.job()
    (here / "data").rename("elsewhere")
    outcome = mesh_job(job, lambda note: None)
    assert outcome.row.error is None
    report = json.loads(outcome.files["a.report.json"])
    assert report["parameters"]["domain"]["file"] == "data/p.poly"
    assert report["area"] == pytest.approx(1)


def test_a_worker_of_another_version_is_not_trusted(here):
    write(here, a=SMALL)
    (entry,) = plan_cases(["a.yaml"], BatchOptions())
    job = entry.job()
    other = replace(job, version="0.0.1")
    outcome = mesh_job(other, lambda note: None)
    assert (outcome.row.exit_code, outcome.files) == (5, {})
    assert "install the same version" in outcome.row.error
    assert job.digest() != other.digest()


def replaced_by_link(path, target):
    path.unlink(missing_ok=True)
    path.symlink_to(target)


@pytest.mark.parametrize(
    "change",
    [
        lambda path: path.unlink(missing_ok=True),
        lambda path: path.write_text(SMALL + "name: a\n"),
        lambda path: path.write_text("spacing: [\n"),
        lambda path: replaced_by_link(path, path),
        lambda path: replaced_by_link(path, "/dev/zero"),
    ],
)
def test_a_case_whose_file_changes_in_between_is_meshed_as_it_was(change, here):
    write(here, a=SMALL, b=SMALL.replace("0.4", "0.3"))
    rows_of(".", folder="whole")
    rows = rows_of(".", folder="out", workers=between(lambda: change(Path("b.yaml"))))
    assert [(row.case, row.exit_code) for row in rows] == [("a", 0), ("b", 0)]
    assert results_in(here / "out") == results_in(here / "whole")


@pytest.mark.parametrize(
    "change",
    [
        lambda path: path.unlink(missing_ok=True),
        lambda path: replaced_by_link(path, path),
        lambda path: replaced_by_link(path, "/dev/zero"),
        lambda path: replaced_by_link(path, path.parent),
    ],
)
def test_a_file_that_a_case_names_and_that_is_deleted_in_between_is_a_row(change, here):
    write(here, a=SMALL, b=SMALL.replace("outer: {rectangle: [0, 0, 1, 1], label: wall}", "file: ring.txt"))
    Path("ring.txt").write_text("0 0\n1 0\n1 1\n0 1\n")
    rows = rows_of(".", workers=between(lambda: change(Path("ring.txt"))))
    assert [(row.case, row.exit_code) for row in rows] == [("a", 0), ("b", 5)]
    assert "b.yaml:1: ring.txt: the file cannot be read" in rows[1].error


def failing_to_write(monkeypatch, name, number):
    """Make writing a result of this name fail in this way."""
    write_bytes = Path.write_bytes

    def failing(path, content):
        if path.name == name and ".bubblemesh-batch-" in str(path):
            raise OSError(number, os.strerror(number), str(path))
        return write_bytes(path, content)

    monkeypatch.setattr(Path, "write_bytes", failing)


def test_files_that_cannot_be_written_are_a_row_and_old_ones_stay(here, monkeypatch):
    write(here, a=SMALL, b=SMALL)
    before = [*rows_of(".")] and results_in(here)
    failing_to_write(monkeypatch, "a.msh", errno.EIO)
    rows = rows_of(".", overrides=overrides_of(seed=5))
    assert [(row.case, row.exit_code, bool(row.files)) for row in rows] == [("a", 5, False), ("b", 0, True)]
    assert rows[0].error == f"a.yaml: cannot write a.msh: {os.strerror(errno.EIO)}"
    after = results_in(here)
    assert before["a.msh"] == after["a.msh"]
    assert before["b.msh"] != after["b.msh"]
    assert not [name for name in names(here) if name.startswith(".")]


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT])
def test_a_full_disk_ends_the_batch_and_what_is_done_stays(number, here, monkeypatch):
    write(here, a=SMALL, b=SMALL, c=SMALL)
    failing_to_write(monkeypatch, "b.msh", number)
    message = f"b.yaml: cannot write b.msh: {os.strerror(number)}: the batch ends, what is done stays: make room"
    with pytest.raises(FileError, match=message):
        events_of(".", workers=between(lambda: None))
    assert [line["case"] for line in lines_of(Path("summary.jsonl"))] == ["a"]
    monkeypatch.undo()
    os.chdir(here)
    assert [end.unchanged for end in finished(".", resume=True)] == [True, False, False]


def test_a_worker_without_space_ends_the_batch_too(here, monkeypatch):
    def full():
        raise OSError(errno.ENOSPC, "No space left on device")

    write(here, a=SMALL)
    monkeypatch.setattr("bubblemesh.batch.worker.temporary_folder", full)
    with pytest.raises(
        FileError, match=r"a.yaml: no place for temporary files: No space left on device: the batch ends"
    ):
        events_of(".")


def test_a_worker_without_file_descriptors_says_so(here, monkeypatch):
    def refuse():
        raise OSError(errno.EMFILE, "Too many open files")

    write(here, a=SMALL)
    monkeypatch.setattr("bubblemesh.batch.worker.temporary_folder", refuse)
    events_of(".")
    (row,) = lines_of(Path("summary.jsonl"))
    assert row["exit_code"] == 5
    assert row["error"].startswith("a.yaml: Too many open files: let this process open more (ulimit -n")
