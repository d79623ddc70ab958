"""How cases go to the workers, and come back."""

from collections import Counter, deque
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from dataclasses import dataclass, replace
from queue import Empty

from bubblemesh.batch.events import Waiting
from bubblemesh.batch.jobs import Job, Note, Outcome
from bubblemesh.batch.plan import Entry, Settings, job_of
from bubblemesh.batch.worker import mesh_job
from bubblemesh.batch.workers import WorkerDied, Workers
from bubblemesh.errors import BubblemeshError, FileError

ATTEMPTS = 3  # of a case whose worker process dies
TICK = 0.2  # seconds between looks at the notes of running jobs


@dataclass(frozen=True)
class Attempt:
    """A job that a worker has, and for the how many-th time."""

    entry: Entry
    job: Job
    number: int = 1


@dataclass(frozen=True)
class Ended:
    """What became of a case, after so many attempts, and the hash of all that it depends on."""

    entry: Entry
    outcome: Outcome
    attempts: int = 0
    inputs: str | None = None


def dispatched(entries: Iterable[Entry], settings: Settings, crew: Workers) -> Iterator[Note | Waiting | Ended]:
    """Keep the workers busy, and tell what they do.

    Raises
    ------
    FileError
        If the workers are out of reach.
    """
    left = deque(entries)
    running: dict[Future[Outcome], Attempt] = {}
    begun: Counter[int] = Counter()  # how often a worker has told that it begins with a case
    missing: str | None = None
    while left or running:
        capacity, before, missing = crew.capacity(), missing, crew.missing()
        if missing and not before:
            yield Waiting(missing)
        while left and len(running) < capacity:
            entry = left.popleft()
            try:
                attempt = Attempt(entry, job_of(entry, settings))
            except BubblemeshError as error:
                yield Ended(entry, Outcome(error.exit_code, str(error)))
            else:
                running[_submitted(attempt, crew)] = attempt
        ended, _ = wait(running, TICK, FIRST_COMPLETED)
        for note in _notes(crew):
            begun[note.number] += note.round == 0
            yield note
        for future in ended:
            attempt = running.pop(future)
            problem = _problem(future, crew)
            if isinstance(problem, WorkerDied) and attempt.number < ATTEMPTS:
                again = replace(attempt, number=attempt.number + 1)
                running[_submitted(again, crew)] = again
                continue
            outcome = future.result() if problem is None else _failure(problem, attempt, crew)
            attempts = max(attempt.number, begun[attempt.entry.number])  # a cluster tries again by itself
            yield Ended(attempt.entry, outcome, attempts, attempt.job.digest())


def _submitted(attempt: Attempt, crew: Workers) -> Future[Outcome]:
    try:
        return crew.executor.submit(mesh_job, attempt.job, crew.tell)
    except crew.gone:
        raise FileError(crew.lost) from None


def _notes(crew: Workers) -> Iterator[Note]:
    """What running jobs have told."""
    for _ in range(crew.notes.qsize()):
        try:
            yield crew.notes.get_nowait()
        except Empty:  # pragma: no cover (nobody else reads)
            return


def _problem(future: Future[Outcome], crew: Workers) -> BaseException | None:
    """Why a job could not be run, if it could not."""
    try:
        return future.exception()
    except CancelledError:
        raise FileError(crew.lost) from None


def _failure(problem: BaseException, attempt: Attempt, crew: Workers) -> Outcome:
    outcome = crew.failure(problem)
    times = f" (in each of {attempt.number} attempts)" if attempt.number > 1 else ""
    return replace(outcome, error=f"{attempt.entry.source}: {outcome.error}{times}")
