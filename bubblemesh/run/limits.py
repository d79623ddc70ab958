"""The limits of a case on time and memory, which hold for all that is done with it."""

from collections.abc import Callable
from time import perf_counter
from typing import TypeVar

from bubblemesh.case import Case
from bubblemesh.process.limits import within

T = TypeVar("T")


def within_limits(case: Case, call: Callable[[], T], place: str = "") -> T:
    """Value of a call within the limits of a case, to which the time for loading the case counts.

    LimitError, whose message begins with the ``place``, if a limit is exceeded.
    """
    limits = case.limits
    return within(call, limits.seconds, limits.max_memory_mb, perf_counter() - case.origin.seconds, place)
