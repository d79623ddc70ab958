"""Worker processes on this machine."""

import os
import shutil
import signal
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from multiprocessing import get_context, parent_process, resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from queue import SimpleQueue
from threading import Lock, Thread
from typing import Any, TypeVar

from bubblemesh.batch.dispatch import WorkerDied, Workers
from bubblemesh.batch.worker import Note
from bubblemesh.errors import INTERRUPTED, BubblemeshError, FileError, LimitError
from bubblemesh.files import temporary_folder

T = TypeVar("T")

LIBRARIES = ("OMP", "OPENBLAS", "MKL", "NUMEXPR", "BLIS")
THREADS = (*(f"{library}_NUM_THREADS" for library in LIBRARIES), "VECLIB_MAXIMUM_THREADS")
FAREWELL = 5.0  # seconds that a worker whose pipe is closed has to see that the batch has crashed


@contextmanager
def local_workers(count: int) -> Iterator[Workers]:
    """Start processes with one thread of NumPy each; they end with the block, at once if by an exception."""
    with (
        _environment(dict.fromkeys(THREADS, "1")),
        temporary_folder() as staging,
    ):
        workers = LocalWorkers(count, str(staging))
        try:
            workers.start()
            yield workers
        except BaseException:
            workers.kill()
            raise
        finally:
            workers.close()


@contextmanager
def _environment(values: dict[str, str]) -> Iterator[None]:
    """Set variables for processes that start within the block."""
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


class LocalWorkers(Workers):
    """Several processes, each with a pipe: one that dies takes no case with it but its own, and is replaced."""

    lost = "the workers have been stopped"

    def __init__(self, count: int, staging: str) -> None:
        super().__init__()
        self.tell = tell_parent
        self._count = count
        self._staging = staging
        self._threads = ThreadPoolExecutor(count, "worker")  # each waits for the answer of one process
        self._pipes: dict[BaseProcess, Connection[Any, Any]] = {}  # of all processes
        self._idle: SimpleQueue[BaseProcess] = SimpleQueue()
        self._lock = Lock()
        self._stopped = False

    def capacity(self) -> int:
        return 2 * self._count

    def submit(self, function: Callable[..., T], /, *arguments: object) -> Future[T]:
        return self._threads.submit(self._call, function, arguments)

    def failure(self, error: BaseException) -> tuple[int, str]:
        if isinstance(error, WorkerDied):
            code, words = error.args
            return code, words
        return FileError.exit_code, f"no worker process could take it: {type(error).__name__}: {error}"

    def start(self) -> None:
        """Start the processes, which begin to load what they need."""
        for _ in range(self._count):
            self._idle.put(self._start())

    def kill(self) -> None:
        """End the processes now."""
        with self._lock:
            self._stopped = True
        for process in self._pipes:
            process.kill()
        self._threads.shutdown(wait=False, cancel_futures=True)

    def close(self) -> None:
        """End the processes when they have finished."""
        self._threads.shutdown()
        for process, pipe in self._pipes.items():
            with suppress(OSError), pipe:  # of one that has been killed
                pipe.send(None)
            process.join()

    def _call(self, function: Callable[..., T], arguments: tuple[object, ...]) -> T:
        process = self._idle.get()
        pipe = self._pipes[process]
        try:
            pipe.send((function, arguments))
            while (answer := pipe.recv())[0] == "note":
                self.notes.put(answer[1])
        except (EOFError, OSError, MemoryError) as error:
            if isinstance(error, MemoryError):  # the rest of the answer would come with the next one
                process.kill()
            died = self._death(process)
            process = self._start(process)
            raise died from None
        finally:
            self._idle.put(process)
        kind, value = answer
        if kind == "error":
            raise value
        return value

    def _death(self, process: BaseProcess) -> WorkerDied:
        with self._lock:  # who starts a process asks those that have ended for their exit codes
            process.join()
        code = process.exitcode
        if code == -getattr(signal, "SIGKILL", 9):
            return WorkerDied(LimitError.exit_code, "its worker process was killed, perhaps for want of memory")
        how = f"by signal {-code} ({signal.strsignal(-code)})" if code is not None and code < 0 else f"with code {code}"
        return WorkerDied(BubblemeshError.exit_code, f"its worker process ended {how}")

    def _start(self, instead_of: BaseProcess | None = None) -> BaseProcess:
        """Start a process, in place of one that has died."""
        context = get_context("spawn")
        with self._lock:
            if self._stopped:
                raise WorkerDied(INTERRUPTED, "the batch has been stopped")
            try:
                with _uninterrupted():
                    pipe, its_end = context.Pipe()
                    with its_end:
                        process = context.Process(target=serve, args=(its_end, self._staging), daemon=True)
                        process.start()
            except OSError as error:
                raise FileError(f"a worker process cannot be started: {error.strerror}: try fewer --jobs") from None
            if instead_of is not None:
                self._pipes.pop(instead_of).close()
            self._pipes[process] = pipe
        return process


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Let processes that start in the block never see Ctrl-C, which goes to all processes of a terminal."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    resource_tracker.ensure_running()  # who starts it lets all signals through
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


# In the worker process

to_parent: "list[Connection[Any, Any]]" = []


def serve(pipe: "Connection[Any, Any]", staging: str) -> None:
    """Answer calls until None is one; temporary files go to a folder of the batch."""
    to_parent.append(pipe)
    tempfile.tempdir = staging
    watch = Thread(target=_end_with_parent, args=(staging,), daemon=True)
    watch.start()
    try:
        while (call := pipe.recv()) is not None:
            function, arguments = call
            try:
                answer = "value", function(*arguments)
            except Exception as error:
                answer = "error", error
            pipe.send(answer)
    except (EOFError, OSError):
        watch.join(FAREWELL)


def _end_with_parent(staging: str) -> None:
    """End when the batch does, even if by a crash; then nobody else tidies up."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # what breaks now is nobody's concern
        shutil.rmtree(staging, ignore_errors=True)
        os._exit(1)


def tell_parent(note: Note) -> None:
    """Send a note to the process that runs the batch."""
    to_parent[0].send(("note", note))
