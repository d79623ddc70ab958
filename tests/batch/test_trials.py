"""A sample of the trials of ``benchmarks/robustness`` that end batches in the middle or fill the disk."""

import shutil
import signal
import sys

import pytest

from benchmarks.robustness import batches, disk, kills

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


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no compiler")
def test_a_full_disk_is_an_error_of_the_file_and_changes_none(tmp_path):
    found = dict(disk.trials("run", disk.compiled(tmp_path), step=40))
    assert len(found) > 1
    assert set(map(tuple, found.values())) == {()}


def test_many_cases_are_gone_on_from_without_meshing_them_again(tmp_path):
    (tmp_path / "a.yaml").write_text(batches.CASE + f"sweep: {{packing.seed: {list(range(100))}}}\n")
    _, first, _ = batches.timed(tmp_path, "-j", "2")
    _, again, megabytes = batches.timed(tmp_path, "--resume")
    assert again < first
    assert megabytes < 500
