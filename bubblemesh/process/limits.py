"""Limits on the time and the memory of a run, which hold in all of its stages."""

import ctypes
import errno
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import cache
from math import inf
from pathlib import Path
from threading import Event, Lock, Thread, get_ident, local
from time import perf_counter
from typing import TypeVar

from bubblemesh.errors import Key, LimitError

T = TypeVar("T")

# What a run does in each stage, and what makes that take less time.
STAGES = {
    "reading": ("reading the case", "make it shorter"),
    "geometry": ("reading and checking the geometry", "give its rings fewer points"),
    "estimate": ("estimating the error of the solution", "use a coarser mesh"),
    "spacing": ("checking the spacing", "use fewer and simpler terms, or rings of fewer points"),
    "metric": ("finding the sizes of the metric", "give it larger sizes, or no gradation"),
    "layers": ("making boundary layers", "ask for fewer of them"),
    "placement": ("placing bubbles", "coarsen the spacing"),
    "packing": ("ending the packing", "coarsen the spacing"),
    "refinement": ("adding nodes for angle_min or largest", "ask for less"),
    "quality": ("measuring the mesh", "coarsen the spacing"),
    "partition": ("dividing the mesh into parts", "coarsen the spacing"),
    "writing": ("writing the files", "coarsen the spacing, or write fewer formats"),
}
GRACE, GRACE_SHARE = 0.6, 0.06  # seconds, or share of the limit, that a late packing has to end by itself
BEFORE_PACKING = "reading", "geometry", "estimate", "spacing", "metric", "layers"  # there is no mesh yet to end with
SHORT_GRACE, SHORT_GRACE_SHARE = 0.1, 0.01  # the same for these stages, whose single calls may be long
AGAIN = 1.0  # seconds until `Late` is raised once more, as a library may have swallowed it
IMPORT_POLL = 0.02  # seconds after which to look again whether an import is over
LONGEST_WAIT = 3600.0  # seconds that a thread waits at a time
MEGABYTE = 1e6
MEMORY = Path("/proc/self/statm")  # of Linux: memory of the process, in pages
HELD, DATA = 1, 5  # positions in that file of the pages in memory, and of all pages for data


class Late(BaseException):
    """The time of a run is up; raised from another thread, wherever the run is."""


class Watchdog:
    """A thread that ends a run some time after its limit, by `Late` in the thread that has made the watchdog."""

    def __init__(self, begun: float, place: str) -> None:
        self.stage, self.limit = "reading", None  # type: str, float | None
        self._begun, self._place, self._thread = begun, place, get_ident()
        self._armed, self._lock, self._ended = False, Lock(), Event()

    @property
    def left(self) -> float:
        """Seconds until the time is up, negative then; infinite without a limit."""
        return inf if self.limit is None else self.limit - (perf_counter() - self._begun)

    def begin(self, limit: float | None) -> None:
        """Watch the limit from now on, unless it is None; LimitError if the time is up already."""
        if limit is None or self.limit is not None:
            return
        self.limit, self._armed = limit, True
        if self._overdue() <= 0:
            raise self.error()
        Thread(target=self._watch, name="bubblemesh-time-limit", daemon=True).start()

    def end(self) -> None:
        """Stop watching: `Late` is not raised after this, even if it was on its way."""
        while self._armed:
            with suppress(Late):
                with self._lock:  # the thread raises nothing while it is held
                    self._armed = False
                # A `Late` on its way arrives here at the latest: Python looks for it when a loop begins anew. To take
                # it back would leave Python looking for ever, and its profiler would hang.
                for _ in range(2):
                    _keep_from_standard_error()
        self._ended.set()

    def error(self) -> LimitError:
        """Error of a run that was ended, with its stage and what to do."""
        doing, advice = STAGES[self.stage]
        problem = f"the time limit of {self.limit:g} s was over while {doing}: {advice}, or raise the limit"
        error = LimitError(f"{self._place}limits.seconds: {problem}")
        error.about = Key(["limits", "seconds"])
        return error

    def _overdue(self) -> float:
        """Seconds until the run is ended, in its present stage: a packing that has begun in time gets more."""
        short = self.stage in BEFORE_PACKING
        grace, share = (SHORT_GRACE, SHORT_GRACE_SHARE) if short else (GRACE, GRACE_SHARE)
        return self.left + max(grace, share * (self.limit or 0.0))

    def _watch(self) -> None:
        wait = self._overdue()
        while not self._ended.wait(min(max(wait, 0.0), LONGEST_WAIT)):
            wait = self._overdue()
            if wait > 0:
                continue
            wait = IMPORT_POLL if _importing(self._thread) else AGAIN
            with self._lock:
                if self._armed and wait == AGAIN:
                    _keep_from_standard_error()
                    _raise_in(self._thread, Late)


