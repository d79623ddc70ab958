"""Batches: which cases, where the results go, what the summary and the messages say."""

import csv
import errno
import json
import os
import shutil
import subprocess
import sys
from concurrent.futures import CancelledError, Executor, Future
from contextlib import contextmanager
from pathlib import Path
from queue import SimpleQueue

import pytest
from batches import (
    BAD,
    SMALL,
    batch,
    command,
    events_of,
    finished,
    lines_of,
    results_in,
    rows_of,
    stream,
    threads,
    unexpected,
)
from paths import ROOT
from typer.testing import CliRunner

from bubblemesh import __version__
from bubblemesh.batch import Begun, Finished, Note, Settings, case_files, planned
from bubblemesh.batch.jobs import Job
from bubblemesh.batch.plan import job_of
from bubblemesh.batch.rows import FIGURES
from bubblemesh.batch.shards import Shard
from bubblemesh.batch.space import is_full
from bubblemesh.batch.summary import Lines
from bubblemesh.batch.worker import mesh_job
from bubblemesh.batch.workers import WorkerDied, Workers
from bubblemesh.case import overrides_of
from bubblemesh.cli import app
from bubblemesh.errors import CaseError, FileError

NODES = "4 2 0 0\n1 0 0\n2 1 0\n3 1 1\n4 0 1\n"
GEOJSON = {"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]]]}


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty folder that is the present one."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(folder, **texts):
    """Write case files by their stems; a stem may have folders, as in a__b."""
    for stem, text in texts.items():
        path = folder / (stem.replace("__", "/") + ".yaml")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


def names(folder):
    return sorted(path.name for path in Path(folder).iterdir())


def table_in(folder):
    """The rows of a summary as CSV, each in one line."""
    lines = (folder / "summary.csv").read_text().splitlines()
    return list(csv.DictReader(lines))


# Which files


@pytest.fixture
def tree(here):
    write(here, b=SMALL, a=SMALL, sub__c=SMALL, sub__deep__d=SMALL, _base=SMALL, sub___e=SMALL, _private__f=SMALL)
    write(here, **{".hidden": SMALL, ".git__g": SMALL})
    (here / "sub/h.yml").write_text(SMALL)
    (here / "notes.txt").write_text("no case")
    (here / "z").mkdir()
    return here


@pytest.mark.parametrize(
    ("paths", "expected"),
    [
        (["."], ["a.yaml", "b.yaml", "sub/c.yaml", "sub/h.yml", "sub/deep/d.yaml"]),
        (["sub", "a.yaml"], ["sub/c.yaml", "sub/h.yml", "sub/deep/d.yaml", "a.yaml"]),
        (["*.yaml"], ["_base.yaml", "a.yaml", "b.yaml"]),
        (["**/[cd].yaml"], ["sub/c.yaml", "sub/deep/d.yaml"]),
        (["s*"], ["sub/c.yaml", "sub/h.yml", "sub/deep/d.yaml"]),
        (
            ["b.yaml", "./b.yaml", ".", "sub/../a.yaml"],
            ["b.yaml", "a.yaml", "sub/c.yaml", "sub/h.yml", "sub/deep/d.yaml"],
        ),
        (["_base.yaml", "notes.txt"], ["_base.yaml", "notes.txt"]),  # who is named is meant
        (["missing.yaml"], ["missing.yaml"]),  # a case that fails
    ],
)
def test_folders_patterns_and_names_mean_these_files(paths, expected, tree):
    assert case_files(paths) == expected


def test_a_link_to_a_folder_is_followed_where_it_is_named_only(tree):
    (tree / "z/link").symlink_to(tree / "sub/deep")
    (tree / "z/x.yaml").write_text(SMALL)
    assert case_files(["z"]) == ["z/x.yaml"]
    assert case_files(["z/link"]) == ["z/link/d.yaml"]


def test_a_file_whose_name_looks_like_a_pattern_is_that_file(here):
    write(here, **{"a[1]": SMALL, "a1": SMALL})
    assert case_files(["a[1].yaml"]) == ["a[1].yaml"]


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("z", "z: no case file is in this folder: their names end in .yaml or .yml"),
        ("*.json", r"\*.json: no file fits this pattern"),
        ("z*", r"z\*: no file fits"),
        ("-", "use bubblemesh run -"),
    ],
)
def test_nothing_to_mesh_is_an_error(path, message, tree):
    with pytest.raises(CaseError, match=message):
        case_files([path, "a.yaml"])


