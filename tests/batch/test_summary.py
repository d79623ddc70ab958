"""The summary: full disks, interrupts, other batches, and workers that are lost."""

import errno
import os
import shutil
import subprocess
import sys
from concurrent.futures import CancelledError, ThreadPoolExecutor
from pathlib import Path
from threading import Barrier

import pytest
from batch_cases import between, failing, names, table_in, write
from batches import (
    BAD,
    SMALL,
    Begun,
    Finished,
    batch,
    command,
    events_of,
    follow,
    lines_of,
    rows_of,
)
from typer.testing import CliRunner

from bubblemesh.batch import BatchOptions
from bubblemesh.batch.folders import reserved
from bubblemesh.batch.summary import GrowingFile
from bubblemesh.batch.worker import is_full
from bubblemesh.cli import app
from bubblemesh.errors import FileError
from bubblemesh.files import UnwrittenError
from bubblemesh.workers.workers import WorkerDied


@pytest.mark.parametrize(
    ("error", "expected"),
    [
        (OSError(errno.ENOSPC, "No space left on device"), True),
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


@pytest.mark.parametrize(("kind", "expected"), [(UnwrittenError, True), (FileError, False)])
def test_a_file_that_could_not_be_written_without_a_reason_tells_of_a_full_disk(kind, expected):
    error = kind("cannot write a.msh")
    error.__cause__ = OSError("1000 requested and 12 written")  # NumPy's
    assert is_full(error) == expected


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
    append = GrowingFile.append

    def interrupted(lines, text):
        if lines.path.suffix == ".csv" and text.startswith("b,"):
            monkeypatch.undo()
            raise KeyboardInterrupt
        append(lines, text)

    monkeypatch.setattr(GrowingFile, "append", interrupted)
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
            events_of("a.yaml", shard=(1, 2))

    rows_of("a.yaml", workers=between(second))
    assert not [name for name in names(here) if name.startswith(".")]


def test_shards_are_at_work_together_but_each_only_once(here):
    write(here, a=SMALL, b=SMALL)

    def others():
        events_of(".", shard=(2, 2))
        with pytest.raises(FileError, match="another batch is writing the summary of this shard here: wait for it"):
            events_of(".", shard=(1, 2))
        with pytest.raises(FileError, match="another batch is writing its summary here"):
            events_of(".")

    rows_of(".", workers=between(others), shard=(1, 2))
    assert [line["case"] for line in lines_of(Path("summary-1-of-2.jsonl"))] == ["a"]
    assert not [name for name in names(here) if name.startswith(".")]


@pytest.mark.parametrize("number", [errno.ENOSYS, errno.ENOTSUP, errno.ENOLCK])
def test_a_file_system_without_locks_keeps_nobody_out(number, here, monkeypatch):
    fcntl = pytest.importorskip("fcntl", reason="this system locks in another way")

    def refuse(handle, how):
        raise OSError(number, os.strerror(number))

    write(here, a=SMALL)
    monkeypatch.setattr(fcntl, "flock", refuse)
    rows_of("a.yaml", workers=between(lambda: rows_of("a.yaml", shard=(1, 2))))
    assert len(lines_of(Path("summary.jsonl"))) == len(lines_of(Path("summary-1-of-2.jsonl"))) == 1
    assert not [name for name in names(here) if name.startswith(".")]


def test_shards_that_begin_at_once_do_not_hinder_each_other(here):
    def begin(index):
        with reserved(BatchOptions(shard=(index, 8))):
            ready.wait(timeout=30)

    ready = Barrier(8)
    with ThreadPoolExecutor(8) as executor:
        assert list(executor.map(begin, range(1, 9))) == [None] * 8
    assert names(here) == []


@pytest.mark.skipif(sys.platform == "win32", reason="Windows removes no file that is open")
@pytest.mark.parametrize("what", ["out/summary.jsonl", "out/summary.csv", "out"])
@pytest.mark.parametrize("case", ["b", "c"])
def test_a_summary_that_is_removed_in_between_is_written_anew(case, what, here):
    write(here, a=SMALL, b=SMALL, c=SMALL)

    def remove(event):
        if isinstance(event, Finished):
            assert lines_of(Path("out/summary.jsonl"))[-1]["case"] == event.row.case
        if isinstance(event, Finished) and event.row.case == case:
            path = Path(what)
            shutil.rmtree(path) if path.is_dir() else path.unlink()

    follow(remove, ".", folder="out", workers=between(lambda: None))
    assert [line["case"] for line in lines_of(Path("out/summary.jsonl"))] == ["a", "b", "c"]
    assert [cells["case"] for cells in table_in(Path("out"))] == ["a", "b", "c"]


def test_a_summary_that_another_one_replaces_ends_the_batch(here):
    write(here, a=SMALL, b=SMALL)

    def replace(event):
        if isinstance(event, Begun):
            Path("other").write_text("of another batch")
            Path("other").replace("out/summary.jsonl")

    with pytest.raises(FileError, match=r"out/summary.jsonl: another file has taken its place"):
        follow(replace, ".", folder="out", workers=between(lambda: None))
    assert Path("out/summary.jsonl").read_text() == "of another batch"


@pytest.mark.parametrize(("deaths", "attempts", "code"), [(0, 1, 0), (1, 2, 0), (2, 3, 0), (3, 3, 99)])
def test_the_death_of_a_worker_costs_a_retry_and_three_cost_the_case(deaths, attempts, code, here):
    write(here, a=SMALL, b=SMALL, c=SMALL)
    rows = rows_of(".", workers=failing(deaths, WorkerDied(6, "gone")))
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


@pytest.mark.long
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


@pytest.mark.skipif(sys.platform != "linux", reason="other file systems refuse such names")
def test_a_name_that_is_no_text_or_a_formula_is_a_row_and_harmless(here):
    write(here, **{"=1+cmd": SMALL, "b\x1b[31m": SMALL, "d\n=1": BAD})
    Path(os.fsdecode(b"c\xff.yaml")).write_text(SMALL)
    rows = rows_of(".", folder="out", page=True)
    assert [row.exit_code for row in rows] == [0, 2, 2, 2]
    assert {line["source"] for line in lines_of(Path("out/summary.jsonl"))} == {row.source for row in rows}
    for name in ("summary.csv", "summary.jsonl", "index.html"):
        text = Path("out", name).read_text(encoding="utf-8")
        assert text.replace("\n", "").isprintable(), name
    cells = table_in(Path("out"))
    assert {row["case"] for row in cells} == {"'=1+cmd", r"b\x1b[31m", r"c\udcff", r"d\n=1"}