class MemoryLimit:
    """Limit on the memory of the process, on systems that can set one; of several limits the least one holds."""

    _lock = Lock()
    _before: tuple[int, int] | None = None  # the system's limits before ours
    _active: "list[MemoryLimit]" = []  # noqa: RUF012 - of the whole process

    def __init__(self, megabytes: float | None, place: str) -> None:
        self.megabytes, self._place = megabytes, place
        self._data = 0  # bytes that the process may have for data

    def begin(self) -> None:
        """Limit the memory from now on; LimitError if the process holds as much already."""
        if self.megabytes is None or not memory_can_be_limited():
            return
        import resource

        pages = [int(number) * resource.getpagesize() for number in MEMORY.read_text().split()]
        data, held = pages[DATA], pages[HELD]
        if held > self.megabytes * MEGABYTE:
            raise self._error(f"the program alone holds {held / MEGABYTE:.0f} MB: raise the limit")
        # The limit is on data, not on all that is mapped: the heap of each thread is mapped whole in advance.
        self._data = data + int(self.megabytes * MEGABYTE) - held
        with self._lock:
            if MemoryLimit._before is None:
                MemoryLimit._before = resource.getrlimit(resource.RLIMIT_DATA)
            self._active.append(self)
            self._apply()

    def end(self) -> None:
        """Lift the limit."""
        with self._lock:
            if self in self._active:
                self._active.remove(self)
                self._apply()

    def error(self, cause: BaseException) -> LimitError | None:
        """The LimitError of a run that was ended by ``cause``; None if the limit did not bring that about."""
        if self not in self._active or not _lacks_memory(cause):
            return None
        return self._error(f"more than the limit of {self.megabytes:g} MB is needed: coarsen the spacing or raise it")

    def _error(self, problem: str) -> LimitError:
        error = LimitError(f"{self._place}limits.max_memory_mb: {problem}")
        error.about = Key(["limits", "max_memory_mb"])
        return error

    def _apply(self) -> None:
        import resource

        assert MemoryLimit._before is not None
        soft, hard = MemoryLimit._before
        given = [value for value in (soft, hard) if value != resource.RLIM_INFINITY]
        least = min([*given, *(limit._data for limit in self._active)], default=soft)
        resource.setrlimit(resource.RLIMIT_DATA, (least if self._active else soft, hard))
        if not self._active:
            MemoryLimit._before = None


def memory_can_be_limited() -> bool:
    """Whether the system can limit the memory of a process, and shows how much it holds."""
    return MEMORY.exists()


def unlimited_memory(megabytes: float | None) -> list[str]:
    """Warning about a limit on memory if this system cannot set it."""
    if megabytes is None or memory_can_be_limited():
        return []
    return ["limits.max_memory_mb: this system cannot limit the memory of a process: watch it, or run on Linux"]


_current = local()  # its ``watchdog`` is that of the run in the same thread