def test_a_folder_that_cannot_be_read_is_an_error(tree, monkeypatch):
    def refuse(path):
        raise PermissionError(errno.EACCES, "Permission denied", str(path))

    monkeypatch.setattr(os, "scandir", refuse)
    with pytest.raises(FileError, match="sub: the folder cannot be read: Permission denied"):
        case_files(["sub"])


# Where the results go


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
        Settings(**settings)


def test_a_wrong_setting_is_an_error_of_its_own_and_no_case_s(here):
    write(here, a=SMALL)
    result = CliRunner().invoke(app, ["batch", ".", "--set", "spacing"])
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith("error: --set spacing: no '='")
    assert not list(here.glob("*.jsonl"))


# Events and rows


def test_events_tell_of_all_cases_of_rounds_and_of_ends(here):
    write(here, a=SMALL, b=SMALL)
    begun, *events = events_of(".")
    assert isinstance(begun, Begun)
    assert [entry.name for entry in begun.entries] == ["a", "b"]
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
        (0, "a.yaml: domain: the outer ring"),
        (1, "b.yaml:1: domain"),
        (3, "max_nodes"),
        (4, "e.yaml: the mesh is written, but misses what the case requires: quality_mean is 0."),
        (6, "g.yaml: no.csv: the file cannot be read: No such file"),
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


def test_an_error_of_the_program_is_a_row_with_its_place(here, monkeypatch):
    def broken(*arguments):
        raise ZeroDivisionError("oh")

    monkeypatch.setattr("bubblemesh.batch.worker.prepared", broken)
    write(here, a=SMALL)
    (row,) = rows_of(".")
    assert row.exit_code == 1
    assert "a.yaml: this is an error of bubblemesh, not of the case: ZeroDivisionError: oh" in row.error
    assert "in broken" in row.traceback
    monkeypatch.setattr("bubblemesh.batch.worker.prepared", lambda case: bytes(10**18))
    assert [(row.exit_code, "out of memory" in row.error) for row in rows_of(".")] == [(6, True)]


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
    settings = Settings()
    (entry,) = planned(["a.yaml"], settings)
    job = job_of(entry, settings)
    assert sorted(job.files) == ["p.node", "p.poly", "part.dbf", "part.prj", "part.shp", "part.shx"]
    assert all(content == name.encode() for name, content in job.files.items())
    for name in job.files:
        (here / name).write_text("other")
        assert job_of(entry, settings).digest() != job.digest()
        (here / name).write_bytes(job.files[name])
    assert job_of(entry, settings).digest() == job.digest()


def test_a_job_is_done_where_its_files_are_not(here):
    (here / "data").mkdir()
    for name, text in {"p.poly": "0 2 0 0\n4 0\n1 1 2\n2 2 3\n3 3 4\n4 4 1\n0\n", "p.node": NODES}.items():
        (here / "data" / name).write_text(text)
    write(here, data__a=SMALL.replace("outer: {rectangle: [0, 0, 1, 1], label: wall}", "file: p.poly"))
    settings = Settings()
    (entry,) = planned(["data/a.yaml"], settings)
    job = job_of(entry, settings)
    (here / "data").rename("elsewhere")
    outcome = mesh_job(job, lambda note: None)
    assert outcome.error is None
    assert outcome.report["parameters"]["domain"]["file"] == "data/p.poly"
    assert outcome.report["area"] == pytest.approx(1)


