"""Workers that pack the parts of one mesh."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future
from contextlib import ExitStack, contextmanager
from time import sleep
from typing import TYPE_CHECKING, Generic, NamedTuple, TypeVar, cast

from bubblemesh.errors import BubblemeshError, FileError, LimitError, prefixed
from bubblemesh.workers.hire import Hire
from bubblemesh.workers.workers import ATTEMPTS, RECALLS, TICK, WorkerDied, Workers, problem_of, wait_for_any

if TYPE_CHECKING:  # or workers could not start before all that packs is loaded here, too
    from bubblemesh.parts.work import Crew, Job

T = TypeVar("T")
Given = tuple[int, "Job"]  # with its number
MANY = 1 << 30  # workers: whoever hires them knows how many there can be


@contextmanager
def crew_of(hire: Hire, warn: Callable[[str], None], ahead: str | None = None, most: int = MANY) -> Iterator["Crew"]:
    """Crew of workers, ``most`` of them or fewer, that end with the block.

    They are hired at once if a module is named that has what they will call, and load it meanwhile; else for the first
    job.
    """
    with ExitStack() as stack:
        hired: list[Workers] = []
        if ahead is not None:
            hired.append(stack.enter_context(hire(most)))
            hired[0].load(ahead)

        def call(function: Callable[..., T], jobs: Iterable["Job"]) -> Iterator[tuple[int, T]]:
            if not hired:
                hired.append(stack.enter_context(hire(most)))
            return called(hired[0], function, jobs, warn)

        yield call


def called(
    workers: Workers, function: Callable[..., T], jobs: Iterable["Job"], warn: Callable[[str], None]
) -> Iterator[tuple[int, T]]:
    """Results of a function for all jobs, as they come; a job whose worker dies is given to another one.

    What the function raises is raised here; LimitError or another for a job that takes a worker with it each time,
    FileError if the workers are out of reach.
    """
    left, again = enumerate(jobs), list[Given]()
    following: Given | None = next(left, None)
    running = dict[Future[Answer[T]], Given]()
    # How often each job was given to a worker that died, and to one that left.
    attempts, recalls = Counter[int](), Counter[int]()
    missing: str | None = None
    while following or again or running:
        capacity, before, missing = workers.capacity(), missing, workers.missing()
        for message in [*([missing] if missing and not before else []), *workers.refused()]:
            warn(message)
        while len(running) < capacity and (again or following):
            if again:
                given = again.pop()
            elif following:
                given, following = following, next(left, None)
            running[workers.submit(answer, function, *given[1].arguments)] = given
        if not running:
            sleep(TICK)
        ended = wait_for_any(running)
        for future in ended:
            number, job = running.pop(future)
            problem = problem_of(future, workers)
            if problem is None:
                with prefixed(job.what):
                    result = future.result().get()
                yield number, result
                continue
            left_it = future in workers.recalled
            recalls[number] += left_it
            attempts[number] += not left_it
            if not isinstance(problem, WorkerDied) or attempts[number] >= ATTEMPTS or recalls[number] >= RECALLS:
                with prefixed(job.what):
                    raise _as_ours(problem, workers, attempts[number])
            again.append((number, job))


class Answer(NamedTuple, Generic[T]):
    """Value that a function has returned, or error that it has raised."""

    value: T | None
    error: Exception | None

    def get(self) -> T:
        """The value; or the error is raised."""
        if self.error is not None:
            raise self.error
        return cast(T, self.value)


def answer(function: Callable[..., T], *arguments: object) -> Answer[T]:
    """Answer of a function, in whatever process: else its errors could not be told from those of the workers."""
    try:
        return Answer(function(*arguments), None)
    except Exception as error:
        return Answer(None, error)


def _as_ours(problem: BaseException, workers: Workers, attempts: int) -> BaseException:
    """Error of the package for a problem of the workers."""
    if isinstance(problem, BubblemeshError):
        return problem
    code, words = workers.failure(problem)
    kind = {error.exit_code: error for error in (FileError, LimitError)}.get(code, BubblemeshError)
    return kind(f"{words}{f' (in each of {attempts} attempts)' if attempts > 1 else ''}")
