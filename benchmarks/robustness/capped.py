"""Calls in processes of their own, with a cap on time and memory: one that hangs or dies ends no other."""

import resource
import traceback
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from time import perf_counter
from typing import Any

from bubblemesh.process.resources import seldom_look_for_garbage

CALLS_OF_A_PROCESS = 300  # then a fresh one takes over, so that memory that one call leaves behind burdens few


@dataclass(frozen=True)
class Call:
    """How a call ended: with a value, an exception (its traceback), the death of its process, or at its time limit."""

    task: Any
    seconds: float
    value: Any = None
    crash: str | None = None


def called(
    function: Callable[[Any], Any], tasks: Iterable[Any], jobs: int, seconds: float, megabytes: int
) -> Iterator[Call]:
    """Call a function of a module with each task, and give the calls as they end."""
    left = deque(tasks)
    workers = [_Worker(function, megabytes) for _ in range(jobs)]
    try:
        while left or any(worker.busy for worker in workers):
            for worker in workers:
                if left and not worker.busy:
                    worker.begin(left.popleft())
            busy = [worker for worker in workers if worker.busy]
            wait([worker.pipe for worker in busy], timeout=0.2)
            for worker in busy:
                ended = worker.ended(seconds)
                if ended is not None:
                    yield ended
    finally:
        for worker in workers:
            worker.stop()


class _Worker:
    """A process that is replaced when it dies."""

    def __init__(self, function: Callable[[Any], Any], megabytes: int) -> None:
        self._function, self._megabytes = function, megabytes
        self.busy = False
        self._start()

    def _start(self) -> None:
        context = get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self._process: BaseProcess = context.Process(
            target=_serve, args=(theirs, self._function, self._megabytes), daemon=True
        )
        self._process.start()
        theirs.close()
        self._calls = 0
        self._warm = False

    def begin(self, task: Any) -> None:
        if self._calls >= CALLS_OF_A_PROCESS:
            self.stop()
            self._start()
        if not self._warm:
            self.pipe.recv()  # that it has loaded what it needs
            self._warm = True
        self._task, self._begun, self.busy = task, perf_counter(), True
        self._calls += 1
        self.pipe.send(task)

    def ended(self, seconds: float) -> Call | None:
        """The call, if it has ended or taken too long."""
        taken = perf_counter() - self._begun
        if self.pipe.poll():
            try:
                value, crash = self.pipe.recv()
            except EOFError:
                self._process.join()
                value, crash = None, f"the process died (exit code {self._process.exitcode})"
        elif taken > seconds:
            value, crash = None, f"no end after {seconds:g} s"
        else:
            return None
        self.busy = False
        if crash and value is None and not crash.startswith("Traceback"):
            self.stop()
            self._start()
        return Call(self._task, taken, value, crash)

    def stop(self) -> None:
        self._process.kill()
        self._process.join()
        self.pipe.close()


def _serve(pipe: "Connection[Any, Any]", function: Callable[[Any], Any], megabytes: int) -> None:
    resource.setrlimit(resource.RLIMIT_AS, (megabytes * 1_000_000,) * 2)
    seldom_look_for_garbage()  # as the command and the workers of a batch do
    pipe.send("ready")
    while True:
        task = pipe.recv()
        try:
            answer = function(task), None
        except Exception:
            answer = None, traceback.format_exc()
        pipe.send(answer)