def test_a_worker_of_another_version_is_not_trusted(here):
    write(here, a=SMALL)
    settings = Settings()
    (entry,) = planned(["a.yaml"], settings)
    job = job_of(entry, settings)
    other = Job(job.number, job.source, job.case, job.place, job.files, version="0.0.1")
    outcome = mesh_job(other, lambda note: None)
    assert (outcome.exit_code, outcome.files) == (5, {})
    assert "install the same version" in outcome.error
    assert job.digest() != other.digest()


# What happens in between


def between(change):
    """Workers that make a change when the first case has been submitted."""

    @contextmanager
    def workers(count):
        with threads(count) as crew:

            def capacity():
                return 1

            submit = crew.executor.submit

            def submitted(*arguments):
                change()
                return submit(*arguments)

            crew.executor.submit = submitted
            yield Workers(crew.executor, crew.tell, crew.notes, capacity, crew.failure, crew.lost)

    return workers


def test_a_case_deleted_in_between_is_a_row(here):
    write(here, a=SMALL, b=SMALL, c=SMALL)
    rows = rows_of(".", workers=between(lambda: Path("b.yaml").unlink(missing_ok=True)))
    assert [(row.case, row.exit_code) for row in rows] == [("a", 0), ("b", 5), ("c", 0)]
    assert "b.yaml: the case file cannot be read" in rows[1].error


def test_a_case_that_changes_its_name_in_between_writes_nothing(here):
    write(here, a=SMALL, b=SMALL)
    rows = rows_of(".", workers=between(lambda: write(here, b=SMALL + "name: a\n")))
    assert [(row.case, row.exit_code) for row in rows] == [("a", 0), ("b", 2)]
    assert "b.yaml: its name or folder has changed since the batch began" in rows[1].error


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
    def full(prefix):
        raise OSError(errno.ENOSPC, "No space left on device")

    write(here, a=SMALL)
    monkeypatch.setattr("bubblemesh.batch.worker.TemporaryDirectory", full)
    with pytest.raises(
        FileError, match=r"a.yaml: no place for temporary files: No space left on device: the batch ends"
    ):
        events_of(".")


@pytest.mark.parametrize(
    ("error", "expected"),
    [
        (OSError(errno.ENOSPC, "No space left on device"), True),
        (OSError("1000 requested and 12 written"), True),  # NumPy's
        (OSError(errno.EIO, "Input/output error"), False),
        (OSError("cannot identify image file"), False),
        (ValueError("no space"), False),
    ],
)
def test_a_full_disk_is_known_by_the_error_or_the_one_behind_it(error, expected):
    assert is_full(error) == expected
    told = FileError("cannot write a.msh")
    told.__cause__ = error
    assert is_full(told) == expected


@pytest.mark.parametrize("cut", [0, 5])
def test_a_summary_that_cannot_grow_ends_the_batch_with_whole_rows(cut, here, monkeypatch):
    write(here, a=SMALL, b=SMALL, c=SMALL)
    write_all = os.write

    def full(handle, content):
        if b'"case": "b"' not in content:
            return write_all(handle, content)
        if cut == 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        return write_all(handle, content[:cut])

    monkeypatch.setattr(os, "write", full)
    with pytest.raises(FileError, match=r"cannot write summary.jsonl"):
        events_of(".", workers=between(lambda: None))
    assert [line["case"] for line in lines_of(Path("summary.jsonl"))] == ["a"]
    assert [cells["case"] for cells in table_in(Path())] == ["a"]


def test_an_interrupt_between_the_two_files_of_a_row_leaves_them_alike(here, monkeypatch):
    write(here, a=SMALL, b=SMALL)
    append = Lines.append

    def interrupted(lines, text):
        if lines.path.suffix == ".csv" and text.startswith("b,"):
            monkeypatch.undo()
            raise KeyboardInterrupt
        append(lines, text)

    monkeypatch.setattr(Lines, "append", interrupted)
    with pytest.raises(KeyboardInterrupt):
        events_of(str(here), workers=between(lambda: None), folder=str(here))
    assert [line["case"] for line in lines_of(here / "summary.jsonl")] == ["a", "b"]
    assert [cells["case"] for cells in table_in(here)] == ["a", "b"]


