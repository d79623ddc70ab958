"""Time and memory that a run takes."""

import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from time import perf_counter

__all__ = ["peak_memory_mb", "timed"]


@contextmanager
def timed(seconds: dict[str, float], stage: str) -> Iterator[None]:
    """Note the time that the block takes."""
    begun = perf_counter()
    yield
    seconds[stage] = perf_counter() - begun


def peak_memory_mb() -> float | None:
    """Largest memory the process has held, in megabytes; None where the system does not tell."""
    status = Path("/proc/self/status")
    if status.exists():  # Linux, where the usage that it reports elsewhere begins with what the parent process held
        peak = re.search(r"^VmHWM:\s*(\d+) kB", status.read_text(), re.MULTILINE)
        if peak:
            return int(peak[1]) * 1024 / 1e6
    try:
        import resource
    except ImportError:  # Windows
        return None
    unit = 2**20 if sys.platform == "darwin" else 2**10
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6
