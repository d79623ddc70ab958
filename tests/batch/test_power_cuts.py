"""What is said to be on the disk is there: the order in which files, folders, names and rows are brought to it."""

import errno
import os
import sys
from pathlib import Path

import pytest
from batch_cases import write
from batches import SMALL, lines_of, rows_of
from commands import command

from bubblemesh import console
from bubblemesh.batch.summary import GrowingFile
from bubblemesh.console import report

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the paths of open files are asked of Linux")


@pytest.fixture
def steps(monkeypatch):
    """What is done for lasting files, in its order: names of steps with paths."""
    done = []

    def noted(name, path_of, function):
        def noting(*arguments, **options):
            path = path_of(*arguments)
            result = function(*arguments, **options)
            done.append((name, os.path.relpath(path)))
            return result

        return noting

    def opened(number):
        return Path(f"/proc/self/fd/{number}").readlink()

    monkeypatch.setattr(os, "fsync", noted("sync", opened, os.fsync))
    monkeypatch.setattr(os, "replace", noted("name", lambda old, new: new, os.replace))
    monkeypatch.setattr(Path, "replace", noted("name", lambda old, new: new, Path.replace))
    monkeypatch.setattr(GrowingFile, "append", noted("row", lambda lines, text: lines.path, GrowingFile.append))
    return done


def require_lasting(steps, folder, names, end):
    """Each file was synced before it got its name, then the folder, and all that before the end."""
    last = steps.index(end)
    named = [steps.index(("name", f"{folder}/{name}")) for name in names]
    for k, name in zip(named, names, strict=True):
        synced = [path for step, path in steps[:k] if step == "sync"]
        assert any(path.startswith(f"{folder}/.bubblemesh-") and path.endswith(f"/{name}") for path in synced)
    assert ("sync", folder) in steps[max(named) : last]


def test_a_row_is_written_when_its_files_are_on_the_disk_and_told_when_it_is(here, steps):
    write(here, a=SMALL)
    (row,) = rows_of("a.yaml", folder="deep/out")
    assert set(row.files) == {"a.msh", "a.report.json"}
    require_lasting(steps, "deep/out", row.files, ("row", "deep/out/summary.jsonl"))
    lines, table = steps.index(("row", "deep/out/summary.jsonl")), steps.index(("row", "deep/out/summary.csv"))
    assert ("sync", "deep/out/summary.jsonl") in steps[lines:table]
    require_lasting(steps, "deep/out", ["summary.jsonl", "summary.csv"], ("row", "deep/out/summary.jsonl"))
    for parent in (".", "deep"):  # of the folders that were made
        assert ("sync", parent) in steps[:lines]


def test_files_that_are_read_at_once_are_not_synced(here, steps):
    write(here, a=SMALL)
    rows_of("a.yaml", folder="out")
    synced = [path for step, path in steps if step == "sync"]
    assert not [path for path in synced if path.startswith("..")]


@pytest.mark.parametrize("out", ["out", "new/out"])
def test_a_run_tells_of_files_that_are_on_the_disk(out, here, steps, monkeypatch):
    write(here, a=SMALL)
    monkeypatch.setattr(report, "show_files", lambda folder, files: steps.append(("told", folder)))
    assert command("run", "a.yaml", "-o", out)[0] == 0
    require_lasting(steps, out, ["a.msh", "a.report.json"], ("told", out))
    assert ("sync", str(Path(out).parent)) in steps[: steps.index(("told", out))]


def test_a_case_file_that_is_said_to_be_written_is_on_the_disk(here, steps, monkeypatch):
    monkeypatch.setattr(console, "tell", lambda text: steps.append(("told", ".")))
    assert command("init", "new.yaml")[0] == 0
    assert steps == [("sync", "new.yaml"), ("sync", "."), ("told", "."), ("told", ".")]


@pytest.mark.parametrize("at", ["a.msh", "out"])
def test_a_disk_that_fails_to_keep_files_is_told_and_old_files_stay(at, here, monkeypatch):
    write(here, a=SMALL)
    (here / "out").mkdir()
    (here / "out/a.msh").write_text("old")
    sync = os.fsync

    def failing(number):
        if Path(f"/proc/self/fd/{number}").readlink().name == at:
            raise OSError(errno.EIO, "Input/output error")
        sync(number)

    monkeypatch.setattr(os, "fsync", failing)
    code, _, message = command("run", "a.yaml", "-o", "out")
    assert code == 5
    assert "cannot write out: Input/output error" in message
    assert (here / "out/a.msh").read_text() == "old"
    assert sorted(path.name for path in (here / "out").iterdir()) == ["a.msh"]


def test_a_folder_that_needs_no_sync_is_no_error(here, monkeypatch):
    write(here, a=SMALL)
    sync = os.fsync

    def without_folders(number):
        if Path(f"/proc/self/fd/{number}").is_dir():
            raise OSError(errno.EINVAL, "Invalid argument")
        sync(number)

    monkeypatch.setattr(os, "fsync", without_folders)
    assert [row.exit_code for row in rows_of("a.yaml", folder="out")] == [0]
    assert len(lines_of(Path("out/summary.jsonl"))) == 1
