"""Worker processes on this machine."""

import os
import pickle
import signal
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from importlib import import_module
from queue import SimpleQueue
from subprocess import PIPE, Popen
from threading import Lock
from typing import IO, TypeVar

from bubblemesh.errors import INTERRUPTED, BubblemeshError, FileError, LimitError
from bubblemesh.files import temporary_folder
from bubblemesh.process.resources import available_cores, has_other_threads
from bubblemesh.workers.frames import received, send
from bubblemesh.workers.serving import THREADS, load, serve_as_copy, tell_parent
from bubblemesh.workers.workers import WorkerDied, Workers

T = TypeVar("T")

# The first argument is the folder for temporary files, the others are where modules are found.
PROGRAM = "import sys; sys.path[:] = sys.argv[2:]; from bubblemesh.workers.serving import serve; serve(sys.argv[1])"


@contextmanager
def local_workers(count: int, ahead: str | None = None) -> Iterator[Workers]:
    """Processes with one thread of NumPy each; they end with the block, at once if that ends by an exception.

    They load the module ``ahead`` before the first call, or are copies of this process, which loads it once for all.
    """
    with temporary_folder() as staging:
        workers = LocalWorkers(count, str(staging))
        try:
            workers.start(ahead)
            yield workers
        except BaseException:
            workers.kill()
            raise
        finally:
            workers.close()


class WorkerProcess(Popen[bytes]):
    """Process that reads calls from its standard input and writes answers to its standard output.

    All that it needs to start is in its arguments, so that Python has no error to print if the batch is killed before
    the process reads anything.
    """

    stdin: IO[bytes]
    stdout: IO[bytes]

    def __init__(self, staging: str) -> None:
        command = [sys.executable, "-c", PROGRAM, staging, *sys.path]
        environment = os.environ | dict.fromkeys(THREADS, "1")
        with _uninterrupted():
            super().__init__(command, stdin=PIPE, stdout=PIPE, env=environment)

    def end(self) -> None:
        """Close the streams, and wait for the end that this brings."""
        with suppress(OSError), self:  # a process that was killed has left something unread
            pass


class WorkerCopy:
    """Copy of this process that does what a `WorkerProcess` does; it has loaded what this one has, at no cost.

    Only a process without other threads can be copied: what these hold would be held in the copy for ever.
    """

    def __init__(self, staging: str) -> None:
        (calls, to_copy), (from_copy, answers) = os.pipe(), os.pipe()
        self.stdin, self.stdout = os.fdopen(to_copy, "wb"), os.fdopen(from_copy, "rb")
        self._lock = Lock()
        self._code: int | None = None
        try:
            with _uninterrupted():
                self.pid = os.fork()
                if self.pid == 0:
                    serve_as_copy(calls, answers, staging)
        except OSError:  # too many processes
            self.stdin.close()
            self.stdout.close()
            raise
        finally:
            os.close(calls)
            os.close(answers)

    def kill(self) -> None:
        """End the process now."""
        with self._lock:
            if self._code is None:
                os.kill(self.pid, signal.SIGKILL)

    def wait(self) -> int:
        """Exit code of the process, once it has ended; a negative one is the signal that ended it."""
        with self._lock:
            if self._code is None:
                self._code = os.waitstatus_to_exitcode(os.waitpid(self.pid, 0)[1])
        return self._code

    def end(self) -> None:
        """Close the streams, and wait for the end that this brings."""
        for stream in (self.stdin, self.stdout):
            with suppress(OSError):  # a process that was killed has left something unread
                stream.close()
        self.wait()


class LocalWorkers(Workers):
    """Several processes; one that dies is replaced, and only its own job is affected."""

    lost = "the workers have been stopped"

    def __init__(self, count: int, staging: str) -> None:
        super().__init__()
        self.tell = tell_parent
        self._count = count
        self._staging = staging
        self._threads = ThreadPoolExecutor(count, "worker")  # each waits for the answer of one process
        self.processes: set[WorkerProcess | WorkerCopy] = set()
        self._idle: SimpleQueue[WorkerProcess | WorkerCopy] = SimpleQueue()
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

    def start(self, ahead: str | None = None) -> None:
        """Start the processes, which have loaded the module ``ahead``, or begin to."""
        if ahead is not None and not has_other_threads():
            import_module(ahead)
        copied = ahead is not None and not has_other_threads()  # libraries may have started some
        for _ in range(self._count):
            self._idle.put(self._start(WorkerCopy if copied else WorkerProcess))
        if ahead is not None and not copied:
            at_once = max(available_cores() - 1, 1)  # one core is left to this process
            for first in range(min(at_once, self._count)):
                self._threads.submit(self._load, ahead, len(range(first, self._count, at_once)))

    def kill(self) -> None:
        """End the processes now."""
        with self._lock:
            self._stopped = True
        for process in self.processes:
            process.kill()
        self._threads.shutdown(wait=False, cancel_futures=True)

    def close(self) -> None:
        """End the processes when they have finished."""
        self._threads.shutdown()
        for process in self.processes:
            process.end()

    def _load(self, module: str, times: int) -> None:
        """Let processes load a module, one after the other, beginning with the one that is idle longest."""
        for _ in range(times):
            self._call(load, (module,))

    def _call(self, function: Callable[..., T], arguments: tuple[object, ...]) -> T:
        """Value of a call in an idle process; WorkerDied if that ends, else the errors of the function."""
        process = self._idle.get()
        try:
            send(process.stdin, (function, arguments))
            while (answer := pickle.loads(received(process.stdout)))[0] == "note":
                self.notes.put(answer[1])
        except (EOFError, OSError, MemoryError) as error:
            if isinstance(error, MemoryError):  # the unread rest of the answer would be taken for the next one
                process.kill()
            died = self._death(process)
            process = self._start(WorkerProcess, process)
            raise died from None
        finally:
            self._idle.put(process)
        kind, value = answer
        if kind == "error":
            raise value
        return value

    def _death(self, process: WorkerProcess | WorkerCopy) -> WorkerDied:
        code = process.wait()
        if code == -getattr(signal, "SIGKILL", 9):
            return WorkerDied(LimitError.exit_code, "its worker process was killed, perhaps for want of memory")
        how = f"by signal {-code} ({signal.strsignal(-code)})" if code < 0 else f"with code {code}"
        return WorkerDied(BubblemeshError.exit_code, f"its worker process ended {how}")

    def _start(
        self, kind: type[WorkerProcess] | type[WorkerCopy], instead_of: WorkerProcess | WorkerCopy | None = None
    ) -> WorkerProcess | WorkerCopy:
        """Start a process, in place of one that has died."""
        with self._lock:
            if self._stopped:
                raise WorkerDied(INTERRUPTED, "the workers have been stopped")
            try:
                process = kind(self._staging)
            except OSError as error:
                raise FileError(f"a worker process cannot be started: {error.strerror}: try fewer --jobs") from None
            if instead_of is not None:
                self.processes.remove(instead_of)
                instead_of.end()
            self.processes.add(process)
        return process


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Keep Ctrl-C, which goes to all processes of a terminal, from processes that start within the block."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
