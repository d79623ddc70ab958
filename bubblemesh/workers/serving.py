"""What runs in a worker process on this machine: it answers the calls of its parent process until that ends."""

import os
import pickle
import shutil
import signal
import tempfile
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from queue import SimpleQueue
from threading import Thread
from typing import IO, NoReturn

from bubblemesh.process.resources import keep_freed_memory, seldom_look_for_garbage
from bubblemesh.workers.frames import received, send, send_pickled
from bubblemesh.workers.workers import Note, travelling

LIBRARIES = ("OMP", "OPENBLAS", "MKL", "NUMEXPR", "BLIS")
THREADS = (*(f"{library}_NUM_THREADS" for library in LIBRARIES), "VECLIB_MAXIMUM_THREADS")

to_parent: list[IO[bytes]] = []  # the stream of answers


def serve_as_copy(calls: int, answers: int, staging: str) -> NoReturn:
    """Serve in a copy of the parent process by two descriptors of pipes; what else that has open is closed here."""
    try:
        # Both at once: where the parent has no standard streams, its pipes may have their numbers.
        for pipe, standard in zip((os.dup(calls), os.dup(answers)), (0, 1), strict=True):
            os.dup2(pipe, standard)
        for entry in [*Path("/proc/self/fd").iterdir()]:
            if (descriptor := int(entry.name)) > 2:
                with suppress(OSError):  # that of the list itself
                    os.close(descriptor)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        os.environ.update(dict.fromkeys(THREADS, "1"))
        serve(staging)
    finally:
        os._exit(1)


def serve(staging: str) -> None:
    """Answer calls until the parent process ends; temporary files go to its folder ``staging``."""
    seldom_look_for_garbage()
    keep_freed_memory()
    stream, calls = _taken(0, "rb"), SimpleQueue[bytes]()
    to_parent.append(_taken(1, "wb"))
    tempfile.tempdir = staging
    listener = Thread(target=_listen, args=(stream, calls, staging), daemon=True)
    listener.start()
    with suppress(OSError):  # error: nobody reads answers any more
        while True:
            send_pickled(to_parent[0], _answer(calls.get()))
    listener.join()


def load(module: str) -> None:
    """Load a module."""
    import_module(module)


def _answer(call: bytes) -> bytes:
    """Answer to a call, pickled; an answer that cannot be pickled becomes an error."""
    try:
        function, arguments = pickle.loads(call)
        return pickle.dumps(("value", function(*arguments)))
    except Exception as error:
        return pickle.dumps(("error", travelling(error)))


def _taken(descriptor: int, mode: str) -> IO[bytes]:
    """A standard stream for this module alone: what other modules read from or write to it is dropped."""
    stream = os.fdopen(os.dup(descriptor), mode)
    _silence(descriptor)
    return stream


def _silence(descriptor: int) -> None:
    nowhere = os.open(os.devnull, os.O_RDWR)
    os.dup2(nowhere, descriptor)
    os.close(nowhere)


def _listen(stream: IO[bytes], calls: "SimpleQueue[bytes]", staging: str) -> None:
    """Pass calls on; when the parent has ended, even by a crash, remove temporary files and end the process."""
    try:
        while True:
            calls.put(received(stream))
    except (EOFError, OSError):
        _silence(2)  # nobody reads errors any more
        shutil.rmtree(staging, ignore_errors=True)
    finally:
        os._exit(1)  # the parent replaces this process, if it was out of memory


def tell_parent(note: Note) -> None:
    """Send a note to the process that has started this one."""
    send(to_parent[0], ("note", note))
