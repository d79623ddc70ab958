"""Worker processes on this machine."""

import os
import shutil
import signal
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from multiprocessing import active_children, get_context, parent_process
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from queue import SimpleQueue
from tempfile import TemporaryDirectory
from threading import Lock, Thread
from typing import Any, ParamSpec, TypeVar

from bubblemesh.batch.jobs import Note, Outcome
from bubblemesh.batch.workers import WorkerDied, Workers
from bubblemesh.errors import FileError, LimitError

P = ParamSpec("P")
T = TypeVar("T")

LIBRARIES = ("OMP", "OPENBLAS", "MKL", "NUMEXPR", "BLIS")
THREADS = (*(f"{library}_NUM_THREADS" for library in LIBRARIES), "VECLIB_MAXIMUM_THREADS")


@contextmanager
def local_workers(count: int) -> Iterator[Workers]:
    """So many processes with one thread of NumPy each; they end with the block, at once if by an exception."""
    notes: SimpleQueue[Note] = SimpleQueue()
    with (
        _environment(dict.fromkeys(THREADS, "1")),
        TemporaryDirectory(prefix="bubblemesh-", ignore_cleanup_errors=True) as staging,
    ):
        executor = LocalExecutor(count, notes, staging)
        try:
            yield Workers(executor, tell_parent, notes, lambda: 2 * count, _failure, "the workers have been stopped")
        except BaseException:
            executor.kill()
            raise
        finally:
            executor.shutdown()


def _failure(error: BaseException) -> Outcome:
    if isinstance(error, WorkerDied):
        return Outcome(error.exit_code, error.message)
    return Outcome(FileError.exit_code, f"no worker process could take it: {type(error).__name__}: {error}")


@contextmanager
def _environment(values: dict[str, str]) -> Iterator[None]:
    """These variables, for processes that start within the block."""
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


@dataclass(frozen=True)
class Lane:
    """A pool of one process."""

    pool: ProcessPoolExecutor
    process: BaseProcess

    def died(self) -> WorkerDied:
        """Why the process has ended."""
        self.pool.shutdown()  # has waited for the process, which knows its exit code then
        code = self.process.exitcode
        if code == -getattr(signal, "SIGKILL", 9):
            return WorkerDied("its worker process was killed, perhaps for want of memory", LimitError.exit_code)
        how = f"by signal {-code} ({signal.strsignal(-code)})" if code is not None and code < 0 else f"with code {code}"
        return WorkerDied(f"its worker process ended {how}", 1)


class LocalExecutor(Executor):
    """Several lanes of one process each: a process that dies takes no case with it but its own, and is replaced."""

    def __init__(self, count: int, notes: "SimpleQueue[Note]", staging: str) -> None:
        self._notes = notes
        self._staging = staging
        self._threads = ThreadPoolExecutor(count, "lane")
        self._idle: SimpleQueue[Lane] = SimpleQueue()
        self._lanes: list[Lane] = []
        self._lock = Lock()
        self._stopped = False
        try:
            for _ in range(count):
                self._idle.put(self._started())
        except BaseException:
            self.kill()
            raise

    def submit(self, function: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Call the function in one of the processes; its death is a `WorkerDied`."""
        return self._threads.submit(lambda: self._called(partial(function, *args, **kwargs)))

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes when they have finished."""
        self._threads.shutdown(wait, cancel_futures=cancel_futures)
        for lane in self._lanes:
            lane.pool.shutdown(wait)

    def kill(self) -> None:
        """End the processes now."""
        self._stopped = True
        for lane in self._lanes:
            lane.process.kill()
        self._threads.shutdown(wait=False, cancel_futures=True)

    def _called(self, call: Callable[[], T]) -> T:
        lane = self._idle.get()
        try:
            return lane.pool.submit(call).result()
        except BrokenProcessPool:
            died = lane.died()
            lane = self._started(lane)
            raise died from None
        finally:
            self._idle.put(lane)

    def _started(self, old: Lane | None = None) -> Lane:
        """A lane whose process has begun to load what it needs."""
        reader, writer = get_context("spawn").Pipe(duplex=False)
        pool = ProcessPoolExecutor(1, get_context("spawn"), begin_worker, (writer, self._staging))
        with self._lock, _uninterrupted():
            if self._stopped:
                raise WorkerDied("the batch has been stopped", 130)
            others = set(active_children())
            try:
                pool.submit(load_packing)
            except OSError as error:
                raise FileError(f"a worker process cannot be started: {error.strerror}: try fewer --jobs") from None
            (process,) = set(active_children()) - others
            lane = Lane(pool, process)
            self._lanes = [*(one for one in self._lanes if one is not old), lane]
        writer.close()
        Thread(target=_forward, args=(reader, self._notes), daemon=True).start()
        return lane


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """A process that starts in the block never sees Ctrl-C, which goes to all processes of a terminal."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _forward(reader: "Connection[Any, Note]", notes: "SimpleQueue[Note]") -> None:
    """Bring the notes of a process into the queue of all, until it ends."""
    try:
        while True:
            notes.put(reader.recv())
    except (EOFError, OSError):
        reader.close()


# In the worker process

to_parent: "list[Connection[Note, Any]]" = []


def begin_worker(notes: "Connection[Note, Any]", staging: str) -> None:
    """Make a worker process ready, whose temporary files go to a folder of the batch."""
    to_parent.append(notes)
    tempfile.tempdir = staging
    Thread(target=_end_with_parent, args=(staging,), daemon=True).start()


def _end_with_parent(staging: str) -> None:
    """End when the batch does, even if by a crash; then nobody else tidies up."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        shutil.rmtree(staging, ignore_errors=True)
        os._exit(1)


def load_packing() -> None:
    """Load what meshing needs, while the first case is still on its way."""
    import bubblemesh.batch.worker  # noqa: F401


def tell_parent(note: Note) -> None:
    """Send a note to the process that runs the batch."""
    to_parent[0].send(note)