@pytest.mark.parametrize("folder", ["/proc/nowhere/out", "file", "file/out"])
def test_a_folder_that_cannot_be_made_ends_the_batch_before_it_begins(folder, here):
    write(here, a=SMALL)
    Path("file").write_text("no folder")
    with pytest.raises(FileError, match=f"cannot write into {folder}: "):
        events_of("a.yaml", folder=folder, workers=lambda count: pytest.fail("work has begun"))


def test_a_read_only_folder_ends_the_batch_and_keeps_the_old_summary(here, monkeypatch):
    write(here, a=SMALL)
    rows_of("a.yaml")
    before = Path("summary.jsonl").read_bytes()

    def refuse(path, *arguments, **options):
        raise OSError(errno.EROFS, "Read-only file system", str(path))

    monkeypatch.setattr(os, "mkdir", refuse)
    with pytest.raises(FileError, match=r"cannot write \.: Read-only file system"):
        events_of("a.yaml")
    monkeypatch.undo()
    assert (here / "summary.jsonl").read_bytes() == before


def test_two_batches_do_not_write_one_summary(here):
    write(here, a=SMALL)

    def second():
        with pytest.raises(FileError, match="another batch is writing its summary here"):
            events_of("a.yaml")
        with pytest.raises(FileError, match="another batch"):
            events_of("a.yaml", shard=Shard(1, 2))

    rows_of("a.yaml", workers=between(second))
    assert not [name for name in names(here) if name.startswith(".")]


def test_shards_are_at_work_together_but_each_only_once(here):
    write(here, a=SMALL, b=SMALL)

    def others():
        events_of(".", shard=Shard(2, 2))
        with pytest.raises(FileError, match="another batch is writing the summary of this shard here: wait for it"):
            events_of(".", shard=Shard(1, 2))
        with pytest.raises(FileError, match="another batch is writing its summary here"):
            events_of(".")

    rows_of(".", workers=between(others), shard=Shard(1, 2))
    assert [line["case"] for line in lines_of(Path("summary-1-of-2.jsonl"))] == ["a"]
    assert not [name for name in names(here) if name.startswith(".")]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows removes no file that is open")
@pytest.mark.parametrize("what", ["out/summary.jsonl", "out/summary.csv", "out"])
@pytest.mark.parametrize("case", ["b", "c"])
def test_a_summary_that_is_removed_in_between_is_written_anew(case, what, here):
    write(here, a=SMALL, b=SMALL, c=SMALL)
    for event in stream(".", folder="out", workers=between(lambda: None)):
        if isinstance(event, Finished):
            assert lines_of(Path("out/summary.jsonl"))[-1]["case"] == event.row.case
        if isinstance(event, Finished) and event.row.case == case:
            path = Path(what)
            shutil.rmtree(path) if path.is_dir() else path.unlink()
    assert [line["case"] for line in lines_of(Path("out/summary.jsonl"))] == ["a", "b", "c"]
    assert [cells["case"] for cells in table_in(Path("out"))] == ["a", "b", "c"]


def test_a_summary_that_another_one_replaces_ends_the_batch(here):
    write(here, a=SMALL, b=SMALL)
    events = stream(".", folder="out", workers=between(lambda: None))
    next(events)
    Path("other").write_text("of another batch")
    Path("other").replace("out/summary.jsonl")
    with pytest.raises(FileError, match=r"out/summary.jsonl: another file has taken its place"):
        list(events)
    assert Path("out/summary.jsonl").read_text() == "of another batch"


# Workers that fail


class Failing(Executor):
    """Runs what it is given, but fails first: so many times, in this way, over the case of this name."""

    def __init__(self, times, error, name):
        self.left, self.error, self.name = times, error, name

    def submit(self, function, /, job, tell):
        future = Future()
        if job.place.name == self.name and self.left:
            self.left -= 1
            if self.error is CancelledError:
                future.cancel()
                future.set_running_or_notify_cancel()
            else:
                future.set_exception(self.error)
        else:
            future.set_result(function(job, tell))
        return future


