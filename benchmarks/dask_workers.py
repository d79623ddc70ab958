"""A scheduler of Dask with some workers, each a process of its own, for as long as a benchmark takes."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from time import monotonic, sleep
from typing import NamedTuple

PATIENCE = 60.0  # seconds until the scheduler has to listen
QUIET = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}


class DaskWorkers(NamedTuple):
    """Where their scheduler listens, and the numbers of the workers' processes."""

    address: str
    pids: Sequence[int]


@contextmanager
def dask_workers(count: int, folder: Path) -> Iterator[DaskWorkers]:
    """So many workers of one thread each, which keep their files in a folder and end with the block."""
    processes = list[subprocess.Popen[bytes]]()

    def start(*arguments: str) -> int:
        line = [sys.executable, "-m", "dask", *arguments, "--no-dashboard"]
        environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[1]), "OMP_NUM_THREADS": "1"}
        processes.append(subprocess.Popen(line, cwd=folder, env=environment, **QUIET))
        return processes[-1].pid

    file = folder / "scheduler.json"
    try:
        start("scheduler", "--port", "0", "--scheduler-file", str(file))
        end = monotonic() + PATIENCE
        while not (file.exists() and file.read_text().endswith("}")):
            assert monotonic() < end, "the scheduler does not start"
            sleep(0.02)
        address = json.loads(file.read_text())["address"]
        yield DaskWorkers(address, [start("worker", address, "--nthreads", "1", "--no-nanny") for _ in range(count)])
    finally:
        for process in reversed(processes):
            process.kill()
            process.wait()
