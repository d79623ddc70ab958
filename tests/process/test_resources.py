"""What spares a process work with its memory."""

import platform
import subprocess
import sys

import pytest

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