def failing(times, error, failure=unexpected):
    @contextmanager
    def workers(count):
        notes = SimpleQueue()
        yield Workers(Failing(times, error, "b"), notes.put, notes, lambda: 2, failure, "out of reach")

    return workers


@pytest.mark.parametrize(("deaths", "attempts", "code"), [(0, 1, 0), (1, 2, 0), (2, 3, 0), (3, 3, 99)])
def test_the_death_of_a_worker_costs_a_retry_and_three_cost_the_case(deaths, attempts, code, here):
    write(here, a=SMALL, b=SMALL, c=SMALL)
    rows = rows_of(".", workers=failing(deaths, WorkerDied("gone", 6)))
    assert [row.exit_code for row in rows] == [0, code, 0]
    assert [row.attempts for row in rows] == [1, attempts, 1]
    assert (rows[1].error is None) == (code == 0)
    assert code == 0 or "(in each of 3 attempts)" in rows[1].error


def test_another_failure_of_a_worker_costs_the_case_at_once(here):
    write(here, a=SMALL, b=SMALL, c=SMALL)
    rows = rows_of(".", workers=failing(9, ValueError("lost in the post")))
    assert [(row.exit_code, row.attempts) for row in rows] == [(0, 1), (99, 1), (0, 1)]
    assert rows[1].error.startswith("b.yaml: ValueError('lost in the post')")


def test_workers_out_of_reach_end_the_batch_with_the_rows_until_then(here):
    write(here, a=SMALL, b=SMALL, c=SMALL)
    with pytest.raises(FileError, match="out of reach"):
        events_of(".", workers=failing(1, CancelledError))
    assert "b" not in [line["case"] for line in lines_of(Path("summary.jsonl"))]


# Shards


@pytest.mark.parametrize("text", ["0/4", "5/4", "1", "1/0", "a/b", "1/2/3", "-1/2", ""])
def test_a_shard_is_a_part_and_a_number_of_parts(text):
    with pytest.raises(CaseError, match=r"--shard .*from 1/16 to 16/16"):
        Shard.parsed(text)


def test_shards_are_disjoint_and_together_everything():
    parts = [Shard.parsed(f"{k}/4").of(range(10)) for k in range(1, 5)]
    assert sorted(entry for part in parts for entry in part) == list(range(10))
    assert {len(part) for part in parts} == {2, 3}
    assert Shard.parsed("1/1").of(range(3)) == [0, 1, 2]


def test_each_shard_has_a_summary_of_its_own(here):
    write(here, **{name: SMALL for name in "abcde"})
    rows_of(".", folder="whole")
    for index in range(1, 4):
        rows_of(*[path for path in names(here) if path.endswith("yaml")], folder="out", shard=Shard(index, 3))
    assert results_in(here / "out") == results_in(here / "whole")
    cases = {
        index: [line["case"] for line in lines_of(here / f"out/summary-{index}-of-3.jsonl")] for index in (1, 2, 3)
    }
    assert {index: sorted(found) for index, found in cases.items()} == {1: ["a", "d"], 2: ["b", "e"], 3: ["c"]}
    assert not Path("out/summary.jsonl").exists()
    ends = finished(".", folder="out", resume=True)
    assert [(end.row.case, end.unchanged) for end in ends] == [(name, True) for name in "abcde"]
    assert sorted(line["case"] for line in lines_of(Path("out/summary.jsonl"))) == list("abcde")


def test_shards_are_numbered_so_that_their_files_sort():
    assert Shard(3, 16).suffix == "-03-of-16"
    assert Shard(1, 1).suffix == ""


def test_a_collision_is_found_whichever_shard_the_cases_are_in(here):
    write(here, a__x=SMALL, b__x=SMALL)
    with pytest.raises(CaseError, match="would both write"):
        events_of("a", "b", folder="out", shard=Shard(1, 2))


