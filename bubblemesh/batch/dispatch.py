"""Cases are given to workers, here or on a cluster, and their outcomes come back."""

from collections import Counter
from collections.abc import Iterable, Iterator
from concurrent.futures import Future
from dataclasses import replace
from pathlib import Path
from typing import Any

from bubblemesh.batch.plan import Entry
from bubblemesh.batch.row import Row
from bubblemesh.batch.worker import BatchJob, Outcome, mesh_job
from bubblemesh.workers.supervision import Ended, failure, supervised
from bubblemesh.workers.workers import Workers


class BatchListener:
    """Listener to the progress of a batch; the methods of this class do nothing."""

    def begin(self, entries: list[Entry], summary: Path) -> None:
        """The batch begins: all of its cases, the file of the summary."""

    def note(self, number: int, finished_rounds: int, nodes: int) -> None:
        """A running case has finished a round; it has 0 nodes before the first one."""

    def warn(self, message: str) -> None:
        """There are no workers, one is left out, or something is missing in the summary; the message says what."""

    def finish(self, number: int, row: Row, *, unchanged: bool = False) -> None:
        """A case has its row; ``unchanged`` if an earlier batch had done it."""


def dispatch(entries: Iterable[Entry], workers: Workers, listener: BatchListener) -> Iterator[tuple[Entry, Outcome]]:
    """Keep the workers busy, and yield the outcome of each case as it ends; FileError if they are out of reach."""
    begun = Counter[int]()  # how often a worker has begun each case

    def look() -> None:
        for _ in range(workers.notes.qsize()):
            number, finished_rounds, nodes = workers.notes.get()
            begun[number] += finished_rounds == 0
            listener.note(number, finished_rounds, nodes)

    all_ended = supervised(
        workers,
        ((entry, entry.job()) for entry in entries),
        lambda given: _submitted(workers, given[1]),
        warn=listener.warn,
        on_look=look,
        tried=lambda given: begun[given[1].number] if isinstance(given[1], BatchJob) else 0,
    )
    for ended in all_ended:
        entry, job = ended.job
        if isinstance(job, Row):
            yield entry, Outcome(job)
            continue
        outcome = ended.future.result() if ended.problem is None else Outcome(_failed(job.row, ended, workers))
        yield entry, replace(outcome, row=replace(outcome.row, attempts=ended.attempts))


def _submitted(workers: Workers, job: BatchJob | Row) -> Future[Outcome]:
    """Future of the outcome of a case: in a worker, or at once if the case has its row already."""
    if isinstance(job, BatchJob):
        return workers.submit(mesh_job, job, workers.tell)
    done = Future[Outcome]()
    done.set_result(Outcome(job))
    return done


def _failed(row: Row, ended: Ended[Any, Outcome], workers: Workers) -> Row:
    code, words = failure(ended, workers)
    return row.failed(code, f"{row.source}: {words}")
