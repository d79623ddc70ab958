"""Workers of a Dask cluster."""

import asyncio
import logging
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import CancelledError, Future
from contextlib import contextmanager, suppress
from functools import partial
from time import monotonic
from typing import Any, TypeVar
from uuid import uuid4

from bubblemesh import __version__
from bubblemesh.errors import CaseError, FileError, LimitError
from bubblemesh.workers.workers import Note, WorkerDied, Workers

T = TypeVar("T")

ADDRESS = re.compile(r"(tcp|tls|ws|wss|ucx)://.+:\d{1,5}")
PATIENCE = 5.0  # seconds that the scheduler has for its first answer
SILENCE = 30.0  # seconds that it has later, when there may be much else to do
REFRESH = 5.0  # seconds after which the number of workers is asked for again
SOON = 1.0  # the same while there are no workers
# Asked of each worker before it gets a job. The question uses nothing of the package: a worker that cannot unpickle
# what it gets dies, and so would, one after the other, all workers that get the same job. It loads what most jobs need,
# which shows that a worker has the dependencies; ``__import__`` gives the package, whose version it is.
VERSION = "__import__('bubblemesh.batch.worker').__version__"


@contextmanager
def cluster_workers(address: str) -> Iterator[Workers]:
    """Workers of the scheduler at ``tcp://host:port``; unfinished jobs are cancelled when the block ends.

    FileError if the extra is missing, or the scheduler does not answer; if it stops answering later, `Workers.capacity`
    raises that error.
    """
    client = _connected(address)
    executor = client.get_executor(pure=False)
    try:
        yield ClusterWorkers(address, client, executor)
    finally:
        with suppress(Exception):  # of a connection that is lost
            executor.shutdown(wait=False)
        with suppress(Exception):
            client.close(timeout=PATIENCE)


