"""A limit on the time of a run, which holds in all of its stages, wherever the run is."""

import ctypes
import sys
from contextlib import suppress
from functools import cache
from math import inf
from threading import Event, Lock, Thread, get_ident, local
from time import perf_counter
from typing import Literal, NamedTuple

from bubblemesh.errors import Key, LimitError

Stage = Literal[
    "reading",
    "geometry",
    "estimate",
    "spacing",
    "metric",
    "layers",
    "placement",
    "packing",
    "refinement",
    "quality",
    "partition",
    "writing",
]


class StageRow(NamedTuple):
    """What a run does in a stage, and what makes that take less time."""

    doing: str
    advice: str
    before_packing: bool = False  # whether there is no mesh yet to end with


STAGES: dict[Stage, StageRow] = {
    "reading": StageRow("reading the case", "make it shorter", before_packing=True),
    "geometry": StageRow("reading and checking the geometry", "give its rings fewer points", before_packing=True),
    "estimate": StageRow("estimating the error of the solution", "use a coarser mesh", before_packing=True),
    "spacing": StageRow(
        "checking the spacing", "use fewer and simpler terms, or rings of fewer points", before_packing=True
    ),
    "metric": StageRow("finding the sizes of the metric", "give it larger sizes, or no gradation", before_packing=True),
    "layers": StageRow("making boundary layers", "ask for fewer of them", before_packing=True),
    "placement": StageRow("placing bubbles", "coarsen the spacing"),
    "packing": StageRow("ending the packing", "coarsen the spacing"),
    "refinement": StageRow("adding nodes for angle_min or largest", "ask for less"),
    "quality": StageRow("measuring the mesh", "coarsen the spacing"),
    "partition": StageRow("dividing the mesh into parts", "coarsen the spacing"),
    "writing": StageRow("writing the files", "coarsen the spacing, or write fewer formats"),
}
GRACE, GRACE_SHARE = 0.6, 0.06  # seconds, or share of the limit, that a late packing has to end by itself
SHORT_GRACE, SHORT_GRACE_SHARE = 0.1, 0.01  # the same before the packing, where single calls may be long
AGAIN = 1.0  # seconds until `Late` is raised once more, as a library may have swallowed it
IMPORT_POLL = 0.02  # seconds after which to look again whether an import is over
LONGEST_WAIT = 3600.0  # seconds that a thread waits at a time


class Late(BaseException):
    """The time of a run is up; raised from another thread, wherever the run is."""


class Watchdog:
    """A thread that ends a run some time after its limit, by `Late` in the thread that has made the watchdog."""

    def __init__(self, begun: float, place: str) -> None:
        self.stage, self.limit = "reading", None  # type: Stage, float | None
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
        doing, advice, _ = STAGES[self.stage]
        problem = f"the time limit of {self.limit:g} s was over while {doing}: {advice}, or raise the limit"
        error = LimitError(f"{self._place}limits.seconds: {problem}")
        error.about = Key(["limits", "seconds"])
        return error

    def _overdue(self) -> float:
        """Seconds until the run is ended, in its present stage: a packing that has begun in time gets more."""
        short = STAGES[self.stage].before_packing
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


current = local()  # its ``watchdog`` is that of the run in the same thread


def present_watchdog() -> Watchdog | None:
    """The watchdog of the run in this thread, if it has one."""
    return getattr(current, "watchdog", None)


def enter(stage: Stage) -> None:
    """Note the stage that the run in this thread is in."""
    watchdog = present_watchdog()
    if watchdog is not None:
        watchdog.stage = stage


def allow(seconds: float | None) -> None:
    """Limit the time of the run in this thread as soon as the limit is known; an earlier limit stays."""
    watchdog = present_watchdog()
    if watchdog is not None:
        watchdog.begin(seconds)


def time_left() -> float:
    """Seconds that the run in this thread has left, negative if its time is up; infinite without a limit."""
    watchdog = present_watchdog()
    return inf if watchdog is None else watchdog.left


def settle() -> None:
    """Lift the time limit for the rest of the run in this thread: what it does now must not stop half-way.

    This is for the end of a run only, as nothing sets the limit again.
    """
    watchdog = present_watchdog()
    if watchdog is not None:
        watchdog.end()


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
