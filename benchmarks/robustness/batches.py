"""A batch of very many tiny cases, end to end: ``python -m benchmarks.robustness batches --cases 10000``.

Its rate, the memory of the process that runs it, and the time of ``--resume`` when all is done.
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

from benchmarks.robustness.commands import square_case
from benchmarks.robustness.trials import note

CASE = square_case(0.6, "rounds: 1, iterations: 2")
GOAL = 10.0  # seconds of --resume


def timed(folder: Path, *arguments: str) -> tuple[float, float, float]:
    """Seconds on the clock, those of processors, and the largest memory in MB of a batch that has to succeed."""
    line = [sys.executable, "-m", "bubblemesh", "batch", "a.yaml", "-q", "-o", "out", *arguments]
    begun, before = perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(line, cwd=folder, env=os.environ, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    worked = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return perf_counter() - begun, worked, after.ru_maxrss / 1e3


def main(arguments: list[str]) -> None:
    """Mesh the cases, go on when all are done, and tell how long that takes."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--cases", type=int, default=10_000)
    parser.add_argument("--folder", type=Path, help="of an earlier trial, to go on with")
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory(prefix="batches-") as temporary:
        folder = options.folder or Path(temporary)
        folder.mkdir(exist_ok=True)
        (folder / "a.yaml").write_text(f"{CASE}sweep: {{packing.seed: {list(range(options.cases))}}}\n")
        for what in ("all", "all again"):
            seconds, worked, megabytes = timed(folder, "--resume")
            rate = f"{options.cases / seconds:.1f} cases per second, processors {worked:.1f} s"
            print(f"{what}: {seconds:.1f} s, {rate}, at most {megabytes:.0f} MB", flush=True)
        rows = (folder / "out/summary.jsonl").read_bytes().count(b"\n")
    print(
        f"{rows} rows; --resume of what is done: {seconds:.1f} s, {'within' if seconds < GOAL else 'above'} {GOAL:g} s"
    )
    figures = {
        "seconds of --resume": round(seconds, 1),
        "of processors": round(worked, 1),
        "mean load": round(os.getloadavg()[0], 1),
    }
    note("batches", {"cases": rows, **figures, "MB at most": round(megabytes)})
    raise SystemExit(rows != options.cases)
