"""Limits on the time and the memory of a run, which hold in all of its stages."""

from collections.abc import Callable
from typing import TypeVar

from bubblemesh.process.memory_limit import MemoryLimit
from bubblemesh.process.watchdog import Late, Watchdog, current, present_watchdog

T = TypeVar("T")


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
    if present_watchdog() is not None:
        return call()
    watchdog, memory = Watchdog(begun, place), MemoryLimit(memory_mb, place)
    try:
        try:
            current.watchdog = watchdog
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
        current.watchdog = None
