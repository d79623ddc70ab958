"""Workers of a Dask cluster."""

import asyncio
import logging
import re
from collections.abc import Iterator
from concurrent.futures import CancelledError, Future
from contextlib import contextmanager, suppress
from functools import partial
from queue import SimpleQueue
from time import monotonic
from typing import Any
from uuid import uuid4

from bubblemesh import __version__
from bubblemesh.batch.jobs import Note, Outcome
from bubblemesh.batch.workers import Workers
from bubblemesh.errors import CaseError, FileError, LimitError

ADDRESS = re.compile(r"(tcp|tls|ws|wss|ucx)://.+:\d{1,5}")
PATIENCE = 5.0  # seconds that the scheduler has for its first answer
SILENCE = 30.0  # seconds that it has later, when there may be much else to do
REFRESH = 5.0  # seconds after which the number of workers is asked for again
FEWEST = 4  # jobs to have submitted while there are no workers yet


@contextmanager
def cluster_workers(address: str) -> Iterator[Workers]:
    """The workers of the scheduler at ``tcp://host:port``; what is not finished when the block ends is cancelled.

    Raises
    ------
    FileError
        If the extra is missing, or the scheduler does not answer; later, that is one of the workers' capacity.
    """
    client = _connected(address)
    from distributed.client import ClosedClientError

    gone = (ClosedClientError, OSError)
    notes: SimpleQueue[Note] = SimpleQueue()
    topic = f"bubblemesh-{uuid4()}"
    executor = client.get_executor(pure=False)
    lost = f"--cluster {address}: the scheduler is out of reach: start it, and run the batch again with --resume"
    try:
        client.subscribe_topic(topic, lambda event: notes.put(Note(*event[1])))
        pulse = Pulse(client, lost, gone)
        missing = f"no workers are at {address}: waiting for them"
        yield Workers(
            executor,
            partial(tell_client, topic),
            notes,
            pulse.capacity,
            _failure,
            lost,
            gone,
            lambda: missing if pulse.threads == 0 else None,
        )
    finally:
        with suppress(Exception):  # of a connection that is lost
            executor.shutdown(wait=False)
        with suppress(Exception):
            client.close(timeout=PATIENCE)


def require_address(address: str) -> None:
    """Check that an address may be a scheduler's; a CaseError if not."""
    if not ADDRESS.fullmatch(address):
        raise CaseError(f"--cluster {address}: must be the address of a Dask scheduler, such as tcp://host:8786")


def _connected(address: str) -> Any:
    try:
        import distributed
    except ModuleNotFoundError as error:
        raise FileError(
            f'{(error.name or "").partition(".")[0]} is needed for --cluster: pip install "bubblemesh[cluster]"'
        ) from None
    for name in [*logging.root.manager.loggerDict]:
        if name.startswith("distributed"):  # what it has to say about lost connections comes in our words
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    try:
        # First a question on its own: a client that meets silence or nonsense waits for ever, or ends in disorder.
        kind = asyncio.run(asyncio.wait_for(_kind(address), PATIENCE))
        if kind != "Scheduler":
            raise FileError(f"--cluster {address}: a Dask {kind.lower()} answers: give the address of the scheduler")
        client: Any = distributed.Client
        return client(address, timeout=PATIENCE, set_as_default=False)
    except FileError:
        raise
    except Exception as error:
        why = "" if isinstance(error, OSError | TimeoutError) else f" ({type(error).__name__})"
        raise FileError(
            f"--cluster {address}: no Dask scheduler has answered within {PATIENCE:g} s{why}: is it running, and is "
            "the address right?"
        ) from None


async def _kind(address: str) -> str:
    """What sort of Dask process answers."""
    import distributed

    dask: Any = distributed
    security = dask.Security().get_connection_args("client")
    async with dask.rpc(address, connection_args=security) as remote:
        return str((await remote.identity())["type"])


class Pulse:
    """The scheduler's answers to one question that is asked again and again: how many threads its workers have."""

    def __init__(self, client: Any, lost: str, gone: tuple[type[Exception], ...]) -> None:
        self._client, self._lost = client, lost
        self._gone: tuple[type[BaseException], ...] = (*gone, CancelledError)
        self.threads: int | None = None  # as last told
        self._ask()

    def capacity(self) -> int:
        """Twice the number of threads, which may change.

        Raises
        ------
        FileError
            If the scheduler has been silent for too long.
        """
        waited = monotonic() - self._asked
        if self._answer.done():
            try:
                self.threads = sum(self._answer.result().values())
            except self._gone:
                raise FileError(self._lost) from None
            if waited > REFRESH:
                self._ask()
        elif waited > SILENCE:
            raise FileError(self._lost)
        return max(2 * (self.threads or 0), FEWEST)

    def _ask(self) -> None:
        self._asked = monotonic()
        question = self._client.scheduler.ncores()
        # Not by `nthreads`, which waits for ever.
        self._answer: Future[dict[str, int]] = asyncio.run_coroutine_threadsafe(
            question, self._client.loop.asyncio_loop
        )


def _failure(error: BaseException) -> Outcome:
    from distributed.scheduler import KilledWorker

    if isinstance(error, KilledWorker):
        times = error.allowed_failures + 1
        return Outcome(LimitError.exit_code, f"{times} workers in turn ended over it, perhaps for want of memory")
    cause = error.__cause__ or error  # Dask wraps what went wrong when a worker unpacked the job
    return Outcome(
        FileError.exit_code,
        f"no worker could take it: {type(cause).__name__}: {cause}: is bubblemesh {__version__} installed there, with "
        "the same Python?",
    )


def tell_client(topic: str, note: Note) -> None:
    """Send a note from a worker to the client."""
    from distributed import get_worker

    worker: Any = get_worker()
    worker.log_event(topic, (note.number, note.round, note.nodes))
