"""Jobs are given to workers as these have room, and again if a worker has died or left; for batches and parts."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future
from time import sleep
from typing import Generic, NamedTuple, TypeVar

from bubblemesh.workers.workers import ATTEMPTS, LEFT, RECALLS, TICK, WorkerDied, Workers, problem_of, wait_for_any

J = TypeVar("J")
T = TypeVar("T")


class Ended(NamedTuple, Generic[J, T]):
    """A job that has a result, or a problem that no further attempt would solve."""

    job: J
    future: Future[T]
    problem: BaseException | None
    times: int  # how often it was given to a worker, without workers that left before they began it
    attempts: int  # the same, or the number that ``tried`` returns if that is larger


def supervised(
    workers: Workers,
    jobs: Iterable[J],
    submit: Callable[[J], Future[T]],
    *,
    warn: Callable[[str], None],
    on_look: Callable[[], None] = lambda: None,
    tried: Callable[[J], int] = lambda job: 0,
) -> Iterator[Ended[J, T]]:
    """Keep workers busy with jobs, and yield each job as it ends.

    A job whose worker dies is submitted again, `ATTEMPTS` times in all; if its workers leave, `RECALLS` times.

    Parameters
    ----------
    workers
        Those that do the jobs.
    jobs
        The jobs; the next one is taken when a worker has room for it.
    submit
        Submits a job and returns its future.
    warn
        Called with a warning that there are no workers, or that one is left out.
    on_look
        Called every `TICK` seconds, or more often.
    tried
        Returns how many attempts of a job are known from elsewhere, as a cluster tries again by itself.

    Raises
    ------
    FileError
        If the workers are out of reach.
    """
    left, exhausted, again = enumerate(jobs), False, list[tuple[int, J]]()
    running = dict[Future[T], tuple[int, J]]()
    submitted, recalled = Counter[int](), Counter[int]()
    missing: str | None = None
    while running or again or not exhausted:
        capacity, before, missing = workers.capacity(), missing, workers.missing()
        if missing and not before:
            warn(missing)
        for message in workers.refused():
            warn(message)
        while len(running) < capacity:
            given = again.pop() if again else next(left, None)
            if given is None:
                exhausted = True
                break
            number, job = given
            submitted[number] += 1
            running[submit(job)] = given
        if not running and (again or not exhausted):
            sleep(TICK)
        ended = wait_for_any(running)
        on_look()
        for future in ended:
            number, job = running.pop(future)
            problem = problem_of(future, workers)
            recalled[number] += problem is LEFT
            times = submitted[number] - recalled[number]
            attempts = max(times, tried(job))
            if isinstance(problem, WorkerDied) and attempts < ATTEMPTS and recalled[number] < RECALLS:
                again.append((number, job))
            else:
                yield Ended(job, future, problem, times, attempts)


def failure(ended: Ended[J, T], workers: Workers) -> tuple[int, str]:
    """Exit code and text of the error for a job that has a problem."""
    assert ended.problem is not None
    code, words = workers.failure(ended.problem)
    return code, f"{words} (in each of {ended.times} attempts)" if ended.times > 1 else words
