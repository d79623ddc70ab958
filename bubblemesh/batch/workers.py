"""What a batch needs to know of those who do its work."""

from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Executor
from dataclasses import dataclass
from queue import SimpleQueue

from bubblemesh.batch.jobs import Note, Outcome, Tell


class WorkerDied(BrokenExecutor):
    """A worker process has ended without being asked to."""

    def __init__(self, message: str, exit_code: int) -> None:
        super().__init__(message, exit_code)
        self.message = message
        self.exit_code = exit_code


@dataclass(frozen=True)
class Workers:
    """Worker processes behind a standard executor.

    Attributes
    ----------
    executor : Executor
        A `WorkerDied` of one of its futures costs another attempt.
    tell : callable
        Run in a worker, it brings a note to the queue here.
    notes : SimpleQueue of Note
    capacity : callable
        How many jobs to have submitted, so that no worker has to wait; a FileError if the workers are out of reach.
    failure : callable
        Outcome of a job that could not be run, from the exception of its future.
    lost : str
        What to say if the workers are out of reach; then futures are cancelled, or submitting raises ``gone``.
    gone : tuple of exceptions
    missing : callable
        What to say while there are no workers; else None.
    """

    executor: Executor
    tell: Tell
    notes: SimpleQueue[Note]
    capacity: Callable[[], int]
    failure: Callable[[BaseException], Outcome]
    lost: str
    gone: tuple[type[Exception], ...] = ()
    missing: Callable[[], str | None] = lambda: None
