"""Memory that a run takes, processor cores that it may use, and settings that make memory cheaper to use."""

import ctypes
import gc
import os
import re
import sys
from contextlib import suppress
from math import ceil
from pathlib import Path
from time import perf_counter, thread_time

TASKS = Path("/proc/self/task")  # the threads of this process
QUOTA = Path("/sys/fs/cgroup/cpu.max")  # of a container: microseconds of computing in a period, and the period

# Objects after which Python looks for garbage: after 700, it would do so hundreds of times while it loads and reads
# files. A packing leaves no large arrays in cycles behind, so that this takes no more memory.
MANY_OBJECTS = 300_000


LEAST_WORK = 0.05  # seconds that tell how much of the processor a thread gets


class WorkClock:
    """Times of a thread since the clock was made: how much of the processor it gets beside other programs."""

    def __init__(self) -> None:
        self._begun, self._worked = perf_counter(), thread_time()

    def slowness(self) -> float:
        """How many times as long work takes as it would alone, at least 1."""
        return max((perf_counter() - self._begun) / max(thread_time() - self._worked, LEAST_WORK), 1.0)


def seldom_look_for_garbage() -> None:
    """Let Python look for garbage seldom, and not among present objects; only for processes of bubblemesh itself."""
    gc.set_threshold(MANY_OBJECTS)
    gc.freeze()  # else all loaded modules are looked through again and again while a file with many sides is read


# Numbers of two parameters of glibc's mallopt, and their values in bytes. Free memory at the end of the heap goes back
# to the system if it is more than the first; arrays larger than the second (at its greatest value) are not in the heap.
TRIM_THRESHOLD, MMAP_THRESHOLD = (-1, 64 << 20), (-3, 32 << 20)


def keep_freed_memory() -> None:
    """Let the C library keep the memory of arrays that are gone; only for processes of bubblemesh itself.

    By default the system gets it back, and clears it for the next array, which takes a tenth of the time of a large
    packing. C libraries other than glibc stay as they are.
    """
    if sys.platform == "linux":
        with suppress(AttributeError):
            mallopt = ctypes.CDLL(None).mallopt
            for limit in (TRIM_THRESHOLD, MMAP_THRESHOLD):
                mallopt(*limit)


def peak_memory_mb() -> float | None:
    """Largest memory that the process has held, in megabytes; None if the system does not show it."""
    status = Path("/proc/self/status")
    if status.exists():  # Linux; its other figure, that of getrusage, begins with what the parent process held
        peak = re.search(r"^VmHWM:\s*(\d+) kB", status.read_text(), re.MULTILINE)
        if peak:
            return int(peak[1]) * 1024 / 1e6
    try:
        import resource
    except ImportError:  # Windows
        return None
    unit = 2**20 if sys.platform == "darwin" else 2**10
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6


def forget_peak_memory() -> None:
    """Reset the peak to what the process holds now, if the system can do that."""
    with suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")


def has_other_threads() -> bool:
    """Whether this process has threads beside this one, of libraries too; also where the system does not show that."""
    try:
        return len([*TASKS.iterdir()]) > 1
    except OSError:
        return True


def available_cores() -> int:
    """Number of processor cores that this process may use."""
    # Not on macOS and Windows.
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    with suppress(OSError, ValueError):
        quota, period = map(int, QUOTA.read_text().split())  # "max" is not a number
        cores = min(cores, ceil(quota / period))
    return max(cores, 1)
