"""Cases go to workers, wherever these are, and come back."""

from abc import ABC, abstractmethod
from collections import Counter, deque
from collections.abc import Callable, Collection, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from dataclasses import replace
from pathlib import Path
from queue import SimpleQueue
from time import sleep
from typing import Any, TypeVar

from bubblemesh.batch.plan import Entry
from bubblemesh.batch.row import Row
from bubblemesh.batch.worker import Job, Note, Outcome, Tell, mesh_job
from bubblemesh.errors import FileError, LimitError

T = TypeVar("T")

ATTEMPTS = 3  # of a case whose worker process dies
RECALLS = 20  # of a case whose workers leave before they have begun it
TICK = 0.2  # seconds between looks at the notes of running jobs


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


class WorkerDied(BrokenExecutor):
    """A worker process has ended without being asked to; the arguments are an exit code and words, as of `failure`."""


LEFT = WorkerDied(LimitError.exit_code, "the workers that were to mesh it have left, perhaps for want of memory")


class Workers(ABC):
    """Worker processes.

    If they are out of reach, futures are cancelled, or `submit` or `capacity` raise a FileError. Futures that are
    ``recalled`` are cancelled since the workers that they were for have left, which costs no attempt by itself.
    """

    tell: Tell  # run in a worker, it brings a note to the queue here
    lost: str  # words of the FileError

    def __init__(self) -> None:
        self.notes: SimpleQueue[Note] = SimpleQueue()
        self.recalled: set[Future[Any]] = set()

    @abstractmethod
    def submit(self, function: Callable[..., T], /, *arguments: object) -> Future[T]:
        """Call a function in a worker; a `WorkerDied` of the future costs another attempt."""

    @abstractmethod
    def capacity(self) -> int:
        """Number of jobs to have submitted, so that no worker has to wait."""

    @abstractmethod
    def failure(self, error: BaseException) -> tuple[int, str]:
        """Exit code and words for a job that could not be run, from the exception of its future."""

    def missing(self) -> str | None:
        """Warning while there are no workers; else None."""
        return None

    def refused(self) -> list[str]:
        """Warnings of the workers that have been left out since the last call."""
        return []


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


def wait_for_any(running: Collection[Future[T]]) -> list[Future[T]]:
    """Futures that have ended, after a wait for one that is `TICK` seconds at most.

    A future that was cancelled here has ended even if nobody has taken note of it, for which `wait` would wait.
    """
    wait(running, TICK, FIRST_COMPLETED)
    return [future for future in running if future.done()]


def problem_of(future: Future[Any], workers: Workers) -> BaseException | None:
    """Why an ended future has no result, None if it has one; FileError if the workers are out of reach."""
    if future in workers.recalled:
        return LEFT
    if future.cancelled():
        raise FileError(workers.lost)
    return future.exception()


def _failed(row: Row, problem: BaseException, workers: Workers, times: int) -> Row:
    code, words = workers.failure(problem)
    attempts = f" (in each of {times} attempts)" if times > 1 else ""
    return row.failed(code, f"{row.source}: {words}{attempts}")
