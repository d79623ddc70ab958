"""Protocol of workers, whoever they are: they call functions, tell how far they are, and may die or leave."""

import pickle
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from queue import SimpleQueue
from typing import Any, TypeVar

from bubblemesh.errors import BubblemeshError, FileError, LimitError

T = TypeVar("T")
Note = tuple[int, int, int]  # number of a case that is at work, its finished rounds, and the nodes then (first 0 and 0)
Tell = Callable[[Note], None]

ATTEMPTS = 3  # of a job whose worker process dies
RECALLS = 20  # of a job whose workers leave before they have begun it
TICK = 0.2  # seconds between looks at the notes of running jobs


class WorkerDied(BrokenExecutor):
    """A worker process has ended without being asked to; the arguments are an exit code and words, as of `failure`."""


def travelling(error: Exception) -> Exception:
    """An error as it is if it can be pickled and comes back, else one of the package that tells its type and text."""
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return BubblemeshError(f"{type(error).__name__}: {error}")
    return error


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

    def load(self, module: str) -> None:  # noqa: B027 - workers that are there already need not
        """Let workers that are starting load a module, before they are asked to call what is in it."""

    def missing(self) -> str | None:
        """Warning while there are no workers; else None."""
        return None

    def refused(self) -> list[str]:
        """Warnings of the workers that have been left out since the last call."""
        return []


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
