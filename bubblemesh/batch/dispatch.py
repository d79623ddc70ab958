"""Cases go to workers, wherever these are, and come back."""

from collections import Counter, deque
from collections.abc import Iterable, Iterator
from concurrent.futures import Future
from dataclasses import replace
from pathlib import Path
from time import sleep

from bubblemesh.batch.plan import Entry
from bubblemesh.batch.row import Row
from bubblemesh.batch.worker import Job, Outcome, mesh_job
from bubblemesh.workers.workers import ATTEMPTS, LEFT, RECALLS, TICK, WorkerDied, Workers, problem_of, wait_for_any


class Progress:
    """Hears how a batch goes on; here nobody listens."""

    def begin(self, entries: list[Entry], unchanged: int, summary: Path) -> None:
        """Hear of all cases of the batch, how many of them are done already, and the file of the summary."""

    def note(self, number: int, finished_rounds: int, nodes: int) -> None:
        """Hear how far a running case is; 0 nodes before the first round."""

    def wait(self, message: str) -> None:
        """Hear why there are no workers now."""

    def refuse(self, message: str) -> None:
        """Hear that a worker is left out, and why."""

    def finish(self, number: int, row: Row, *, unchanged: bool = False) -> None:
        """Hear that a case has its row; ``unchanged`` if an earlier batch had done it."""


def dispatch(entries: Iterable[Entry], workers: Workers, progress: Progress) -> Iterator[tuple[Entry, Outcome]]:
    """Keep the workers busy, and give the outcome of each case as it ends; FileError if they are out of reach."""
    left: deque[tuple[Entry, Job | None]] = deque((entry, None) for entry in entries)
    running: dict[Future[Outcome], tuple[Entry, Job]] = {}
    # How often each case was given out, how often of these in vain, and a worker has begun it.
    submitted, recalled, begun = Counter[int](), Counter[int](), Counter[int]()
    missing: str | None = None
    while left or running:
        capacity, before, missing = workers.capacity(), missing, workers.missing()
        if missing and not before:
            progress.wait(missing)
        for message in workers.refused():
            progress.refuse(message)
        while left and len(running) < capacity:
            entry, known = left.popleft()
            job = known or entry.job()
            if isinstance(job, Job):
                submitted[job.number] += 1
                running[workers.submit(mesh_job, job, workers.tell)] = entry, job
            else:
                yield entry, Outcome(job)
        if left and not running:
            sleep(TICK)
        ended = wait_for_any(running)
        for _ in range(workers.notes.qsize()):
            number, finished_rounds, nodes = workers.notes.get()
            begun[number] += finished_rounds == 0
            progress.note(number, finished_rounds, nodes)
        for future in ended:
            entry, job = running.pop(future)
            problem = problem_of(future, workers)
            recalled[job.number] += problem is LEFT
            times = submitted[job.number] - recalled[job.number]
            attempts = max(times, begun[job.number])  # a cluster tries again by itself
            if isinstance(problem, WorkerDied) and attempts < ATTEMPTS and recalled[job.number] < RECALLS:
                left.appendleft((entry, job))
                continue
            outcome = future.result() if problem is None else Outcome(_failed(job.row, problem, workers, times))
            yield entry, replace(outcome, row=replace(outcome.row, attempts=attempts))


def _failed(row: Row, problem: BaseException, workers: Workers, times: int) -> Row:
    code, words = workers.failure(problem)
    attempts = f" (in each of {times} attempts)" if times > 1 else ""
    return row.failed(code, f"{row.source}: {words}{attempts}")
