"""Time and memory that a run takes."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
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
    try:
        import resource
    except ImportError:  # Windows
        return None
    unit = 2**20 if sys.platform == "darwin" else 2**10
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6
