"""The course of a batch: cases go to the workers, files and rows come back."""

from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from queue import Empty

from bubblemesh import __version__
from bubblemesh.batch.jobs import Job, Note, Outcome
from bubblemesh.batch.locking import reserved
from bubblemesh.batch.plan import Entry, Settings, job_of
from bubblemesh.batch.resuming import key_of, place_in, unchanged, without_leftovers
from bubblemesh.batch.rows import Row, figures_of
from bubblemesh.batch.shards import WHOLE, Shard
from bubblemesh.batch.summary import recorded, summary
from bubblemesh.batch.worker import mesh_job
from bubblemesh.batch.workers import WorkerDied, Workers
from bubblemesh.errors import BubblemeshError, FileError
from bubblemesh.output.atomic import transaction

__all__ = ["Begun", "Event", "Finished", "course"]

ATTEMPTS = 3  # of a case whose worker process dies
TICK = 0.2  # seconds between looks at the notes of running jobs
STAGING = ".bubblemesh-batch"


@dataclass(frozen=True)
class Begun:
    """The batch begins: all its cases, how many of them are done already, and the file of the summary."""

    entries: tuple[Entry, ...]
    unchanged: int
    summary: Path


@dataclass(frozen=True)
class Finished:
    """A case has its row; ``unchanged`` if an earlier batch had done it."""

    number: int
    row: Row
    unchanged: bool = False


Event = Begun | Note | Finished


@dataclass(frozen=True)
class Attempt:
    """A job that a worker has, and for the how many-th time."""

    entry: Entry
    job: Job
    number: int = 1


def course(
    entries: Iterable[Entry],
    settings: Settings,
    workers: Callable[[int], AbstractContextManager[Workers]],
    *,
    shard: Shard = WHOLE,
    resume: bool = False,
) -> Generator[Event, None, None]:
    """Mesh all cases, and tell of each as it ends.

    Parameters
    ----------
    entries : iterable of Entry
    settings : Settings
    workers : callable
        Gives the workers for a number of cases; not called if nothing is left to do.
    shard : Shard
        Part of the entries to mesh.
    resume : bool
        Whether cases that an earlier batch has done stay as they are, and its summary goes on.

    Raises
    ------
    FileError
        If the summary cannot be written, or the workers are out of reach; all rows until then are there.
    """
    own = tuple(shard.of(list(entries)))
    root = Path(settings.folder or ".")
    with reserved(root, shared=shard != WHOLE):
        done = unchanged(own, recorded(root), settings, root) if resume else {}
        kept = [*_of_others(own, root, shard), *done.values()] if resume else []
        left = [entry for entry in own if entry.number not in done]
        # Only who has workers begins a summary: an old one is not given up for nothing.
        crews = workers(len(left)) if left else nullcontext()
        with _tidied(own, shard) as staging, crews as crew, summary(root, shard.suffix, kept) as rows:
            yield Begun(own, len(done), rows.path)
            yield from (Finished(number, row, unchanged=True) for number, row in done.items())
            for event in _events(left, settings, crew, root, staging) if crew else ():
                if isinstance(event, Finished):
                    rows.append(event.row)
                yield event


@contextmanager
def _tidied(own: Sequence[Entry], shard: Shard) -> Iterator[str]:
    """How names of staging folders begin; those that a killed batch or an interrupt left are removed."""
    prefix = f"{STAGING}{shard.suffix}-"
    without_leftovers(own, prefix)
    try:
        yield prefix
    finally:
        without_leftovers(own, prefix)


def _of_others(own: Iterable[Entry], root: Path, shard: Shard) -> list[Row]:
    """Rows of the present summary that are of cases outside this batch, and have results."""
    keys = {key_of(entry, root) for entry in own}
    unreadable = {entry.source for entry in own if entry.place is None}
    rows = [row for row in recorded(root, shard.suffix) if row.key not in keys and row.source not in unreadable]
    return [row for row in rows if row.folder is not None]


def _events(
    entries: Iterable[Entry], settings: Settings, crew: Workers, root: Path, staging: str
) -> Iterator[Note | Finished]:
    """Keep the workers busy, and tell what they do."""
    left = deque(entries)
    running: dict[Future[Outcome], Attempt] = {}
    while left or running:
        while left and len(running) < crew.capacity():
            entry = left.popleft()
            try:
                attempt = Attempt(entry, job_of(entry, settings))
            except BubblemeshError as error:
                yield Finished(entry.number, _row(entry, Outcome(error.exit_code, str(error)), root))
            else:
                running[_submitted(attempt, crew)] = attempt
        ended, _ = wait(running, TICK, FIRST_COMPLETED)
        yield from _notes(crew)
        for future in ended:
            attempt = running.pop(future)
            problem = _problem(future, crew)
            if isinstance(problem, WorkerDied) and attempt.number < ATTEMPTS:
                again = replace(attempt, number=attempt.number + 1)
                running[_submitted(again, crew)] = again
                continue
            outcome = future.result() if problem is None else _failure(problem, attempt, crew)
            yield Finished(attempt.job.number, _delivered(attempt, outcome, root, staging))


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


def _delivered(attempt: Attempt, outcome: Outcome, root: Path, staging: str) -> Row:
    """Write the files of a case, all or none, and give its row."""
    place = attempt.entry.place
    if outcome.files and place is not None and place.folder is not None:
        try:
            with transaction(place.folder, staging) as folder:
                for name, content in outcome.files.items():
                    (folder / name).write_bytes(content)
        except FileError as error:
            outcome = Outcome(error.exit_code, f"{attempt.entry.source}: {error}", warnings=outcome.warnings)
    row = _row(attempt.entry, outcome, root)
    return replace(row, attempts=attempt.number, inputs=attempt.job.digest())


def _row(entry: Entry, outcome: Outcome, root: Path) -> Row:
    return Row(
        case=entry.name,
        source=entry.source,
        sweep=dict(entry.variant.values),
        exit_code=outcome.exit_code,
        error=outcome.error,
        figures=figures_of(outcome.report),
        warnings=outcome.warnings,
        folder=place_in(root, entry),
        version=__version__,
        files=dict(outcome.digests),
        traceback=outcome.traceback,
    )
