"""Jobs go to workers as these have room, and once more where one has died or left: for batches and for parts."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future
from time import sleep
from typing import Generic, NamedTuple, TypeVar

from bubblemesh.workers.workers import ATTEMPTS, LEFT, RECALLS, TICK, WorkerDied, Workers, problem_of, wait_for_any

J = TypeVar("J")
T = TypeVar("T")


class Ended(NamedTuple, Generic[J, T]):
    """A job that has a result, or a problem that no other attempt is to solve."""

    job: J
    future: Future[T]
    problem: BaseException | None
    times: int  # that it was given to a worker which did not leave before it began
    attempts: int  # the same, or those that are known of otherwise if these are more


def supervised(
    workers: Workers,
    jobs: Iterable[J],
    submit: Callable[[J], Future[T]],
    *,
    on_wait: Callable[[str], None],
    on_refuse: Callable[[str], None],
    on_look: Callable[[], None] = lambda: None,
    tried: Callable[[J], int] = lambda job: 0,
) -> Iterator[Ended[J, T]]:
    """Keep workers busy with jobs, which are asked for as they are needed, and give each as it ends.

    A job whose worker dies is submitted once more, `ATTEMPTS` times in all, and more often where its workers leave.
    Warnings are that there are no workers, and that one is left out; there is a look every `TICK` seconds or more
    often. ``tried`` tells how many attempts are known of otherwise: a cluster tries again by itself. FileError if the
    workers are out of reach.
    """
    left, exhausted, again = enumerate(jobs), False, list[tuple[int, J]]()
    running = dict[Future[T], tuple[int, J]]()
    submitted, recalled = Counter[int](), Counter[int]()
    missing: str | None = None
    while running or again or not exhausted:
        capacity, before, missing = workers.capacity(), missing, workers.missing()
        if missing and not before:
            on_wait(missing)
        for message in workers.refused():
            on_refuse(message)
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
    """Exit code and words for a job that has a problem."""
    assert ended.problem is not None
    code, words = workers.failure(ended.problem)
    return code, f"{words} (in each of {ended.times} attempts)" if ended.times > 1 else words
