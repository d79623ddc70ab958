"""Cases go to workers, wherever these are, and come back."""

from abc import ABC, abstractmethod
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait
from dataclasses import replace
from pathlib import Path
from queue import SimpleQueue
from typing import TypeVar

from bubblemesh.batch.plan import Entry
from bubblemesh.batch.row import Row
from bubblemesh.batch.worker import Job, Note, Outcome, Tell, mesh_job
from bubblemesh.errors import FileError

T = TypeVar("T")

ATTEMPTS = 3  # of a case whose worker process dies
TICK = 0.2  # seconds between looks at the notes of running jobs


class Progress:
    """Hears how a batch goes on; here nobody listens."""

    def begin(self, entries: list[Entry], unchanged: int, summary: Path) -> None:
        """Hear of all cases of the batch, how many of them are done already, and the file of the summary."""

    def note(self, number: int, finished_rounds: int, nodes: int) -> None:
        """Hear how far a running case is; 0 nodes before the first round."""

    def wait(self, message: str) -> None:
        """Hear why there are no workers now."""

    def finish(self, number: int, row: Row, *, unchanged: bool = False) -> None:
        """Hear that a case has its row; ``unchanged`` if an earlier batch had done it."""


class WorkerDied(BrokenExecutor):
    """A worker process has ended without being asked to; the arguments are an exit code and words, as of `failure`."""


class Workers(ABC):
    """Worker processes.

    If they are out of reach, futures are cancelled, or `submit` or `capacity` raise a FileError.
    """

    tell: Tell  # run in a worker, it brings a note to the queue here
    lost: str  # words of the FileError

    def __init__(self) -> None:
        self.notes: SimpleQueue[Note] = SimpleQueue()

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


def dispatch(entries: Iterable[Entry], workers: Workers, progress: Progress) -> Iterator[tuple[Entry, Outcome]]:
    """Keep the workers busy, and give the outcome of each case as it ends; FileError if they are out of reach."""
    left = deque(entries)
    running: dict[Future[Outcome], tuple[Entry, Job]] = {}
    submitted, begun = Counter[int](), Counter[int]()  # how often each case was given out, and a worker has begun it

    def submit(entry: Entry, job: Job) -> None:
        submitted[job.number] += 1
        running[workers.submit(mesh_job, job, workers.tell)] = entry, job

    missing: str | None = None
    while left or running:
        capacity, before, missing = workers.capacity(), missing, workers.missing()
        if missing and not before:
            progress.wait(missing)
        while left and len(running) < capacity:
            entry = left.popleft()
            job = entry.job()
            if isinstance(job, Job):
                submit(entry, job)
            else:
                yield entry, Outcome(job)
        ended, _ = wait(running, TICK, FIRST_COMPLETED)
        for _ in range(workers.notes.qsize()):
            number, finished_rounds, nodes = workers.notes.get()
            begun[number] += finished_rounds == 0
            progress.note(number, finished_rounds, nodes)
        for future in ended:
            entry, job = running.pop(future)
            times = submitted[job.number]
            try:
                problem = future.exception()
            except CancelledError:
                raise FileError(workers.lost) from None
            if isinstance(problem, WorkerDied) and times < ATTEMPTS:
                submit(entry, job)
                continue
            outcome = future.result() if problem is None else Outcome(_failed(job.row, problem, workers, times))
            attempts = max(times, begun[job.number])  # a cluster tries again by itself
            yield entry, replace(outcome, row=replace(outcome.row, attempts=attempts))


def _failed(row: Row, problem: BaseException, workers: Workers, times: int) -> Row:
    code, words = workers.failure(problem)
    attempts = f" (in each of {times} attempts)" if times > 1 else ""
    return row.failed(code, f"{row.source}: {words}{attempts}")