def test_a_shard_may_be_empty(here):
    write(here, a=SMALL)
    assert rows_of(".", folder="out", shard=Shard(2, 2), workers=lambda count: pytest.fail("nothing to do")) == []
    assert lines_of(Path("out/summary-2-of-2.jsonl")) == []


# The command


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
    assert len(results_in(here / "out")) == 16


def test_the_command_tells_of_each_case_in_plain_lines_and_ends_with_the_largest_code(here):
    write(here, a=SMALL, b=BAD, c=SMALL.replace("spacing: 0.4", "spacing: 9"), d="spacing: 1\n")
    process = batch(".", "-o", "out", "--jobs", "1", folder=here)
    assert process.returncode == 3
    assert process.stdout == ""
    lines = process.stderr.splitlines()
    assert any(line.startswith("[") and "/4] a: " in line and " nodes, q " in line for line in lines)
    assert any(line.startswith("error: [") and "/4] b.yaml: domain: the outer ring" in line for line in lines)
    assert any(line.startswith("warning: c: ") for line in lines)
    assert lines[-1] == "4 cases: 2 done, 2 failed; summary in out/summary.jsonl"
    assert "\x1b" not in process.stderr
    quiet = batch(".", "-o", "out", "--jobs", "1", "-q", "--json", "--resume", folder=here)
    assert {line.split(":")[0] for line in quiet.stderr.splitlines()} == {"error"}
    summary = json.loads(quiet.stdout)
    assert (summary["cases"], summary["failed"], summary["unchanged"], summary["exit_code"]) == (4, 2, 2, 3)
    assert [row["case"] for row in summary["rows"]] == ["a", "b", "c", "d"]


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        ([], 2, "PATH"),
        (["empty"], 2, "error: empty: no case file is in this folder"),
        (["*.yml"], 2, "error: *.yml: no file fits this pattern"),
        (["a.yaml", "sub/a.yaml", "-o", "out"], 2, "a.yaml and sub/a.yaml would both write out/a.msh"),
        (["a.yaml", "--jobs", "0"], 2, "--jobs"),
        (["a.yaml", "--shard", "3/2"], 2, "--shard 3/2"),
        (["a.yaml", "--set", "x"], 2, "--set x"),
        (["a.yaml", "--cluster", "here"], 2, "--cluster here: must be the address"),
        (["a.yaml", "--cluster", "tcp://localhost:1", "--jobs", "2"], 2, "drop --jobs or --cluster"),
        (["a.yaml", "-o", "/proc/nowhere"], 5, "cannot write into /proc/nowhere"),
    ],
)
def test_a_mistake_ends_the_command_before_anything_is_meshed(arguments, code, message, here):
    write(here, a=SMALL, sub__a=SMALL)
    (here / "empty").mkdir()
    result = CliRunner().invoke(app, ["batch", *arguments], env={"COLUMNS": "200"})
    assert result.exit_code == code
    assert message in result.stderr
    assert "Traceback" not in result.stderr
    assert result.stdout == ""
    assert names(here) == ["a.yaml", "empty", "sub"]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no limit on the size of files")
def test_a_disk_that_fills_up_ends_the_command_with_whole_rows(here):
    write(here, a=SMALL + f"sweep: {{packing.seed: {list(range(12))}}}\n")
    limited = ["bash", "-c", 'ulimit -f 8; exec "$@"', "bash", *command("a.yaml", "--jobs", "1", "-o", "out")]
    process = subprocess.run(limited, cwd=here, capture_output=True, text=True, timeout=60)
    assert process.returncode == 5
    assert "error: cannot write out/summary.jsonl: " in process.stderr
    assert "Traceback" not in process.stderr
    rows = lines_of(here / "out/summary.jsonl")
    assert 0 < len(rows) < 12
    assert len(table_in(here / "out")) == len(rows)
    again = batch("a.yaml", "--jobs", "1", "-o", "out", "--resume", folder=here)
    assert again.returncode == 0, again.stderr
    assert f"{len(rows)} unchanged" in again.stderr
    assert len(lines_of(here / "out/summary.jsonl")) == 12
