"""Protocol of workers, here or on a cluster: they call functions, report progress, and may die or leave."""

import pickle
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from queue import SimpleQueue
from typing import Any, TypeVar

from bubblemesh.errors import BubblemeshError, FileError, LimitError

T = TypeVar("T")
Note = tuple[int, int, int]  # number of a running case, its finished rounds, and its nodes (at first 0 and 0)
Tell = Callable[[Note], None]

ATTEMPTS = 3  # of a job whose worker process dies
RECALLS = 20  # of a job whose workers leave before they have begun it
TICK = 0.2  # seconds between looks at the notes of running jobs


class WorkerDied(BrokenExecutor):
    """A worker process has ended unasked; the arguments are an exit code and a text, as `failure` returns them."""


def travelling(error: Exception) -> Exception:
    """The error itself if it survives pickling, else one of the package with its type and text."""
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return BubblemeshError(f"{type(error).__name__}: {error}")
    return error


LEFT = WorkerDied(LimitError.exit_code, "the workers that were to mesh it have left, perhaps for want of memory")


class Workers(ABC):
    """Worker processes.

    If they are out of reach, futures are cancelled, or `submit` or `capacity` raise a FileError. Futures that are
    ``recalled`` were cancelled because their workers have left; that does not count as an attempt.
    """

    tell: Tell  # called in a worker, it sends a note to the queue here
    lost: str  # text of the FileError

    def __init__(self) -> None:
        self.notes: SimpleQueue[Note] = SimpleQueue()
        self.recalled: set[Future[Any]] = set()

    @abstractmethod
    def submit(self, function: Callable[..., T], /, *arguments: object) -> Future[T]:
        """Call a function in a worker; if the future raises `WorkerDied`, the caller tries again."""

    @abstractmethod
    def capacity(self) -> int:
        """Number of jobs that should be submitted at any time, so that no worker has to wait."""

    @abstractmethod
    def failure(self, error: BaseException) -> tuple[int, str]:
        """Exit code and text of the error for a job that could not be run, from the exception of its future."""

    def missing(self) -> str | None:
        """Warning while there are no workers; else None."""
        return None

    def refused(self) -> list[str]:
        """Warnings on the workers that have been left out since the last call."""
        return []


def wait_for_any(running: Collection[Future[T]]) -> list[Future[T]]:
    """Futures that have ended, after a wait of at most `TICK` seconds for one of them.

    Futures cancelled in this process count as ended at once, though `wait` would still wait for them.
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
