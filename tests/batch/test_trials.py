"""A sample of the trials of ``benchmarks/robustness`` that disturb commands while they are at work."""

import shutil
import signal
import sys

import pytest

from benchmarks.robustness import batches, changes, clock, disk, kills
from benchmarks.robustness.commands import compiled

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(sys.platform != "linux", reason="processes and libraries are looked at as Linux has them"),
]


@pytest.mark.parametrize(
    ("kind", "number", "seconds"),
    [("run", signal.SIGKILL, 1.5), ("batch", signal.SIGKILL, 3.0), ("batch", signal.SIGINT, 2.5), ("shard", 15, 3.0)],
)
def test_a_kill_leaves_no_half_file_and_no_process(kind, number, seconds):
    assert kills.trial(kind, signal.Signals(number), 1.0, seconds) == []


needs_compiler = pytest.mark.skipif(shutil.which("cc") is None, reason="there is no compiler")


@needs_compiler
def test_a_full_disk_is_an_error_of_the_file_and_changes_none(tmp_path):
    found = dict(disk.trials("run", compiled(tmp_path, disk.LIBRARY), step=40))
    assert len(found) > 1
    assert set(map(tuple, found.values())) == {()}


@needs_compiler
@pytest.mark.parametrize(("kind", "jump"), [("run", "10 years on"), ("batch", "2 hours back")])
def test_a_clock_that_jumps_changes_neither_limits_nor_times(kind, jump, tmp_path):
    assert clock.trial(kind, compiled(tmp_path, clock.LIBRARY), clock.JUMPS[jump], 1.0) == []


@pytest.mark.parametrize(("mode", "change"), [("trusted", "pipe"), ("untrusted", "link to elsewhere")])
def test_files_that_change_in_a_batch_harm_no_other_case(mode, change):
    assert changes.trial(change, changes.MODES[mode], seed=0) == []


def test_many_cases_are_gone_on_from_without_meshing_them_again(tmp_path):
    (tmp_path / "a.yaml").write_text(batches.CASE + f"sweep: {{packing.seed: {list(range(100))}}}\n")
    _, first, _ = batches.timed(tmp_path, "-j", "2")
    _, again, megabytes = batches.timed(tmp_path, "--resume")
    assert again < first
    assert megabytes < 500
