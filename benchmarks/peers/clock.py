"""What meshing takes: processor time between two moments, and the memory of the whole process."""

import resource
from pathlib import Path
from time import process_time
from typing import Self

from bubblemesh.process.resources import peak_memory_mb

STATUS = Path("/proc/self/status")


class Clock:
    """Processor seconds of the block under ``with``, those of processes that it waited for included.

    Attributes
    ----------
    seconds : float
        From `start` to the last `stop`.
    ready_mb : float
        Largest memory that the process had held before.
    """

    seconds = 0.0
    ready_mb = 0.0

    def start(self) -> None:
        """Begin to count."""
        self.ready_mb = peak_mb()
        self._begun = _processor_seconds()

    def stop(self) -> None:
        """Note the time since the start; may be called again, later."""
        self.seconds = _processor_seconds() - self._begun

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *error: object) -> None:
        self.stop()


def peak_mb() -> float:
    """Largest memory, in megabytes, that this process or one that it waited for has held."""
    waited_for = resource.getrusage(resource.RUSAGE_CHILDREN)
    return max(_own_peak_mb(), waited_for.ru_maxrss * 2**10 / 1e6)


def _own_peak_mb() -> float:
    # The general figure starts, on Linux, at what the process that started this one had held.
    if STATUS.exists():
        kilobytes = next(line.split()[1] for line in STATUS.read_text().splitlines() if line.startswith("VmHWM"))
        return int(kilobytes) * 2**10 / 1e6
    return peak_memory_mb() or 0.0


def _processor_seconds() -> float:
    waited_for = resource.getrusage(resource.RUSAGE_CHILDREN)
    return process_time() + waited_for.ru_utime + waited_for.ru_stime