def within(call: Callable[[], T], seconds: float | None, memory_mb: float | None, begun: float, place: str = "") -> T:
    """Value of a call with limits on its time and on the memory of this process.

    Parameters
    ----------
    call
        Function to call. A call inside of another one has the limits of the outer one.
    seconds, memory_mb
        Limits; None for no limit.
    begun
        Reading of ``perf_counter`` from which the seconds count.
    place
        What the message of an error begins with.

    Raises
    ------
    LimitError
        If a limit is exceeded; the message has the stage and what to do.
    """
    if _watchdog() is not None:
        return call()
    watchdog, memory = Watchdog(begun, place), MemoryLimit(memory_mb, place)
    try:
        try:
            _current.watchdog = watchdog
            watchdog.begin(seconds)
            memory.begin()
            return call()
        finally:
            watchdog.end()
    except Late:
        watchdog.end()  # once more, as `Late` may have come before the first call was done
        raise watchdog.error() from None
    except Exception as cause:
        error = memory.error(cause)
        if error is None:
            raise
        raise error from None
    finally:
        memory.end()
        _current.watchdog = None


def enter(stage: str) -> None:
    """Note the stage that the run in this thread is in."""
    watchdog = _watchdog()
    if watchdog is not None:
        watchdog.stage = stage


def allow(seconds: float | None) -> None:
    """Limit the time of the run in this thread as soon as the limit is known; an earlier limit stays."""
    watchdog = _watchdog()
    if watchdog is not None:
        watchdog.begin(seconds)


def time_left() -> float:
    """Seconds that the run in this thread has left, negative if its time is up; infinite without a limit."""
    watchdog = _watchdog()
    return inf if watchdog is None else watchdog.left


def settle() -> None:
    """Lift the time limit for the rest of the run in this thread: what it does now must not stop half-way.

    This is for the end of a run only, as nothing sets the limit again.
    """
    watchdog = _watchdog()
    if watchdog is not None:
        watchdog.end()


class Stopwatch:
    """A watch that measures the stages of a run, and goes on from the ``seconds`` of stages before."""

    def __init__(self, seconds: Mapping[str, float] | None = None) -> None:
        self._seconds = dict(seconds or {})
        self._within = list[str]()  # the stages of the blocks that have begun, the innermost last

    @property
    def seconds(self) -> dict[str, float]:
        """Seconds of each stage so far."""
        return dict(self._seconds)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Enter a stage, and add the time of the block to it, without the times of stages within the block.

        After a stage within another one that is entered again, unless an exception ends both.
        """
        begun, others = perf_counter(), -sum(self._seconds.values())
        enter(name)
        self._within.append(name)
        try:
            yield
        finally:
            self._within.pop()
            others += sum(self._seconds.values())
            self._seconds[name] = self._seconds.get(name, 0.0) + perf_counter() - begun - others
        if self._within:
            enter(self._within[-1])


def _watchdog() -> Watchdog | None:
    return getattr(_current, "watchdog", None)


def _raise_in(thread: int, exception: type[BaseException]) -> None:
    """Raise an exception in a thread as soon as it runs Python again."""
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), ctypes.py_object(exception))


@cache
def _keep_from_standard_error() -> None:
    """Keep Python from printing a `Late` that it must ignore, as in a destructor; `Late` is raised again later."""
    tell = sys.unraisablehook

    def tell_others(ignored: "sys.UnraisableHookArgs") -> None:
        if ignored.exc_type is not Late:
            tell(ignored)

    sys.unraisablehook = tell_others


def _importing(thread: int) -> bool:
    """Whether a thread is loading a module, which an exception would leave half loaded."""
    frame = sys._current_frames().get(thread)
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False


def _lacks_memory(error: BaseException) -> bool:
    """Whether an error of Python, the system, GEOS or the loader of libraries is about memory."""
    return any(
        isinstance(one, MemoryError)
        or (isinstance(one, OSError) and one.errno == errno.ENOMEM)
        # These two tell it by their texts alone.
        or (isinstance(one, ImportError) and "Cannot allocate memory" in str(one))
        or (type(one).__name__ == "GEOSException" and "bad_alloc" in str(one))
        for one in (error, error.__cause__)
    )
