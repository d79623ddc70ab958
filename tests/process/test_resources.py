"""What spares a process work with its memory."""

import platform
import subprocess
import sys

import pytest

from bubblemesh.process.resources import LEAST_WORK, WorkClock

PROGRAM = """
import resource
import numpy as np
from bubblemesh.process.resources import keep_freed_memory
{0}
for _ in range(20):
    arrays = [np.ones(1_000_000) for _ in range(5)]
    del arrays
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt)
"""


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="other C libraries go on as they do")
def test_memory_that_arrays_gave_back_is_used_again():
    faults = [
        int(subprocess.run([sys.executable, "-c", PROGRAM.format(call)], capture_output=True, check=True).stdout)
        for call in ("keep_freed_memory()", "")
    ]
    assert faults[0] < 0.5 * faults[1]  # pages that the system had to clear


@pytest.mark.parametrize(
    ("waited", "worked", "slowness"),
    [(3.0, 1.0, 3.0), (1.0, 1.0, 1.0), (LEAST_WORK / 2, 0.0, 1.0), (1.0, 0.0, 1.0 / LEAST_WORK)],
)
def test_work_is_slowed_down_by_what_others_take_of_the_processor(waited, worked, slowness, monkeypatch):
    now = {"perf_counter": 100.0, "thread_time": 7.0}
    for name in now:
        monkeypatch.setattr(f"bubblemesh.process.resources.{name}", lambda name=name: now[name])
    clock = WorkClock()
    now.update(perf_counter=100.0 + waited, thread_time=7.0 + worked)
    assert clock.slowness() == pytest.approx(slowness)