class ClusterWorkers(Workers):
    """Workers of a cluster; only those with the same version of bubblemesh as here get jobs.

    The scheduler is asked for its workers again and again, which also shows whether it is still there.
    """

    def __init__(self, address: str, client: Any, executor: Any) -> None:
        from distributed.client import ClosedClientError

        super().__init__()
        topic = f"bubblemesh-{uuid4()}"
        self.tell = partial(tell_client, topic)
        self.lost = (
            f"--cluster {address}: the scheduler is out of reach: start it, and give the command again with --resume"
        )
        self._gone = (ClosedClientError, OSError, CancelledError)
        self._address, self._client, self._executor = address, client, executor
        self._threads: dict[str, int] | None = None  # of each worker by its address, by the scheduler's last answer
        self._questions: dict[str, Future[str]] = {}  # for the version, to workers that have not answered
        self._problems: dict[str, str] = {}  # of the workers that have answered; empty if they are fit to mesh
        self._fit: Mapping[str, int] = {}  # threads of the workers that are fit
        self._refused: list[str] = []
        self._given: dict[Future[Any], frozenset[str]] = {}  # workers that each unfinished job is for
        self._call: Future[str] | None = None  # a first job: a cluster may start workers only when there is work
        client.subscribe_topic(topic, lambda event: self.notes.put(tuple(event[1])))
        self._ask()

    def submit(self, function: Callable[..., T], /, *arguments: object) -> Future[T]:
        """Call a function in a worker that is fit for it; in any worker, if no fit one is known yet."""
        future = self._submitted(function, *arguments, to=self._fit)
        if self._fit:
            self._given[future] = frozenset(self._fit)
            future.add_done_callback(lambda ended: self._given.pop(ended, None))
        return future

    def capacity(self) -> int:
        waited = monotonic() - self._asked
        if self._answer.done():
            try:
                self._threads = self._answer.result()
            except self._gone:
                raise FileError(self.lost) from None
            self._meet(self._threads)
            if waited > (REFRESH if self._fit else SOON):
                self._ask()
        elif waited > SILENCE:
            raise FileError(self.lost)
        return 2 * sum(self._fit.values())

    def missing(self) -> str | None:
        if self._threads == {}:
            return f"no workers are at {self._address}: waiting for them"
        if self._fit or self._questions or self._threads is None:
            return None
        return f"no workers at {self._address} are left that can mesh: waiting for others"

    def refused(self) -> list[str]:
        told, self._refused = self._refused, []
        return told

    def failure(self, error: BaseException) -> tuple[int, str]:
        from distributed.scheduler import KilledWorker

        if isinstance(error, WorkerDied):
            code, words = error.args
            return code, words
        if isinstance(error, KilledWorker):
            times = error.allowed_failures + 1
            return LimitError.exit_code, f"{times} workers in turn ended over it, perhaps for want of memory"
        cause = error.__cause__ or error  # Dask wraps errors that come when a worker unpickles the job
        advice = f"is bubblemesh {__version__} installed there, with the same Python?"
        return FileError.exit_code, f"no worker could take it: {type(cause).__name__}: {cause}: {advice}"

    def _ask(self) -> None:
        self._asked = monotonic()
        question = self._client.scheduler.ncores()  # not `nthreads`, which waits for ever
        self._answer: Future[dict[str, int]] = asyncio.run_coroutine_threadsafe(
            question, self._client.loop.asyncio_loop
        )

    def _submitted(self, function: Callable[..., T], /, *arguments: object, to: Iterable[str]) -> Future[T]:
        """Future of a call in one of some workers, or in any if none is named."""
        try:
            return self._executor.submit(function, *arguments, workers=[*to] or None)
        except self._gone:
            raise FileError(self.lost) from None

    def _meet(self, threads: Mapping[str, int]) -> None:
        """Ask new workers for their version, forget those that have left, and recall the jobs of the latter."""
        for address in self._questions.keys() - threads.keys():
            self._questions.pop(address).cancel()
        for address in threads.keys() - self._questions.keys() - self._problems.keys():
            self._questions[address] = self._submitted(eval, VERSION, to=[address])
        for address in [address for address, question in self._questions.items() if question.done()]:
            question = self._questions.pop(address)
            if not question.cancelled():
                self._problems[address] = problem = _problem(address, question)
                self._refused += [problem] if problem else []
        self._fit = {address: threads[address] for address in threads if self._problems.get(address) == ""}
        if threads and self._call is not None:
            self._call.cancel()
        self._call = None if threads else self._call or self._submitted(eval, VERSION, to=[])
        for future in [future for future, addresses in [*self._given.items()] if addresses.isdisjoint(threads)]:
            self.recalled.add(future)
            future.cancel()


def require_address(address: str) -> None:
    """Check that an address may be that of a scheduler; CaseError if not."""
    if not ADDRESS.fullmatch(address):
        raise CaseError(f"--cluster {address}: must be the address of a Dask scheduler, such as tcp://host:8786")


def _connected(address: str) -> Any:
    """Client of the scheduler at an address; FileError if Dask is missing or no scheduler answers."""
    try:
        import distributed
    except ModuleNotFoundError as error:
        raise FileError(
            f'{(error.name or "").partition(".")[0]} is needed for --cluster: pip install "bubblemesh[cluster]"'
        ) from None
    for name in [*logging.root.manager.loggerDict]:
        if name.startswith(("distributed", "tornado")):  # their messages on lost connections: ours follow
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    try:
        # First a plain question: a client waits for ever, or ends in disorder, if the answer is missing or not Dask's.
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
    """Kind of the Dask process that answers at the address."""
    import distributed

    dask: Any = distributed
    security = dask.Security().get_connection_args("client")
    async with dask.rpc(address, connection_args=security) as remote:
        return str((await remote.identity())["type"])


def _problem(address: str, question: Future[str]) -> str:
    """Why the worker at an address gets no cases, by its answer to the question for its version; else empty."""
    error = question.exception()
    if error is not None:
        found = f"cannot load bubblemesh ({type(error).__name__}: {error})"
    elif question.result() != __version__:
        found = f"has bubblemesh {question.result()}"
    else:
        return ""
    return f"the worker at {address} {found}, this process has {__version__}: it is left out: install the same for both"


def tell_client(topic: str, note: Note) -> None:
    """Send a note from a worker to the client."""
    from distributed import get_worker

    worker: Any = get_worker()
    worker.log_event(topic, note)
