"""Throughput of a batch of small cases: ``python -m benchmarks.batch`` compares one worker process with two.

The cases of all runs are the same, and the runs take turns, so that a busy moment of the machine meets both. Times
begin when the worker processes have loaded what they need. Processor time tells what a machine at rest can reach: two
cores have to do the work of the two workers and of the process that gives out the cases.
"""

import argparse
import platform
import tempfile
from contextlib import nullcontext
from pathlib import Path
from statistics import median
from time import perf_counter, process_time

from bubblemesh.batch import BatchListener, BatchOptions, case_files, plan_cases, run_batch
from bubblemesh.workers.local import local_workers

CASES = 200
TURNS = 3
CASE = """\
domain:
  outer: {{rectangle: [-1, -1, 1, 1], labels: [bottom, right, top, left]}}
  holes: [{{circle: {{center: [0, 0], radius: {radius}}}, label: hole}}]
spacing: 0.2
"""


class Run:
    """One batch: wall time, that of the meshing alone, and processor times of the workers and of the parent process."""

    def __init__(self, folder: Path, jobs: int, turn: int) -> None:
        options = BatchOptions(folder=str(folder / f"out-{jobs}-{turn}"))
        self.jobs = jobs
        with local_workers(jobs) as workers:
            # Calls one after the other go to one process after the other, which answers when it has loaded everything.
            before = [workers.submit(process_time).result() for _ in range(jobs)]
            begun, computing = perf_counter(), process_time()
            entries = plan_cases(case_files([str(folder / "cases")]), options)
            totals = run_batch(entries, options, lambda count: nullcontext(workers), BatchListener())
            self.seconds = perf_counter() - begun
            self.parent = process_time() - computing
            self.workers = sum(workers.submit(process_time).result() for _ in range(jobs)) - sum(before)
        assert totals["exit_code"] == 0
        self.cases = totals["cases"]
        self.meshing = sum(row["seconds"] for row in totals["rows"])

    @property
    def overhead(self) -> float:
        """Wall time per case and process beside its meshing, in milliseconds."""
        return 1e3 * (self.seconds * self.jobs - self.meshing) / self.cases

    def __str__(self) -> str:
        each = 1e3 / self.cases
        return (
            f"--jobs {self.jobs}: {self.seconds:.1f} s, {self.overhead:.1f} ms per case beside its meshing; processor "
            f"time per case {self.workers * each:.1f} ms of the workers, {self.parent * each:.1f} ms of the parent"
        )


def main() -> None:
    """Print how long batches take with one and with two processes, and what a case costs beside its own meshing."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=CASES)
    parser.add_argument("--turns", type=int, default=TURNS)
    chosen = parser.parse_args()
    runs: dict[int, list[Run]] = {1: [], 2: []}
    with tempfile.TemporaryDirectory() as folder:
        write_cases(Path(folder, "cases"), chosen.cases)
        for turn in range(chosen.turns):
            for jobs, done in runs.items():
                done.append(Run(Path(folder), jobs, turn))
                print(f"turn {turn + 1}: {done[-1]}", flush=True)
    print(f"Python {platform.python_version()} on {platform.system()} {platform.machine()}, {chosen.cases} cases")
    for jobs, done in runs.items():
        print(f"--jobs {jobs}: median overhead {median(run.overhead for run in done):.1f} ms per case")
    pairs = list(zip(runs[1], runs[2], strict=True))
    told = [one.seconds / two.seconds for one, two in pairs]
    possible = [2 * one.workers / (two.workers + two.parent) for one, two in pairs]
    print(
        f"2 jobs are {median(told):.2f} times as fast as 1; by processor time up to {median(possible):.2f} on two cores"
    )


def write_cases(folder: Path, count: int) -> None:
    """So many plates with holes of different sizes."""
    folder.mkdir()
    for number in range(count):
        text = CASE.format(radius=0.3 + 0.4 * number / count)
        (folder / f"plate-{number:03}.yaml").write_text(text)


if __name__ == "__main__":
    main()
