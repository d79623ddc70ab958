"""Workers that pack the parts of one mesh."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from time import perf_counter
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar, cast

from bubblemesh.errors import BubblemeshError, FileError, LimitError, prefixed
from bubblemesh.messages import ToldPlaces, places_as, places_now
from bubblemesh.process.limits import within
from bubblemesh.workers.hire import Hire
from bubblemesh.workers.supervision import Ended, failure, supervised
from bubblemesh.workers.workers import Workers, travelling

if TYPE_CHECKING:  # else the modules that pack would be loaded here before workers start
    from bubblemesh.parts.work import Crew, Job

T = TypeVar("T")
MANY = 1 << 30  # workers, for no limit: `Hire` knows how many there can be


@contextmanager
def crew_of(
    hire: Hire,
    warn: Callable[[str], None],
    ahead: str | None = None,
    most: int = MANY,
    memory_mb: float | None = None,
) -> Iterator["Crew"]:
    """Crew of workers that end with the block.

    Parameters
    ----------
    hire
        Starts workers.
    warn
        Called with warnings on workers.
    ahead
        Name of a module with the functions to call: workers are then started, and load it, at once; by default they
        are started for the first job.
    most
        The largest number of workers.
    memory_mb
        Limit on the memory of each worker; None for no limit.
    """
    with ExitStack() as stack:
        hired: list[Workers] = []
        if ahead is not None:
            hired.append(stack.enter_context(hire(most, ahead)))

        def call(function: Callable[..., T], jobs: Iterable["Job"]) -> Iterator[tuple[int, T]]:
            if not hired:
                hired.append(stack.enter_context(hire(most)))
            return called(hired[0], function, jobs, warn, memory_mb)

        yield call


def called(
    workers: Workers,
    function: Callable[..., T],
    jobs: Iterable["Job"],
    warn: Callable[[str], None],
    memory_mb: float | None = None,
) -> Iterator[tuple[int, T]]:
    """Results of a function for all jobs, as they come, with the numbers of the jobs.

    A job whose worker dies is given to another one. No worker may hold more memory than the limit, if there is one.

    Raises
    ------
    FileError
        If the workers are out of reach.
    BubblemeshError
        For a job whose worker dies each time: LimitError if that was for want of memory, or the limit was exceeded.
    Exception
        What the function raises.
    """
    all_ended = supervised(
        workers,
        enumerate(jobs),
        lambda given: workers.submit(answer, places_now(), memory_mb, function, *given[1].arguments),
        warn=warn,
    )
    for ended in all_ended:
        number, job = ended.job
        with prefixed(job.what):
            if ended.problem is not None:
                raise _as_ours(ended, workers)
            result = ended.future.result().get()
        yield number, result


class Answer(NamedTuple, Generic[T]):
    """Value that a function has returned, or error that it has raised."""

    value: T | None
    error: Exception | None

    def get(self) -> T:
        """The value; raises the error if there is one."""
        if self.error is not None:
            raise self.error
        return cast(T, self.value)


def answer(told: ToldPlaces, memory_mb: float | None, function: Callable[..., T], *arguments: object) -> Answer[T]:
    """Answer of a function within a limit on memory: its errors are values, so that they differ from errors of workers.

    They tell places as the process that asks does.
    """
    try:
        with places_as(told):
            return Answer(within(lambda: function(*arguments), None, memory_mb, perf_counter()), None)
    except Exception as error:
        return Answer(None, travelling(error))


def _as_ours(ended: Ended[Any, Any], workers: Workers) -> BaseException:
    """Error to raise for a job that has a problem: of the package if it is one of the workers."""
    if isinstance(ended.problem, BubblemeshError):
        return ended.problem
    code, words = failure(ended, workers)
    kind = {error.exit_code: error for error in (FileError, LimitError)}.get(code, BubblemeshError)
    return kind(words)
